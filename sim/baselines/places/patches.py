"""Patch features: the feature maps of the image tower of `mini` before they are pooled, one unit vector for each cell.

AnyLoc (Keetha et al., RA-L 2024) aggregates such features of DINOv2 by VLAD, and chooses the layer that does best.
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


def patch_features(image: Image) -> Float16[np.ndarray, "cells channels"]:
    """Features of the cells of an RGB image of any size, row by row: 4 x 5 cells with 368 channels."""
    trunk, preprocessing = _tower()
    with torch.inference_mode():
        (cells,) = trunk.forward_features(preprocessing.apply(image)[None]).flatten(2).transpose(1, 2)
        return np.asarray(normalize(cells, dim=-1).half().numpy())


@lru_cache(maxsize=1)
def _tower() -> tuple[Any, Preprocessing]:
    """The image tower of `mini` without its pooling and projection, and its preprocessing of images."""
    network, _, preprocessing = load_network(MINI, parse_model(MINI))
    return network.visual.trunk.eval(), preprocessing
