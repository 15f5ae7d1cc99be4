"""Merging of two saved maps.

The sessions of the second map are added to the first map, as if they were recorded again. Sessions that the second map has
joined stay joined.
"""

import numpy as np

from lexis.config import Config
from lexis.errors import MapError
from lexis.perception import Encoder, embedding_of
from lexis.slam import Slam
from lexis.types import LexisMap, Observation
from lexis.verification import Verifier, verify


def merge(
    first: LexisMap, second: LexisMap, encoder: Encoder, config: Config | None = None, verifier: Verifier = verify
) -> LexisMap:
    """Add the keyframes of the second map to the first map, and find the loops within and between both.

    A part of the second map that is not recognised in the first map stays a component of its own.

    Args:
        first: the map whose frame the result has.
        second: the map whose keyframes are added.
        encoder: the encoder that made both maps.
        config: settings; None: defaults.
        verifier: the function that verifies loops.

    Raises:
        MapError: the maps differ in their encoder, camera or room names.
    """
    slam = Slam(second.camera, encoder, second.room_names, config, verifier, map=first)
    slam.replay(second)
    return slam.finish()


def check_apart(first: LexisMap, second: LexisMap) -> None:
    """Raise MapError if a keyframe is in both maps, for example because the second map continues the first one."""
    own = {(keyframe.stamp, keyframe.embedding.tobytes()) for keyframe in first.keyframes}
    shared = (keyframe for keyframe in second.keyframes if (keyframe.stamp, keyframe.embedding.tobytes()) in own)
    if (twice := next(shared, None)) is not None:
        raise MapError(f"merge: both maps hold the image taken at {twice.stamp:.3f} s; valid: maps of different recordings")


def holds_image(map: LexisMap, observation: Observation, encoder: Encoder) -> bool:
    """Return whether a map has a keyframe with the stamp and the image of an observation, by the map's encoder."""
    same_time = [keyframe for keyframe in map.keyframes if keyframe.stamp == observation.stamp]
    if not same_time:
        return False
    embedding = embedding_of(observation.image, encoder)
    return any(np.array_equal(keyframe.embedding, embedding) for keyframe in same_time)
