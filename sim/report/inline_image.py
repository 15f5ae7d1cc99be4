"""Encodes pictures as `data:` addresses (URIs), so that the report is a single file."""

import base64

import cv2
import numpy as np
from jaxtyping import UInt8

_WIDTH_PX = 320
_JPEG_QUALITY = 82


def data_uri(image: UInt8[np.ndarray, "h w 3"]) -> str:
    """Encode an RGB image as a JPEG in a `data:` address (URI), scaled down to at most 320 px in width."""
    height, width = image.shape[:2]
    if width > _WIDTH_PX:
        size = _WIDTH_PX, round(height * _WIDTH_PX / width)
        image = cv2.resize(image, size, interpolation=cv2.INTER_AREA).astype(np.uint8)
    _, jpeg = cv2.imencode(".jpg", image[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, _JPEG_QUALITY])
    return "data:image/jpeg;base64," + base64.b64encode(jpeg.tobytes()).decode()
