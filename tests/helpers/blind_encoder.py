"""An encoder for tests in which room labels do not matter."""

import numpy as np


class BlindEncoder:
    """Maps all images and all room names to the same vector, so that every label is equally likely."""

    name = fingerprint = "blind"

    def encode_image(self, image):
        return np.eye(1, 2, dtype=np.float32)[0]

    def encode_rooms(self, names):
        return np.tile(np.eye(1, 2, dtype=np.float32), (len(names), 1))
