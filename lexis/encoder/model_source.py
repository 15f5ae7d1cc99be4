"""Where an encoder's weights come from: one string, resolved and checked before anything is fetched or loaded."""

import difflib
import math
import os
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import open_clip
from open_clip.factory import _find_checkpoint_in_dir

from lexis.encoder.hub import fetch
from lexis.errors import EncoderError, one_line
from lexis.files.reading import FileKind, read_json

MINI = "mini"
"""The model that ships with the package."""
MINI_CONFIG = Path(__file__).parents[1] / "models" / "lexis-mini.json"
"""Its architecture; the weights lie beside it."""

CONFIG_FILE = "open_clip_config.json"
"""Written by open_clip beside weights."""
_HUB, _FOLDER = "hf-hub:", "local-dir:"
_DEFAULT_TAG = "openai"
_CHECKPOINTS = (".safetensors", ".pt", ".pth", ".bin")
_HUB_WEIGHTS = ("open_clip_model.safetensors", "open_clip_pytorch_model.bin")
_SETTINGS = ("mean", "std", "interpolation", "resize_mode")
_CHOICES = {"interpolation": ("bicubic", "bilinear", "random"), "resize_mode": ("shortest", "longest", "squash")}
_CONFIG_FILE = FileKind("the file that open_clip writes", 1_000_000, EncoderError)


@dataclass(frozen=True)
class ModelSource:
    """What open_clip is asked for."""

    architecture: str
    kind: str
    """What the weights are, for messages."""
    preprocess: Mapping[str, Any]
    """Mean and deviation of the image and, where stated, size [px] and resizing; empty for the mini."""
    checkpoint: Path | None = None
    """None where the weights come from the hub, and where a folder has none."""
    hub: tuple[str, tuple[str, ...]] | None = None
    """Repository, and the names that the weights may have there."""
    config: Path | None = None
    """Of a mini alone: its architecture, for open_clip to register under the name of the file."""
    published: bool = False
    """Whether open_clip itself lists these weights for this architecture."""
    quick_gelu: bool = False
    """Whether these weights were trained with OpenAI's activation; open_clip would only warn."""

    def weights(self) -> Path | None:
        """The checkpoint, fetched if need be; None where a folder has none. Raises EncoderError."""
        return fetch(*self.hub) if self.hub else self.checkpoint


def parse_model(model: str) -> ModelSource:
    """Resolve `mini`, MODEL, MODEL:PRETRAINED, MODEL:PATH, hf-hub:OWNER/NAME or local-dir:PATH. Raises EncoderError."""
    _register_mini()
    if model == MINI:
        return _mini(MINI_CONFIG.with_suffix(".safetensors"), "mini")
    if model.startswith(_FOLDER):
        return _folder(Path(model.removeprefix(_FOLDER)), model)
    if model.startswith(_HUB):
        repo = model.removeprefix(_HUB)
        stated = _stated(fetch(repo, (CONFIG_FILE,)))
        return ModelSource(model, "the hub's model", stated["preprocess_cfg"], hub=(repo, _HUB_WEIGHTS))
    architecture, _, rest = model.partition(":")
    if architecture not in open_clip.list_models():
        raise EncoderError(
            f"encoder {model!r}: no model {architecture!r}; valid: {MINI}, hf-hub:OWNER/NAME, local-dir:PATH, or a model of "
            f"open_clip such as {_similar(architecture)}, alone or followed by :PRETRAINED or :CHECKPOINT.safetensors"
        )
    tags = open_clip.list_pretrained_tags_by_model(architecture)
    wanted = rest or _DEFAULT_TAG
    if wanted in tags:
        return _published(architecture, wanted)
    if rest and Path(rest).suffix in _CHECKPOINTS:
        return _mini(Path(rest), model) if architecture == MINI_CONFIG.stem else _checkpoint(architecture, Path(rest), model)
    raise EncoderError(
        f"encoder {model!r}: no weights {wanted!r} of {architecture}; valid: {', '.join(tags)}{', or ' if tags else ''}"
        f"the path of a checkpoint ({', '.join(_CHECKPOINTS)})"
    )


