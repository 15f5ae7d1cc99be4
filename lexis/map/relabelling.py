"""Other room names for a map that exists: labels, rooms and floors anew from the stored embeddings, no image encoded."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from lexis.config import Config
from lexis.inputs import check_room_names
from lexis.map.encoder_check import check_encoder
from lexis.perception import Encoder
from lexis.semantics import derive
from lexis.types import LexisMap


def relabel(map: LexisMap, room_names: Sequence[str], encoder: Encoder, config: Config | None = None) -> LexisMap:
    """The map as it would be labelled with another vocabulary; poses, loops and candidates stay as they are.

    Args:
        map: keeps its embeddings; its old room names play no part.
        room_names: the new vocabulary.
        encoder: the one that made the map.
        config: of labels and segmentation, as the map was made with.

    Raises:
        LexisError: the room names are unusable, or the encoder is another.
    """
    check_room_names(room_names)
    check_encoder(map, encoder)
    names = tuple(room_names)
    embeddings = np.array([keyframe.embedding for keyframe in map.keyframes])
    meaning = derive(embeddings, map.T_W_B, encoder.encode_rooms(names), names, config or Config())
    return replace(
        map,
        room_names=names,
        similarities=meaning.similarities,
        baseline_labels=meaning.baseline_labels,
        labels=meaning.labels,
        floors=meaning.floors,
        rooms=meaning.rooms,
    )
