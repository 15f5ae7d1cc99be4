"""Exports `lexis-mini`: weights and configuration in the format that open_clip loads."""

import json
import math
from pathlib import Path
from typing import Any

import open_clip
import torch
from open_clip.transformer import TextTransformer
from safetensors import SafetensorError
from safetensors.torch import load_file, save_file

from lexis.errors import one_line
from lexis.files.replace import replaced_file
from sim.errors import SimError
from sim.training.align import AlignedTower
from sim.training.dense import TRUNK, DenseTower
from sim.training.text_tower import EMBED_DIM, TEXT_CFG
from sim.training.viewpoints import IMAGE_SIZE

_TRUNK = "visual.trunk."
_PROJECTION = "visual.head.proj.weight"


def model_config() -> dict[str, Any]:
    """Return the architecture of `lexis-mini` as an open_clip model configuration."""
    vision = {
        "timm_model_name": TRUNK,
        "timm_model_pretrained": False,
        "timm_pool": "",
        "timm_proj": "linear",
        "image_size": [IMAGE_SIZE[1], IMAGE_SIZE[0]],
    }
    return {"embed_dim": EMBED_DIM, "vision_cfg": vision, "text_cfg": dict(TEXT_CFG)}


def export(tower: AlignedTower, text: TextTransformer, temperature: float, path: Path) -> None:
    """Write both towers in half precision to `path`, and the model configuration beside it as JSON.

    The weights contain log(1 / temperature), because open_clip stores its logit scale as a logarithm.
    """
    weights = {name: value.clone() for name, value in text.state_dict().items()}
    weights |= {_TRUNK + name: value for name, value in tower.dense.trunk.state_dict().items()}
    weights[_PROJECTION] = tower.projection.weight.detach()
    weights["logit_scale"] = torch.tensor(-math.log(temperature))
    open_clip.CLIP(**model_config()).load_state_dict(weights)  # raises if names or shapes do not fit open_clip's model
    with replaced_file(path) as beside:
        save_file({name: value.half().contiguous().cpu() for name, value in weights.items()}, beside)
    with replaced_file(path.with_suffix(".json")) as beside:
        beside.write_text(json.dumps(model_config(), indent=2) + "\n", encoding="utf-8")


def start_trunk_from(path: Path, tower: DenseTower) -> None:
    """Load the image tower of an earlier `lexis-mini`, without its projection, into `tower`.

    Raises `SimError` if the file holds no fitting weights.
    """
    try:
        weights = load_file(path)
        trunk = {name.removeprefix(_TRUNK): value.float() for name, value in weights.items() if name.startswith(_TRUNK)}
        tower.trunk.load_state_dict(trunk)
    except (OSError, RuntimeError, SafetensorError) as error:
        reason = one_line(error, 160)
        raise SimError(f"{path}: no image tower to start from: {reason}; valid: weights of lexis-mini") from None
