"""From an RGB image of any size to what an image tower was trained on; always as stated, never guessed."""

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
import torch
from jaxtyping import Float
from open_clip.transform import PreprocessCfg, image_transform_v2
from PIL import Image as PILImage
from torch import Tensor

from lexis.types import Image

MINI_MEAN = (0.5, 0.5, 0.5)
"""Subtracted from RGB in [0, 1] before `lexis-mini` sees it."""
MINI_STD = (0.25, 0.25, 0.25)
"""Divides what is left."""


@dataclass(frozen=True, eq=False)
class Preprocessing:
    """A function of images, and in words what it does."""

    description: str
    """Equal for two that do the same."""
    apply: Callable[[Image], Float[Tensor, "3 h w"]]


def squashing(height: int, width: int) -> Preprocessing:
    """As `lexis-mini` wants it, to height x width [px]."""
    return Preprocessing(
        json.dumps(["area", height, width, MINI_MEAN, MINI_STD]), lambda image: squash(image, height, width)
    )


def as_open_clip(settings: Mapping[str, Any]) -> Preprocessing:
    """As open_clip does for these fields, all there are, of its `PreprocessCfg`. Raises ValueError for what it cannot do."""
    transform = image_transform_v2(PreprocessCfg(**settings), is_train=False)
    told = [settings[key] for key in ("resize_mode", "size", "mean", "std", "interpolation")]
    return Preprocessing(json.dumps(told), lambda image: transform(PILImage.fromarray(image)))


def squash(image: Image, height: int, width: int) -> Float[Tensor, "3 {height} {width}"]:
    """The image area-averaged to height x width [px] without keeping its aspect, normalised."""
    small = cv2.resize(image, (width, height), interpolation=cv2.INTER_AREA)
    pixels = (small / np.float32(255.0) - np.array(MINI_MEAN, np.float32)) / np.array(MINI_STD, np.float32)
    return torch.from_numpy(np.ascontiguousarray(pixels.transpose(2, 0, 1)))
