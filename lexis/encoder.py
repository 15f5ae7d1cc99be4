"""The vision-language model: images and room names as unit vectors in one space (paper, Sec. III-A).

Any open_clip model works. `lexis-mini`, a small one trained on renders, ships with the package and needs no network.
"""

import hashlib
import logging
import pickle
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import cached_property
from typing import Any

import cv2
import numpy as np
import open_clip
import torch
from jaxtyping import Float, Float32
from open_clip.transform import PreprocessCfg, image_transform_v2, merge_preprocess_dict
from PIL import Image as PILImage
from safetensors import SafetensorError
from torch import Tensor

from lexis.errors import EncoderError
from lexis.model_source import MINI, MINI_CONFIG, ModelSource, parse_model
from lexis.prompts import prompts
from lexis.types import Image

MINI_MEAN = (0.5, 0.5, 0.5)
"""Subtracted from RGB in [0, 1] before `lexis-mini` sees it."""
MINI_STD = (0.25, 0.25, 0.25)
"""Divides what is left."""

_LOAD_ERRORS = (
    RuntimeError, OSError, ValueError, KeyError, EOFError, AttributeError, pickle.UnpicklingError, SafetensorError
)  # fmt: skip

Preprocess = Callable[[Image], Float[Tensor, "3 h w"]]


class OpenClipEncoder:
    """An open_clip model on the CPU; the same input gives the same output, whatever was encoded before."""

    def __init__(self, name: str, model: Any, tokenizer: Any, preprocess: Preprocess, threads: int = 1) -> None:
        """Wrap a loaded model. `threads` bounds torch's threads while encoding; the process keeps its own setting."""
        if threads < 1:
            raise EncoderError(f"encoder threads is {threads}; valid: >= 1")
        self._name = name
        self._model = model.eval()
        self._tokenizer = tokenizer
        self._preprocess = preprocess
        self._threads = threads

    @property
    def name(self) -> str:
        """What `load_encoder` was asked for."""
        return self._name

    @cached_property
    def fingerprint(self) -> str:
        """Hex digest over the weights: two encoders with equal ones give embeddings that can be compared."""
        digest = hashlib.sha256()
        for name, weights in sorted(self._model.state_dict().items()):
            digest.update(f"{name} {weights.dtype} {tuple(weights.shape)}\n".encode())
            digest.update(weights.detach().cpu().contiguous().reshape(-1).view(torch.uint8).numpy().data)
        return digest.hexdigest()

    @property
    def temperature(self) -> float:
        """The model's own: softmax(similarities / temperature) are its probabilities."""
        return float(1.0 / self._model.logit_scale.detach().float().exp())

    def encode_image(self, image: Image) -> Float32[np.ndarray, "d"]:
        """f_CLIP of an RGB image of any size, unit norm."""
        with _inference(self._threads):
            return _units(self._model.encode_image(self._preprocess(image)[None])).reshape(-1)

    def encode_rooms(self, names: Sequence[str]) -> Float32[np.ndarray, "rooms d"]:
        """f_TEXT of every room name: the unit mean over an ensemble of prompts. Raises EncoderError for a blank name."""
        if not names or not all(name.strip() for name in names):
            raise EncoderError(f"room names are {list(names)}; valid: at least one, none blank")
        means = np.stack([self.encode_texts(prompts(name)).mean(axis=0) for name in names])
        return np.asarray(means / np.linalg.norm(means, axis=1, keepdims=True), np.float32)

    def encode_texts(self, texts: Sequence[str]) -> Float32[np.ndarray, "texts d"]:
        """f_TEXT of every text as it stands, unit norm; for questions in free words."""
        with _inference(self._threads):
            return _units(self._model.encode_text(self._tokenizer(list(texts))))


def load_encoder(model: str = MINI, threads: int = 1) -> OpenClipEncoder:
    """Load `mini`, MODEL (with its OpenAI weights), MODEL:PRETRAINED, MODEL:PATH, hf-hub:OWNER/NAME or local-dir:PATH.

    Args:
        model: MODEL is an open_clip architecture, PRETRAINED one of its tags, PATH a checkpoint (.safetensors, or .pt and
            .bin holding nothing but tensors). Where open_clip lists no tag of MODEL, or its tags disagree on the image's
            mean and deviation, PATH needs an `open_clip_config.json` beside it that states them.
        threads: of torch, while encoding.

    Raises:
        EncoderError: the model is unknown, cannot be fetched, or its checkpoint is damaged or of another architecture.
    """
    source = parse_model(model)
    with _open_clip_quiet():
        try:
            network = open_clip.create_model(
                source.architecture,
                pretrained=source.pretrained,
                force_quick_gelu=source.quick_gelu,
                require_pretrained=True,
                weights_only=True,
            )
            tokenizer = open_clip.get_tokenizer(source.architecture)
        except _LOAD_ERRORS as error:
            raise EncoderError(f"encoder {model}: {source.kind} cannot be loaded: {_first_line(error)}") from None
    return OpenClipEncoder(model, network, tokenizer, _preprocess_of(source, network), threads)


def _preprocess_of(source: ModelSource, network: Any) -> Preprocess:
    if source.architecture == MINI_CONFIG.stem:
        height, width = network.visual.image_size
        return lambda image: squash(image, height, width)
    settings = merge_preprocess_dict(network.visual.preprocess_cfg, source.preprocess or {})
    transform = image_transform_v2(PreprocessCfg(**settings), is_train=False)
    return lambda image: transform(PILImage.fromarray(image))


def squash(image: Image, height: int, width: int) -> Float[Tensor, "3 {height} {width}"]:
    """The image as `lexis-mini` wants it: area-averaged to height x width [px] without keeping its aspect, normalised."""
    small = cv2.resize(image, (width, height), interpolation=cv2.INTER_AREA)
    pixels = (small / np.float32(255.0) - np.array(MINI_MEAN, np.float32)) / np.array(MINI_STD, np.float32)
    return torch.from_numpy(np.ascontiguousarray(pixels.transpose(2, 0, 1)))


@contextmanager
def _inference(threads: int) -> Iterator[None]:
    before = torch.get_num_threads()
    torch.set_num_threads(threads)
    try:
        with torch.inference_mode():
            yield
    finally:
        torch.set_num_threads(before)


@contextmanager
def _open_clip_quiet() -> Iterator[None]:
    """Drop open_clip's and the hub's log lines (retries, fallbacks): what matters of them is in the error."""
    before = logging.root.manager.disable
    logging.disable(logging.CRITICAL)
    try:
        yield
    finally:
        logging.disable(before)


def _units(rows: Float[Tensor, "n d"]) -> Float32[np.ndarray, "n d"]:
    return torch.nn.functional.normalize(rows.float(), dim=-1).numpy()


def _first_line(error: Exception) -> str:
    lines = [line.strip() for line in str(error).splitlines() if line.strip()]
    return " ".join(lines[:2])[:300] if lines else type(error).__name__


__all__ = ["MINI_CONFIG", "MINI_MEAN", "MINI_STD", "OpenClipEncoder", "load_encoder", "squash"]
