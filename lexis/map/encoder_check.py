"""A check that a map was made with a given encoder, because embeddings of different models cannot be compared."""

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
