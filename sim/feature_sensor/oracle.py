"""`oracle`: an encoder without error, for tests of what comes after the encoder. No figure of LEXIS is its.

Its embedding of a view is the true share of the image that every label of room (and kind of object) fills, its
embedding of a room name the dimension of that label.
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
"""The dimension of a view of no room at all; then come the kinds of objects, which tell places apart."""
_SIZE = _NOTHING + 1 + len(OBJECTS)


class Oracle:
    """Reads room labels; what is seen has to come as percepts."""

    @property
    def name(self) -> str:
        """As `RunConfig.encoder` names it."""
        return ORACLE

    @property
    def fingerprint(self) -> str:
        """There is but one."""
        return ORACLE

    def encode_image(self, image: Image) -> Float32[np.ndarray, "d"]:
        """Raise EncoderError: it sees no images."""
        raise EncoderError("the oracle sees no images; valid: percepts of the feature sensor")

    def encode_rooms(self, names: Sequence[str]) -> Float32[np.ndarray, "rooms d"]:
        """A dimension for every label. Raises EncoderError for other names."""
        if unknown := [name for name in names if name not in ROOM_LABELS]:
            raise EncoderError(f"the oracle knows no room {unknown[0]!r}; valid: {', '.join(ROOM_LABELS)}")
        return np.eye(_SIZE, dtype=np.float32)[[ROOM_LABELS.index(name) for name in names]]


def true_embeddings(views: VisibleShares, T_W_B: Poses) -> Float32[np.ndarray, "n d"]:
    """What the oracle's percepts hold: the shares of labels and of objects, unit norm."""
    rows = np.zeros((len(T_W_B), _SIZE), np.float32)
    np.add.at(rows.T, views.around.labels, views.of_rooms().T.astype(np.float32))
    rows[:, _NOTHING + 1 :] = views.of_kinds()[:, : len(OBJECTS)]
    rows[~rows.any(axis=1), _NOTHING] = 1.0
    return np.asarray(rows / np.linalg.norm(rows, axis=1, keepdims=True))
