"""Times of an encoder for one image and for the prompts of one room name, on every device and precision available."""

import json
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import open_clip
import torch
from safetensors.torch import save_file

from lexis.encoder.model_loading import open_clip_quiet
from lexis.encoder.open_clip_encoder import OpenClipEncoder, load_encoder
from lexis.encoder.options import EncoderOptions
from lexis.errors import EncoderError, one_line
from lexis.types import Image
from worlds.labels import ROOM_LABELS

WAYS = {
    "cpu": EncoderOptions(),
    "cpu bf16": EncoderOptions(precision="bf16"),
    "cpu compiled": EncoderOptions(compiled=True),
    "gpu": EncoderOptions(device="cuda"),
    "gpu fp16": EncoderOptions(device="cuda", precision="fp16"),
    "gpu fp16 compiled": EncoderOptions(device="cuda", precision="fp16", compiled=True),
}
"""Options for loading an encoder, by name. The defaults are 32-bit floats, no compilation and one thread. Images are encoded
one at a time."""
_WARM_UP, _TIMES = 2, 9


@dataclass(frozen=True)
class Timing:
    """Times of an encoder; the times for image and text are medians over repetitions."""

    image_ms: float
    """Time for one image from pixels to embedding, including scaling [ms]."""
    text_ms: float
    """Time for one room name, whose five prompts are encoded as one batch [ms]."""
    loading_s: float
    """Time for loading the model, with compilation but without importing libraries [s]."""


def timed(model: str, way: str, image: Image) -> Timing | str:
    """Measure a model with the options `WAYS[way]`; return its times, or the reason why it cannot run with them here."""
    options = WAYS[way]
    if options.device != "cpu" and not torch.cuda.is_available():
        return "no GPU"
    start = time.perf_counter()
    try:
        encoder = load_encoder(model, options)
    except EncoderError as error:
        return str(error)
    return timing(encoder, image, time.perf_counter() - start)


def timed_with_random_weights(architecture: str, ways: Sequence[str], image: Image) -> dict[str, Timing | str]:
    """Measure an open_clip architecture with random weights in several `ways`, which are keys of `WAYS`.

    Returns, for each way, its times, or the reason why it could not be measured.
    """
    try:
        with random_weights(architecture) as model:
            return {way: timed(model, way, image) for way in ways}
    except EncoderError as error:
        return dict.fromkeys(ways, str(error))


def timing(encoder: OpenClipEncoder, image: Image, loading_s: float) -> Timing:
    """Measure a loaded encoder. Every room name is used only once, so that no cached embedding is returned."""
    rounds = range(_WARM_UP + _TIMES)
    images = _median_ms([lambda: encoder.encode_image(image) for _ in rounds])
    return Timing(images, _median_ms([_encoding(encoder, ROOM_LABELS[i]) for i in rounds]), loading_s)


def example_image() -> Image:
    """Return an image of noise in LEXIS's image size. Networks take as long for noise as for an image of a house."""
    return np.random.default_rng(0).integers(0, 256, (360, 480, 3), np.uint8)


def check_architecture(name: str) -> None:
    """Raise `EncoderError` if open_clip has no architecture with the given name."""
    if name not in open_clip.list_models():
        raise EncoderError(f"no architecture {name!r}; valid: one of open_clip.list_models(), such as RN50, ViT-B-32")


@contextmanager
def random_weights(architecture: str) -> Iterator[str]:
    """Write random weights of an open_clip architecture to a temporary file; yield the model name for `load_encoder`.

    The file is deleted at the end of the context. Raises `EncoderError` if open_clip has no such architecture, or cannot
    make it without network access.
    """
    check_architecture(architecture)
    with tempfile.TemporaryDirectory() as folder:
        weights = Path(folder) / "random.safetensors"
        try:
            with open_clip_quiet():
                _write_random(architecture, weights)
        except Exception as error:  # timm, transformers and the hub's client raise many types for missing files
            raise EncoderError(
                f"architecture {architecture}: cannot be made with random weights: {one_line(error)}"
            ) from None
        yield f"{architecture}:{weights}"


def _write_random(architecture: str, weights: Path) -> None:
    network = open_clip.create_model(architecture, pretrained=None, pretrained_hf=False)
    save_file({name: value.contiguous() for name, value in network.state_dict().items()}, weights)
    config = {"model_cfg": open_clip.get_model_config(architecture), "preprocess_cfg": network.visual.preprocess_cfg}
    (weights.parent / "open_clip_config.json").write_text(json.dumps(config), encoding="utf-8")


def _encoding(encoder: OpenClipEncoder, name: str) -> Callable[[], object]:
    return lambda: encoder.encode_rooms([name])


def _median_ms(calls: list[Callable[[], object]]) -> float:
    times = []
    for call in calls:
        start = time.perf_counter()
        call()
        times.append(time.perf_counter() - start)
    return float(np.median(times[_WARM_UP:]) * 1e3)
