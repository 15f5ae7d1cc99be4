"""Images as the bytes of files."""

import cv2
import numpy as np
from jaxtyping import Float32, UInt8, UInt16

from lexis.types import Image
from sim.errors import SimError

SUFFIXES = {"png": ".png", "jpg": ".jpg"}
_PARAMETERS = {
    # Of rendered rooms no slower setting makes files that are 3 % smaller.
    ".png": [cv2.IMWRITE_PNG_COMPRESSION, 1, cv2.IMWRITE_PNG_STRATEGY, cv2.IMWRITE_PNG_STRATEGY_RLE],
    ".jpg": [cv2.IMWRITE_JPEG_QUALITY, 95],
}

DEPTH_FACTOR = 5000.0
"""Of the TUM RGB-D benchmark: 5000 is one metre."""


def encoded(image: Image, suffix: str) -> bytes:
    """An RGB image as PNG or JPEG (quality 95)."""
    return _encoded(image[..., ::-1], suffix)


def encoded_depth(depth: Float32[np.ndarray, "h w"]) -> bytes:
    """Depth [m] as a 16-bit PNG; what is farther than it can say (13.1 m) is 0, which means unknown."""
    units = np.round(depth * DEPTH_FACTOR)
    return _encoded(np.where(units <= np.iinfo(np.uint16).max, units, 0).astype(np.uint16), ".png")


def _encoded(pixels: UInt8[np.ndarray, "h w 3"] | UInt16[np.ndarray, "h w"], suffix: str) -> bytes:
    fine, content = cv2.imencode(suffix, pixels, _PARAMETERS[suffix])
    if not fine:
        raise SimError(f"an image of {pixels.shape} was not encoded as {suffix}")
    return content.tobytes()
