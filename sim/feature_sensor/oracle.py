"""`Oracle`: an encoder without error, to test the stages after the encoder. Never report its results as LEXIS's.

The embedding of a view holds the true share of the image for each room label and for each kind of object. The embedding of a
room name is the unit vector along the dimension for this label.
"""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float32

from lexis.errors import EncoderError
from lexis.types import Image, Poses
from sim.feature_sensor.surroundings import OBJECTS
from sim.feature_sensor.visible_shares import VisibleShares
from sim.fidelity import ORACLE
from worlds.labels import ROOM_LABELS

_NOTHING = len(ROOM_LABELS)
"""Index of the embedding's dimension for views that show no room.

The dimensions before this one stand for room labels. The dimensions after it stand for kinds of objects, which distinguish
places with equal labels.
"""
_SIZE = _NOTHING + 1 + len(OBJECTS)


class Oracle:
    """An encoder without error. It encodes room names only; the feature sensor embeds views with `true_embeddings`."""

    @property
    def name(self) -> str:
        """Name of the encoder, as in `Scenario.encoder`."""
        return ORACLE

    @property
    def fingerprint(self) -> str:
        """Fingerprint of the encoder, which is constant because there is only one oracle."""
        return ORACLE

    def encode_image(self, image: Image) -> Float32[np.ndarray, "d"]:
        """Raise EncoderError, because the oracle cannot encode images."""
        raise EncoderError("oracle: cannot encode images; valid: percepts of the feature sensor")

    def encode_rooms(self, names: Sequence[str]) -> Float32[np.ndarray, "rooms d"]:
        """Return a unit vector for each label, one dimension per label. Raises EncoderError for a name that is no label."""
        if unknown := [name for name in names if name not in ROOM_LABELS]:
            raise EncoderError(f"oracle: knows no room {unknown[0]!r}; valid: {', '.join(ROOM_LABELS)}")
        return np.eye(_SIZE, dtype=np.float32)[[ROOM_LABELS.index(name) for name in names]]


def true_embeddings(views: VisibleShares, T_W_B: Poses) -> Float32[np.ndarray, "n d"]:
    """Return the oracle's embeddings of views: shares of room labels and of kinds of objects, scaled to unit norm."""
    rows = np.zeros((len(T_W_B), _SIZE), np.float32)
    np.add.at(rows.T, views.around.labels, views.of_rooms().T.astype(np.float32))
    rows[:, _NOTHING + 1 :] = views.of_kinds()[:, : len(OBJECTS)]
    rows[~rows.any(axis=1), _NOTHING] = 1.0
    return np.asarray(rows / np.linalg.norm(rows, axis=1, keepdims=True))
