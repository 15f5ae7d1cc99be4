"""Patch features: a feature map of the image tower of `mini` before it is pooled, one unit vector for each cell.

AnyLoc (Keetha et al., RA-L 2024) aggregates such features of DINOv2 by VLAD, and takes the layer that does best. Here, it
is the third of the tower's four stages: the last one has larger cells, and did worse on the walks of the tuning.
"""

from functools import lru_cache
from typing import Any

import numpy as np
import torch
from jaxtyping import Float16
from torch.nn.functional import normalize

from lexis.encoder.model_loading import load_network
from lexis.encoder.model_source import MINI, parse_model
from lexis.encoder.preprocessing import Preprocessing
from lexis.types import Image

_STAGE = 3


def patch_features(image: Image) -> Float16[np.ndarray, "cells channels"]:
    """Return features of the cells of an RGB image of any size, row by row: 8 x 10 cells with 152 channels."""
    trunk, preprocessing = _tower()
    with torch.inference_mode():
        (maps,) = trunk.forward_intermediates(preprocessing.apply(image)[None], indices=[_STAGE], intermediates_only=True)
        return np.asarray(normalize(maps[0].flatten(1).T, dim=-1).half().numpy())


@lru_cache(maxsize=1)
def _tower() -> tuple[Any, Preprocessing]:
    """Return the image tower of `mini` without its pooling and projection, and its preprocessing of images."""
    network, _, preprocessing = load_network(MINI, parse_model(MINI))
    return network.visual.trunk.eval(), preprocessing
