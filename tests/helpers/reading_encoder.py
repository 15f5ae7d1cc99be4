"""An encoder for tests in which images do not matter: it knows the vectors of a few texts."""

import numpy as np


class ReadingEncoder:
    """Looks up the vectors of texts in a dictionary; it has the name and the fingerprint of an `EncoderId`."""

    def __init__(self, vectors, identity):
        self.vectors = vectors
        self.name, self.fingerprint = identity.name, identity.fingerprint

    def encode_image(self, image):
        raise NotImplementedError

    def encode_rooms(self, names):
        return self.encode_texts(names)

    def encode_texts(self, texts):
        return np.stack([self.vectors[text] for text in texts])
