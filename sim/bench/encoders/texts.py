"""What the benchmark needs of an encoder, and its texts, each embedded once: many houses share their words."""

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
    """`lexis.encoder.open_clip_encoder.OpenClipEncoder`, or anything like it."""

    @property
    def temperature(self) -> float:
        """softmax(similarities / temperature) are its probabilities."""
        ...

    def encode_images(self, images: Images) -> Float32[np.ndarray, "images d"]:
        """Of RGB images, unit norm."""
        ...

    def encode_rooms(self, names: Sequence[str]) -> Float32[np.ndarray, "rooms d"]:
        """Of names of rooms, unit norm."""
        ...

    def encode_texts(self, texts: Sequence[str]) -> Float32[np.ndarray, "texts d"]:
        """Of texts as they stand, unit norm."""
        ...


class EmbeddedTexts:
    """Looks texts up, and embeds those that are new."""

    def __init__(self, encoder: ImageTextEncoder) -> None:
        self._encoder = encoder
        self._rooms: Known = {}
        self._texts: Known = {}

    def rooms(self, names: Sequence[str]) -> Float32[np.ndarray, "rooms d"]:
        """Names of rooms, as `encode_rooms` has them."""
        return _looked_up(self._rooms, names, self._encoder.encode_rooms)

    def texts(self, texts: Sequence[str]) -> Float32[np.ndarray, "texts d"]:
        """Texts as they stand."""
        return _looked_up(self._texts, texts, self._encoder.encode_texts)


def _looked_up(known: Known, texts: Sequence[str], embed: Embed) -> Float32[np.ndarray, "texts d"]:
    new = [text for text in dict.fromkeys(texts) if text not in known]
    for i in range(0, len(new), _BATCH):
        batch = new[i : i + _BATCH]
        known.update(zip(batch, embed(batch), strict=True))
    return np.array([known[text] for text in texts], np.float32)
