"""The interface of an encoder in the benchmark, and a cache of text embeddings, since many houses use the same texts."""

from collections.abc import Callable, Sequence
from typing import Protocol, TypeAlias, runtime_checkable

import numpy as np
from jaxtyping import Float32, UInt8

Embed: TypeAlias = Callable[[Sequence[str]], Float32[np.ndarray, "texts d"]]
Images: TypeAlias = Sequence[UInt8[np.ndarray, "_ _ 3"]] | UInt8[np.ndarray, "images h w 3"]
Known: TypeAlias = dict[str, Float32[np.ndarray, "d"]]
_BATCH = 64


@runtime_checkable
class ImageTextEncoder(Protocol):
    """Interface of an encoder, which `lexis.encoder.open_clip_encoder.OpenClipEncoder` provides."""

    @property
    def temperature(self) -> float:
        """Temperature of the probabilities softmax(similarities / temperature)."""
        ...

    def encode_images(self, images: Images) -> Float32[np.ndarray, "images d"]:
        """Return embeddings of RGB images, with unit norm."""
        ...

    def encode_rooms(self, names: Sequence[str]) -> Float32[np.ndarray, "rooms d"]:
        """Return embeddings of room names, each averaged over prompts, with unit norm."""
        ...

    def encode_texts(self, texts: Sequence[str]) -> Float32[np.ndarray, "texts d"]:
        """Return embeddings of texts without prompts around them, with unit norm."""
        ...


class EmbeddedTexts:
    """A cache of text embeddings that embeds new texts in batches."""

    def __init__(self, encoder: ImageTextEncoder) -> None:
        self._encoder = encoder
        self._rooms: Known = {}
        self._texts: Known = {}

    def rooms(self, names: Sequence[str]) -> Float32[np.ndarray, "rooms d"]:
        """Return embeddings of room names, computed by `encode_rooms`."""
        return _looked_up(self._rooms, names, self._encoder.encode_rooms)

    def texts(self, texts: Sequence[str]) -> Float32[np.ndarray, "texts d"]:
        """Return embeddings of texts without prompts, computed by `encode_texts`."""
        return _looked_up(self._texts, texts, self._encoder.encode_texts)


def _looked_up(known: Known, texts: Sequence[str], embed: Embed) -> Float32[np.ndarray, "texts d"]:
    new = [text for text in dict.fromkeys(texts) if text not in known]
    for i in range(0, len(new), _BATCH):
        batch = new[i : i + _BATCH]
        known.update(zip(batch, embed(batch), strict=True))
    return np.array([known[text] for text in texts], np.float32)
