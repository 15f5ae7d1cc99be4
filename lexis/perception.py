"""What LEXIS makes of one observation: an embedding and key points, its own or those that came instead of the image."""

from collections.abc import Sequence
from typing import Protocol, runtime_checkable

import numpy as np
from jaxtyping import Float32

from lexis.features import FeatureExtractor
from lexis.types import Features, Image, Observation, Percept


@runtime_checkable
class Encoder(Protocol):
    """What LEXIS needs of a vision-language model."""

    @property
    def name(self) -> str:
        """What to ask `load_encoder` for to get this one again."""
        ...

    @property
    def fingerprint(self) -> str:
        """Equal for two encoders if and only if the embeddings of one can be compared with those of the other."""
        ...

    def encode_image(self, image: Image) -> Float32[np.ndarray, "d"]:
        """f_CLIP of an RGB image, unit norm."""
        ...

    def encode_rooms(self, names: Sequence[str]) -> Float32[np.ndarray, "rooms d"]:
        """f_TEXT of every room name, unit norm."""
        ...


@runtime_checkable
class TextEncoder(Encoder, Protocol):
    """An encoder that reads free words too."""

    def encode_texts(self, texts: Sequence[str]) -> Float32[np.ndarray, "texts d"]:
        """f_TEXT of every text as it stands, unit norm."""
        ...


def embedding_of(observation: Observation, encoder: Encoder) -> Float32[np.ndarray, "d"]:
    """f_CLIP of an observation, in an array of its own: a sensor or an encoder may reuse the one that it hands over."""
    seen = observation.image
    return (seen.embedding if isinstance(seen, Percept) else encoder.encode_image(seen)).copy()


def features_of(observation: Observation, extractor: FeatureExtractor) -> Features:
    """f_AKAZE of an observation, in arrays of their own: a sensor may reuse those that it hands over."""
    seen = observation.image
    if isinstance(seen, Percept):
        return Features(seen.features.keypoints.copy(), seen.features.descriptors.copy())
    return extractor.extract(seen)
