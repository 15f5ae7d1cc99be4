"""Where an encoder's weights come from: one string, resolved and checked before anything is loaded."""

import difflib
import json
import os
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import open_clip

from lexis.errors import EncoderError

MINI = "mini"
"""The model that ships with the package."""
MINI_CONFIG = Path(__file__).parent / "models" / "lexis-mini.json"
"""Its architecture; the weights lie beside it."""

_SCHEMAS = ("hf-hub:", "local-dir:")
_DEFAULT_TAG = "openai"
_CHECKPOINTS = (".safetensors", ".pt", ".pth", ".bin")
_SETTINGS = ("mean", "std", "interpolation", "resize_mode")
_MAX_CONFIG_BYTES = 1_000_000


@dataclass(frozen=True)
class ModelSource:
    """What open_clip is asked for."""

    architecture: str
    pretrained: str | None
    """A tag or a checkpoint; None where the architecture's name carries its weights."""
    kind: str
    """What `pretrained` is, for messages."""
    quick_gelu: bool = False
    """Whether these weights were trained with OpenAI's activation; open_clip would only warn."""
    preprocess: dict[str, Any] | None = None
    """Mean, deviation and resizing of the image; None: as open_clip knows them for these weights."""


def parse_model(model: str) -> ModelSource:
    """Resolve `mini`, MODEL, MODEL:PRETRAINED, MODEL:PATH, hf-hub:OWNER/NAME or local-dir:PATH. Raises EncoderError."""
    _register_mini()
    if model == MINI:
        return _checkpoint(MINI_CONFIG.stem, MINI_CONFIG.with_suffix(".safetensors"), "mini")
    if model.startswith(_SCHEMAS):
        return ModelSource(model, None, "the model")
    architecture, _, rest = model.partition(":")
    if architecture not in open_clip.list_models():
        raise EncoderError(
            f"encoder {model!r}: no model {architecture!r}; valid: {MINI}, hf-hub:OWNER/NAME, local-dir:PATH, or a model of "
            f"open_clip such as {_similar(architecture)}, alone or followed by :PRETRAINED or :CHECKPOINT.safetensors"
        )
    tags = open_clip.list_pretrained_tags_by_model(architecture)
    wanted = rest or _DEFAULT_TAG
    if wanted in tags:
        known = open_clip.get_pretrained_cfg(architecture, wanted)
        return ModelSource(architecture, wanted, "the pretrained weights", bool(known.get("quick_gelu")))
    if rest and Path(rest).suffix in _CHECKPOINTS:
        return _checkpoint(architecture, Path(rest), model)
    raise EncoderError(
        f"encoder {model!r}: no weights {wanted!r} of {architecture}; valid: {', '.join(tags)}{', or ' if tags else ''}"
        f"the path of a checkpoint ({', '.join(_CHECKPOINTS)})"
    )


def _checkpoint(architecture: str, path: Path, model: str) -> ModelSource:
    if not os.path.isfile(path):
        raise EncoderError(f"encoder {model}: no checkpoint at {path}; valid: an existing file, or another model")
    if architecture == MINI_CONFIG.stem:
        return ModelSource(architecture, str(path), "the checkpoint")
    beside = path.parent / "open_clip_config.json"
    stated = _read_config(beside) if os.path.isfile(beside) else {}
    preprocess = stated.get("preprocess_cfg") or _agreed(architecture)
    if preprocess is None:
        raise EncoderError(
            f"encoder {model}: nothing tells the image's mean and deviation that {path.name} was trained with; "
            f"put the open_clip_config.json that belongs to it into {path.parent}"
        )
    quick_gelu = bool(stated.get("model_cfg", {}).get("quick_gelu"))
    return ModelSource(architecture, str(path), "the checkpoint", quick_gelu, preprocess)


def _read_config(path: Path) -> dict[str, dict[str, Any]]:
    """The configuration that open_clip writes beside weights; its `preprocess_cfg` states mean and std."""
    try:
        config = json.loads(path.read_bytes()[: _MAX_CONFIG_BYTES + 1])
        preprocess = config["preprocess_cfg"]
        numbers = [float(value) for key in ("mean", "std") for value in preprocess[key]]
        if len(numbers) != 6 or min(numbers[3:]) <= 0:
            raise ValueError("mean and std are three numbers each, std positive")
        known = {key: preprocess[key] for key in _SETTINGS if key in preprocess}
        return {"model_cfg": dict(config.get("model_cfg", {})), "preprocess_cfg": known}
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise EncoderError(f"{path}: unusable preprocess_cfg: {error}; valid: mean and std of three numbers each") from None


def _agreed(architecture: str) -> dict[str, Any] | None:
    """The preprocessing that all published weights of the architecture share; None where they disagree or there are none."""
    tags = open_clip.list_pretrained_tags_by_model(architecture)
    settings = [open_clip.get_pretrained_cfg(architecture, tag) for tag in tags]
    chosen = [{key: known[key] for key in _SETTINGS} for known in settings if all(key in known for key in _SETTINGS)]
    return chosen[0] if chosen and len(chosen) == len(settings) and all(c == chosen[0] for c in chosen) else None


def _similar(architecture: str) -> str:
    """The models whose names share most with what was asked for."""
    names = open_clip.list_models()
    return ", ".join(difflib.get_close_matches(architecture, names, n=3, cutoff=0.4) or ("RN50x16", "ViT-B-32", "ViT-L-14"))


@cache
def _register_mini() -> None:
    open_clip.add_model_config(MINI_CONFIG)
