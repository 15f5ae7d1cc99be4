"""Encoding of images and depth maps as the bytes of image files."""

import cv2
import numpy as np
from jaxtyping import Float32, UInt8, UInt16

from lexis.types import Image
from sim.errors import SimError

SUFFIXES = {"png": ".png", "jpg": ".jpg"}
_PARAMETERS = {
    # Slower settings make the files of rendered rooms less than 3 % smaller.
    ".png": [cv2.IMWRITE_PNG_COMPRESSION, 1, cv2.IMWRITE_PNG_STRATEGY, cv2.IMWRITE_PNG_STRATEGY_RLE],
    ".jpg": [cv2.IMWRITE_JPEG_QUALITY, 95],
}

DEPTH_FACTOR = 5000.0
"""Units of a depth image per metre, as in the TUM RGB-D benchmark."""


def encoded(image: Image, suffix: str) -> bytes:
    """Encode an RGB image as PNG (`suffix` is `.png`) or as JPEG of quality 95 (`.jpg`)."""
    return _encoded(image[..., ::-1], suffix)


def encoded_depth(depth: Float32[np.ndarray, "h w"]) -> bytes:
    """Encode depth [m] as a 16-bit PNG in units of 1/5000 m. Depth beyond 13.1 m is written as 0, which means unknown."""
    units = np.round(depth * DEPTH_FACTOR)
    return _encoded(np.where(units <= np.iinfo(np.uint16).max, units, 0).astype(np.uint16), ".png")


def _encoded(pixels: UInt8[np.ndarray, "h w 3"] | UInt16[np.ndarray, "h w"], suffix: str) -> bytes:
    fine, content = cv2.imencode(suffix, pixels, _PARAMETERS[suffix])
    if not fine:
        raise SimError(f"an image of shape {pixels.shape} could not be encoded as {suffix}")
    return content.tobytes()
