"""Loading of open_clip networks, with checks that weights, tokenizer and preprocessing belong together.

open_clip itself only logs some mismatches, and passes on the errors of many libraries. Here, each of these mismatches and
errors raises EncoderError.
"""

import logging
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict
from pathlib import Path
from typing import Any

import open_clip
from open_clip.factory import load_state_dict
from open_clip.transform import PreprocessCfg, merge_preprocess_dict
from safetensors import safe_open

from lexis.encoder.model_source import ModelSource
from lexis.encoder.preprocessing import Preprocessing, as_open_clip, squashing
from lexis.errors import EncoderError, one_line

_POSITIONS = ("visual.positional_embedding", "positional_embedding", "text.positional_embedding")


def load_network(model: str, source: ModelSource) -> tuple[Any, Any, Preprocessing]:
    """Load a model; return its network, tokenizer and preprocessing.

    `model` is the name of the model for error messages. Raises EncoderError if the model cannot be loaded.
    """
    with open_clip_quiet():
        try:
            weights = source.weights()
            if source.config is not None:
                open_clip.add_model_config(source.config)
            network = open_clip.create_model(
                source.architecture,
                pretrained=None if weights is None else str(weights),
                force_quick_gelu=source.quick_gelu,
                require_pretrained=True,
                weights_only=True,
            )
            tokenizer = open_clip.get_tokenizer(source.architecture)
            if weights is not None and not source.published:
                _check_positions(network, weights)
            return network, tokenizer, _preprocessing(source, network)
        except EncoderError as error:
            raise EncoderError(f"encoder {model}: {error}") from None
        except Exception as error:  # for damaged or foreign files, torch, timm and open_clip raise almost any type of error
            raise EncoderError(
                f"encoder {model}: {source.kind} cannot be loaded: {one_line(error)}; "
                "valid: complete weights of the same architecture, in safetensors or as torch.save writes tensors"
            ) from None


def _preprocessing(source: ModelSource, network: Any) -> Preprocessing:
    """Return the preprocessing that is stated for the weights, with the image size of the network.

    Raises ValueError if the image size that is stated for the weights differs from the network's.
    """
    height, width = _pair(network.visual.image_size)
    if source.config is not None:
        return squashing(height, width)
    stated = source.preprocess.get("size")
    if stated is not None and _pair(stated) != (height, width):
        raise ValueError(f"its configuration states images of {stated} px, its architecture {(height, width)}")
    settings = merge_preprocess_dict(asdict(PreprocessCfg()), {**source.preprocess, "size": (height, width)})
    return as_open_clip(settings)


def _check_positions(network: Any, checkpoint: Path) -> None:
    """Raise ValueError if the checkpoint's positional embeddings have another size than the network's.

    open_clip resizes them to fit, and only logs that.
    """
    stored, own = _shapes(checkpoint), network.state_dict()
    for name, shape in stored.items():
        mine = own.get(name, own.get(f"text.{name}"))  # in some architectures, the text tower is a separate module
        if mine is not None and shape != tuple(mine.shape):
            raise ValueError(f"of another architecture: its {name} is {shape}, the model's is {tuple(mine.shape)}")


def _shapes(checkpoint: Path) -> dict[str, tuple[int, ...]]:
    if checkpoint.suffix == ".safetensors":
        with safe_open(checkpoint, "pt") as file:
            return {name: tuple(file.get_slice(name).get_shape()) for name in _POSITIONS if name in file.keys()}  # noqa: SIM118
    return {name: tuple(values.shape) for name, values in load_state_dict(str(checkpoint)).items() if name in _POSITIONS}


def _pair(size: Any) -> tuple[int, int]:
    height, width = size if isinstance(size, list | tuple) else (size, size)
    return int(height), int(width)


@contextmanager
def open_clip_quiet() -> Iterator[None]:
    """Suppress all log lines, such as those of open_clip and the hub about retries and fallbacks.

    No important message is lost, because anything important is raised as an error.
    """
    before = logging.root.manager.disable
    logging.disable(logging.CRITICAL)
    try:
        yield
    finally:
        logging.disable(before)
