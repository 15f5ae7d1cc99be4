"""The vision-language model, which embeds images and room names as unit vectors in one space (paper, Sec. III-A).

Any open_clip model works. `lexis-mini`, a small model trained on rendered images, ships with the package and needs no
network.
"""

import hashlib
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
import torch
from jaxtyping import Float, Float32, UInt8
from torch import Tensor

from lexis.encoder.image_cache import ImageCache, image_key
from lexis.encoder.model_loading import load_network
from lexis.encoder.model_source import MINI, parse_model
from lexis.encoder.options import EncoderOptions
from lexis.encoder.preprocessing import Preprocessing
from lexis.encoder.prompts import prompts
from lexis.errors import EncoderError, one_line
from lexis.types import Image

_DTYPES = {"fp32": torch.float32, "bf16": torch.bfloat16, "fp16": torch.float16}
Images = Sequence[UInt8[np.ndarray, "_ _ 3"]] | UInt8[np.ndarray, "images h w 3"]
"""Several images of any sizes, or an array of images of equal size."""
_TEXT_LISTS = 1024
"""Number of lists of texts whose embeddings are cached in memory."""


class OpenClipEncoder:
    """An open_clip model as an encoder. The output for an input does not depend on earlier inputs."""

    def __init__(
        self, name: str, model: Any, tokenizer: Any, preprocessing: Preprocessing, options: EncoderOptions | None = None
    ) -> None:
        """Wrap a loaded model. Raises EncoderError if the device is absent, the cache unusable, or compilation fails."""
        self._options = options or EncoderOptions()
        self._name = name
        self._device = _device(self._options)
        self._model = model.eval().to(self._device)
        self._tokenizer = tokenizer
        self._preprocessing = preprocessing
        self._image_tower: Callable[[Tensor], Tensor] = lambda images: self._model.encode_image(images)
        self._text_tower: Callable[[Tensor], Tensor] = lambda tokens: self._model.encode_text(tokens)
        if self._options.compiled:
            self._image_tower, self._text_tower = torch.compile(self._image_tower), torch.compile(self._text_tower)
            self._compile()
        self._texts = lru_cache(_TEXT_LISTS)(self._embed_texts)
        folder = self._options.cache
        self._cache = None if folder is None else ImageCache(folder, f"{self.fingerprint}-{self._options.precision}")

    @property
    def name(self) -> str:
        """Argument with which `load_encoder` loaded this encoder."""
        return self._name

    @cached_property
    def fingerprint(self) -> str:
        """Hash of weights, activation and preprocessing as hex digits; independent of the file, device and precision."""
        digest = hashlib.sha256(self._preprocessing.description.encode())
        digest.update(str(any(type(module).__name__ == "QuickGELU" for module in self._model.modules())).encode())
        for name, weights in sorted(self._model.state_dict().items()):
            digest.update(f"{name} {weights.dtype} {tuple(weights.shape)}\n".encode())
            digest.update(weights.detach().cpu().contiguous().reshape(-1).view(torch.uint8).numpy().data)
        return digest.hexdigest()

    @property
    def temperature(self) -> float:
        """Temperature that the model was trained with: the model's probabilities are softmax(similarities / temperature)."""
        return float(1.0 / self._model.logit_scale.detach().float().exp())

    def encode_image(self, image: Image) -> Float32[np.ndarray, "d"]:
        """CLIP embedding of an RGB image of any size (f_CLIP in the paper), with unit norm."""
        return np.asarray(self.encode_images([image])[0])

    def encode_images(self, images: Images) -> Float32[np.ndarray, "images d"]:
        """CLIP embeddings of RGB images (f_CLIP in the paper), with unit norm.

        Embeddings that are in the cache are not computed again; the others are computed in batches.
        Raises EncoderError if there is no image.
        """
        if self._cache is None or len(images) == 0:
            return self._embed_images(images)
        keys = [image_key(image) for image in images]
        known = self._cache.find(keys)
        if new := {key: image for key, image in zip(keys, images, strict=True) if key not in known}:
            found = dict(zip(new, self._embed_images(list(new.values())), strict=True))
            self._cache.add(found)
            known |= found
        return np.stack([known[key] for key in keys])

    def encode_rooms(self, names: Sequence[str]) -> Float32[np.ndarray, "rooms d"]:
        """Text embedding of every room name (f_TEXT in the paper), with unit norm: the mean over several prompts.

        Raises EncoderError for a blank name, or if there is no name.
        """
        if not names or not all(name.strip() for name in names):
            raise EncoderError(f"room names are {list(names)}; valid: at least one, none blank")
        means = np.stack([self.encode_texts(prompts(name, self._options.templates)).mean(axis=0) for name in names])
        return np.asarray(means / np.linalg.norm(means, axis=1, keepdims=True), np.float32)

    def encode_texts(self, texts: Sequence[str]) -> Float32[np.ndarray, "texts d"]:
        """Text embedding of every text, with unit norm. Unlike room names, the texts are not put into prompts.

        The embeddings of recent lists of texts are cached in memory.
        """
        return self._texts(tuple(texts)).copy()

    def _compile(self) -> None:
        """Use both towers once, so that an error in their compilation appears here and not later. Raises EncoderError."""
        try:
            self._embed_images([np.zeros((64, 64, 3), np.uint8)])
            self._embed_texts(("room",))
        except RuntimeError as error:
            raise EncoderError(f"encoder {self._name} cannot be compiled: {one_line(error)}") from None

    def _embed_texts(self, texts: tuple[str, ...]) -> Float32[np.ndarray, "texts d"]:
        return self._in_batches(texts, lambda batch: self._text_tower(self._tokenizer(list(batch)).to(self._device)))

    def _embed_images(self, images: Images) -> Float32[np.ndarray, "images d"]:
        prepare = self._preprocessing.apply
        return self._in_batches(
            list(images), lambda batch: self._image_tower(torch.stack([prepare(image) for image in batch]).to(self._device))
        )

    def _in_batches(self, items: Sequence[Any], tower: Callable[[Sequence[Any]], Tensor]) -> Float32[np.ndarray, "n d"]:
        if not len(items):
            raise EncoderError("nothing to encode; valid: at least one image or text")
        size = self._options.batch
        with _inference(self._options, self._device):
            return np.concatenate([_normalised(tower(items[i : i + size])) for i in range(0, len(items), size)])


