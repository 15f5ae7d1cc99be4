"""Resolution of a model's name, such as "ViT-B-32:openai", to the source of its weights and its preprocessing.

The name is checked before weights are downloaded or loaded.
"""

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
"""Name of the model that ships with the package."""
MINI_CONFIG = Path(__file__).parents[1] / "models" / "lexis-mini.json"
"""File with the architecture of the model `mini`; the weights are in the same folder."""

CONFIG_FILE = "open_clip_config.json"
"""Name of the file that open_clip writes beside weights."""
_HUB, _FOLDER = "hf-hub:", "local-dir:"
_DEFAULT_TAG = "openai"
_CHECKPOINTS = (".safetensors", ".pt", ".pth", ".bin")
_HUB_WEIGHTS = ("open_clip_model.safetensors", "open_clip_pytorch_model.bin")
_SETTINGS = ("mean", "std", "interpolation", "resize_mode")
_CHOICES = {"interpolation": ("bicubic", "bilinear", "random"), "resize_mode": ("shortest", "longest", "squash")}
_CONFIG_FILE = FileKind("the file that open_clip writes", 1_000_000, EncoderError)


@dataclass(frozen=True)
class ModelSource:
    """The source of a model: the names, files and settings with which open_clip creates and loads the model."""

    architecture: str
    kind: str
    """Description of the weights, for messages."""
    preprocess: Mapping[str, Any]
    """Mean and standard deviation that normalise images and, if stated, image size [px] and resizing; empty for `mini`."""
    checkpoint: Path | None = None
    """Local file with the weights; None if the weights come from the hub, or if the local folder contains no weights."""
    hub: tuple[str, tuple[str, ...]] | None = None
    """Repository on the hub, and the possible names of the file with the weights there; None for local weights."""
    config: Path | None = None
    """For a `mini` model only: the file with its architecture, which open_clip registers under the name of the file."""
    published: bool = False
    """Whether open_clip itself lists these weights for this architecture."""
    quick_gelu: bool = False
    """Whether these weights were trained with OpenAI's activation function; open_clip would only warn of a mismatch."""

    def weights(self) -> Path | None:
        """The local file with the weights, downloaded if necessary; None if the local folder contains no weights.

        Raises EncoderError if the download fails.
        """
        return fetch(*self.hub) if self.hub else self.checkpoint


def parse_model(model: str) -> ModelSource:
    """Find the source of `mini`, MODEL, MODEL:PRETRAINED, MODEL:PATH, hf-hub:OWNER/NAME or local-dir:PATH.

    Raises EncoderError if the model or its weights are unknown or do not exist.
    """
    _register_mini()
    if model == MINI:
        return _mini(MINI_CONFIG.with_suffix(".safetensors"), "mini")
    if model.startswith(_FOLDER):
        return _folder(Path(model.removeprefix(_FOLDER)), model)
    if model.startswith(_HUB):
        repo = model.removeprefix(_HUB)
        stated = _read_config(fetch(repo, (CONFIG_FILE,)))
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
    """Return the source of a local folder, with the checkpoint that open_clip chooses in it."""
    stated = _read_config(path / CONFIG_FILE)
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
    """Return the source of a `mini` model, with the JSON file beside the weights as architecture, else the package's own."""
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
    stated = _read_config(beside) if os.path.isfile(beside) else {}
    preprocess = stated.get("preprocess_cfg") or _common_preprocessing(architecture)
    if preprocess is None:
        raise EncoderError(
            f"encoder {model}: the image's mean and deviation that {path.name} was trained with are unknown; "
            f"valid: a {CONFIG_FILE} with them in {path.parent}"
        )
    return ModelSource(architecture, "the checkpoint", preprocess, path, quick_gelu=_quick_gelu(architecture, stated, path))


def _quick_gelu(architecture: str, stated: Mapping[str, Any], path: Path) -> bool:
    """Whether the network has to be forced to OpenAI's activation (QuickGELU).

    The configuration beside the weights decides. Without a configuration, the activation of the architecture is kept if it
    is QuickGELU, or if no weights are published for the architecture. Otherwise, the published weights decide; EncoderError
    is raised if they disagree.
    """
    if "model_cfg" in stated:
        return bool(stated["model_cfg"].get("quick_gelu"))
    tags = open_clip.list_pretrained_tags_by_model(architecture)
    if open_clip.get_model_config(architecture).get("quick_gelu") or not tags:
        return False  # the activation of the architecture is kept
    known = {bool(open_clip.get_pretrained_cfg(architecture, tag).get("quick_gelu")) for tag in tags}
    if len(known) > 1:
        raise EncoderError(
            f"encoder {architecture}:{path}: weights of this architecture exist with two activations, and it is unknown "
            f"which these need; valid: {architecture}-quickgelu:{path}, or the {CONFIG_FILE} of the weights beside them"
        )
    return known.pop()


def _read_config(path: Path) -> dict[str, dict[str, Any]]:
    """Read the configuration of weights, whose `preprocess_cfg` must state mean and std. Raises EncoderError."""
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


def _common_preprocessing(architecture: str) -> dict[str, Any] | None:
    """The preprocessing that all published weights of the architecture share; None if they disagree or do not exist."""
    tags = open_clip.list_pretrained_tags_by_model(architecture)
    settings = [open_clip.get_pretrained_cfg(architecture, tag) for tag in tags]
    chosen = [{key: known[key] for key in _SETTINGS} for known in settings if all(key in known for key in _SETTINGS)]
    return chosen[0] if chosen and len(chosen) == len(settings) and all(c == chosen[0] for c in chosen) else None


def _similar(architecture: str) -> str:
    """Return the names of models that are most similar to a wrong name, for messages."""
    names = open_clip.list_models()
    return ", ".join(difflib.get_close_matches(architecture, names, n=3, cutoff=0.4) or ("RN50x16", "ViT-B-32", "ViT-L-14"))


@cache
def _register_mini() -> None:
    open_clip.add_model_config(MINI_CONFIG)
