"""An encoder for tests of what has nothing to do with labels."""

import numpy as np


class BlindEncoder:
    """Tells nothing apart."""

    name = fingerprint = "blind"

    def encode_image(self, image):
        return np.eye(1, 2, dtype=np.float32)[0]

    def encode_rooms(self, names):
        return np.tile(np.eye(1, 2, dtype=np.float32), (len(names), 1))