def load_encoder(model: str = MINI, options: EncoderOptions | None = None) -> OpenClipEncoder:
    """Load `mini`, MODEL (with its OpenAI weights), MODEL:PRETRAINED, MODEL:PATH, hf-hub:OWNER/NAME or local-dir:PATH.

    Args:
        model: MODEL is an open_clip architecture, PRETRAINED one of its tags, PATH a checkpoint (.safetensors, or .pt, .pth
            or .bin with nothing but tensors). If open_clip lists no tag of MODEL, or if its tags disagree on the image's
            mean and deviation or on the activation, an `open_clip_config.json` beside PATH must state these properties.
        options: device, precision, batch size, prompts and cache.

    Raises:
        EncoderError: the model is unknown, cannot be downloaded, or its checkpoint is damaged or of another architecture; or
            the device is absent or does not support the precision; or the cache is unusable; or compilation fails.
    """
    options = options or EncoderOptions()
    _device(options)
    network, tokenizer, preprocessing = load_network(model, parse_model(model))
    return OpenClipEncoder(model, network, tokenizer, preprocessing, options)


def _device(options: EncoderOptions) -> torch.device:
    """Return the device of the options. Raises EncoderError if it is absent or does not support the precision."""
    device = torch.device(options.device)
    if device.type == "cuda" and (device.index or 0) >= torch.cuda.device_count():
        raise EncoderError(
            f"encoder device {options.device} is absent: torch sees {torch.cuda.device_count()} GPUs; valid: cpu"
        )
    if device.type == "cuda" and options.precision == "bf16" and not torch.cuda.is_bf16_supported():
        raise EncoderError(f"encoder precision is bf16, which {options.device} does not support; valid: fp32, fp16")
    return device


@contextmanager
def _inference(options: EncoderOptions, device: torch.device) -> Iterator[None]:
    before = torch.get_num_threads()
    torch.set_num_threads(options.threads)
    try:
        lower = options.precision != "fp32"
        with torch.inference_mode(), torch.autocast(device.type, _DTYPES[options.precision], enabled=lower):
            yield
    finally:
        torch.set_num_threads(before)


def _normalised(rows: Float[Tensor, "n d"]) -> Float32[np.ndarray, "n d"]:
    """Scale the rows to unit norm. Raises EncoderError if a row is not finite."""
    units = torch.nn.functional.normalize(rows.float(), dim=-1).cpu().numpy()
    if not np.isfinite(units).all():
        raise EncoderError("the encoder's output is not finite: its weights are damaged; valid: another checkpoint, or fp32")
    return np.asarray(units)
