"""Checks that a map was made with a given encoder, because embeddings of different models cannot be compared."""

import numpy as np
from jaxtyping import Float32

from lexis.errors import MapError
from lexis.perception import Encoder
from lexis.types import LexisMap


def check_encoder(map: LexisMap, encoder: Encoder) -> None:
    """Raise MapError unless the encoder's embeddings can be compared with the map's embeddings."""
    own = map.encoder
    if encoder.fingerprint != own.fingerprint:
        raise MapError(
            f"the map was made with encoder {own.name!r}, weights {own.fingerprint[:8]}, but the given {encoder.name!r} has "
            f"weights {encoder.fingerprint[:8]}: similarities across weights mean nothing; valid: --encoder with the map's "
            "own weights, or a new map of the recording"
        )


def check_embedding_size(map: LexisMap, texts: Float32[np.ndarray, "*n d"]) -> None:
    """Raise MapError unless the map's embeddings are as long as the encoder's embeddings of texts.

    They can differ although the encoder is that of the map, because other programs may have changed an imported map.
    """
    size = len(map.keyframes[0].embedding)
    if size != texts.shape[-1]:
        raise MapError(
            f"the map's embeddings have {size} numbers, and those of its encoder {map.encoder.name!r} have "
            f"{texts.shape[-1]}; valid: a map with the encoder's own embeddings"
        )
