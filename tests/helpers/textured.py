"""Images with a soft random texture, in which features are found everywhere."""

import cv2
import numpy as np
from jaxtyping import UInt8


def textured(seed: int) -> UInt8[np.ndarray, "240 320 3"]:
    """An image of coloured blobs a few pixels wide."""
    soft = cv2.GaussianBlur(np.random.default_rng(seed).normal(size=(240, 320, 3)).astype(np.float32), None, 3.0)
    return np.clip(128 + 900 * soft, 0, 255).astype(np.uint8)
