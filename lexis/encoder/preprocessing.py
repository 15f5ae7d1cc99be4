"""Preprocessing of RGB images of any size for the image network of a model, as in the training of the model."""

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
"""Mean that is subtracted from RGB in [0, 1] for `lexis-mini`."""
MINI_STD = (0.25, 0.25, 0.25)
"""Standard deviation by which RGB in [0, 1] is divided for `lexis-mini`, after subtracting the mean."""


@dataclass(frozen=True, eq=False)
class Preprocessing:
    """A function that preprocesses images, with a description."""

    description: str
    """Text that is equal for two preprocessings that do the same; it enters the encoder's fingerprint."""
    apply: Callable[[Image], Float[Tensor, "3 h w"]]


def squashing(height: int, width: int) -> Preprocessing:
    """Return the preprocessing of `lexis-mini`, which resizes every image to height x width [px] (see `squash`)."""
    return Preprocessing(
        json.dumps(["area", height, width, MINI_MEAN, MINI_STD]), lambda image: squash(image, height, width)
    )


def as_open_clip(settings: Mapping[str, Any]) -> Preprocessing:
    """Return the preprocessing of open_clip with the given settings: a value for each field of open_clip's `PreprocessCfg`.

    Raises ValueError for unusable values.
    """
    transform = image_transform_v2(PreprocessCfg(**settings), is_train=False)
    told = [settings[key] for key in ("resize_mode", "size", "mean", "std", "interpolation")]
    return Preprocessing(json.dumps(told), lambda image: transform(PILImage.fromarray(image)))


def squash(image: Image, height: int, width: int) -> Float[Tensor, "3 height width"]:
    """Resize an image to height x width [px] by area averaging, without keeping its aspect ratio, and normalise it."""
    small = cv2.resize(image, (width, height), interpolation=cv2.INTER_AREA)
    pixels = (small / np.float32(255.0) - np.array(MINI_MEAN, np.float32)) / np.array(MINI_STD, np.float32)
    return torch.from_numpy(np.ascontiguousarray(pixels.transpose(2, 0, 1)))
