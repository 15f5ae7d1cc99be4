"""An encoder for walks on a circle without images, whose percepts bring their embeddings with them."""

import numpy as np


class CircleEncoder:
    """Embeddings have four dimensions; the first two stand for the first two room names."""

    name = fingerprint = "circle"

    def encode_image(self, image):
        raise AssertionError("there are no images")

    def encode_rooms(self, names):
        return np.eye(len(names), 4, dtype=np.float32)
