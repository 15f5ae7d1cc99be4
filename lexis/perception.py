"""The embedding and the features of an image, computed from the image or sent in place of the image (`Percept`)."""

from collections.abc import Sequence
from typing import Protocol, runtime_checkable

import numpy as np
from jaxtyping import Float32

from lexis.errors import EncoderError
from lexis.features import FeatureExtractor
from lexis.inputs import type_of, wrong_norm
from lexis.types import Features, Image, Percept


@runtime_checkable
class Encoder(Protocol):
    """The interface that LEXIS needs from a vision-language model."""

    @property
    def name(self) -> str:
        """Argument with which `load_encoder` loads this encoder again."""
        ...

    @property
    def fingerprint(self) -> str:
        """Hash that is equal for two encoders if and only if their embeddings can be compared."""
        ...

    def encode_image(self, image: Image) -> Float32[np.ndarray, "d"]:
        """CLIP embedding of an RGB image (f_CLIP in the paper), with unit norm."""
        ...

    def encode_rooms(self, names: Sequence[str]) -> Float32[np.ndarray, "rooms d"]:
        """Text embedding of every room name (f_TEXT in the paper), with unit norm."""
        ...


@runtime_checkable
class TextEncoder(Encoder, Protocol):
    """An encoder that can also embed arbitrary texts."""

    def encode_texts(self, texts: Sequence[str]) -> Float32[np.ndarray, "texts d"]:
        """Text embedding of every text, with unit norm. The texts are not put into prompts, as room names are."""
        ...


def check_room_embeddings(text: object, rooms: int, encoder: Encoder) -> None:
    """Raise EncoderError unless the embeddings of room names are one finite vector of unit norm for each name."""
    if not (isinstance(text, np.ndarray) and text.dtype.kind == "f" and text.ndim == 2 and len(text) == rooms):
        found = f"the embeddings of {rooms} room names are {type_of(text)}"
        raise EncoderError(f"encoder {encoder.name}: {found}; valid: float32 ({rooms}, d)")
    for i, embedding in enumerate(text):
        if (norm := wrong_norm(embedding)) is not None:
            raise EncoderError(
                f"encoder {encoder.name}: the embedding of room name {i} has norm {norm:.3g}; valid: unit norm"
            )


def embedding_of(seen: Image | Percept, encoder: Encoder, size: int | None = None) -> Float32[np.ndarray, "d"]:
    """CLIP embedding of an image (f_CLIP in the paper), copied because sensors and encoders may reuse their arrays.

    Raises EncoderError unless the encoder gives a vector of unit norm, and of `size` numbers, as many as for room names.
    Percepts are checked with their observation.
    """
    if isinstance(seen, Percept):
        return seen.embedding.astype(np.float32)
    given: object = encoder.encode_image(seen)
    if not (isinstance(given, np.ndarray) and given.dtype.kind == "f"):
        raise EncoderError(f"encoder {encoder.name}: the embedding of an image is {type_of(given)}; valid: float32 (d,)")
    embedding = given.astype(np.float32)
    if embedding.ndim != 1:
        raise EncoderError(f"encoder {encoder.name}: the embedding of an image has shape {embedding.shape}; valid: (d,)")
    if size is not None and len(embedding) != size:
        found = f"the embedding of an image has {len(embedding)} numbers"
        raise EncoderError(f"encoder {encoder.name}: {found}; valid: {size}, as those of room names")
    if (norm := wrong_norm(embedding)) is not None:
        raise EncoderError(f"encoder {encoder.name}: the embedding of an image has norm {norm:.3g}; valid: unit norm")
    return embedding


def features_of(seen: Image | Percept, extractor: FeatureExtractor) -> Features:
    """AKAZE features of an image (f_AKAZE in the paper), copied because sensors may reuse their arrays."""
    if isinstance(seen, Percept):
        return Features(seen.features.keypoints.astype(np.float32), seen.features.descriptors.copy())
    return extractor.extract(seen)