def _folder(path: Path, model: str) -> ModelSource:
    """With the checkpoint that open_clip takes of those in the folder."""
    stated = _stated(path / CONFIG_FILE)
    found = _find_checkpoint_in_dir(path)
    return ModelSource(model, "the folder", stated["preprocess_cfg"], checkpoint=Path(found) if found else None)


def _published(architecture: str, tag: str) -> ModelSource:
    known = open_clip.get_pretrained_cfg(architecture, tag)
    repo, _, name = known["hf_hub"].rpartition("/")
    names = (str(Path(name).with_suffix(".safetensors")), name) if name else _HUB_WEIGHTS
    preprocess = {key: known[key] for key in _SETTINGS}
    return ModelSource(
        architecture,
        f"weights {tag!r}",
        preprocess,
        hub=(repo, names),
        published=True,
        quick_gelu=bool(known.get("quick_gelu")),
    )


def _mini(path: Path, model: str) -> ModelSource:
    """Of the architecture that is written beside the weights, else of the package's."""
    _check_exists(path, model)
    beside = path.with_suffix(".json")
    config = beside if os.path.isfile(beside) else MINI_CONFIG
    return ModelSource(config.stem, "the checkpoint", {}, path, config=config)


def _check_exists(path: Path, model: str) -> None:
    if not os.path.isfile(path):
        raise EncoderError(f"encoder {model}: no checkpoint at {path}; valid: an existing file, or another model")


def _checkpoint(architecture: str, path: Path, model: str) -> ModelSource:
    _check_exists(path, model)
    beside = path.parent / CONFIG_FILE
    stated = _stated(beside) if os.path.isfile(beside) else {}
    preprocess = stated.get("preprocess_cfg") or _agreed(architecture)
    if preprocess is None:
        raise EncoderError(
            f"encoder {model}: nothing tells the image's mean and deviation that {path.name} was trained with; "
            f"put the {CONFIG_FILE} that belongs to it into {path.parent}"
        )
    return ModelSource(architecture, "the checkpoint", preprocess, path, quick_gelu=_activation(architecture, stated, path))


def _activation(architecture: str, stated: Mapping[str, Any], path: Path) -> bool:
    """Whether OpenAI's: as stated beside the weights, else by the architecture's name, else as all published weights."""
    if "model_cfg" in stated:
        return bool(stated["model_cfg"].get("quick_gelu"))
    tags = open_clip.list_pretrained_tags_by_model(architecture)
    if open_clip.get_model_config(architecture).get("quick_gelu") or not tags:
        return False  # that is: no other than the architecture has
    known = {bool(open_clip.get_pretrained_cfg(architecture, tag).get("quick_gelu")) for tag in tags}
    if len(known) > 1:
        raise EncoderError(
            f"encoder {architecture}:{path}: weights of this architecture come with two activations, and nothing tells "
            f"which is meant; valid: {architecture}-quickgelu:{path}, or the {CONFIG_FILE} that belongs to it beside it"
        )
    return known.pop()


def _stated(path: Path) -> dict[str, dict[str, Any]]:
    """The configuration that belongs to weights; its `preprocess_cfg` states mean and std. Raises EncoderError."""
    config = read_json(path, _CONFIG_FILE)
    try:
        preprocess = config["preprocess_cfg"]
        mean, std = ([float(value) for value in preprocess[key]] for key in ("mean", "std"))
        if not (len(mean) == len(std) == 3 and all(map(math.isfinite, mean + std)) and min(std) > 0):
            raise ValueError("mean and std are three numbers each, std positive")
        for key, valid in _CHOICES.items():
            if preprocess.get(key, valid[0]) not in valid:
                raise ValueError(f"{key} is {preprocess[key]!r}, not one of {', '.join(valid)}")
        known = {key: preprocess[key] for key in (*_SETTINGS, "size") if key in preprocess}
        return {"preprocess_cfg": known} | ({"model_cfg": dict(config["model_cfg"])} if "model_cfg" in config else {})
    except (ValueError, KeyError, TypeError, AttributeError, OverflowError) as error:
        raise EncoderError(
            f"{path}: unusable preprocess_cfg: {one_line(error)}; valid: mean and std of three numbers each"
        ) from None


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
