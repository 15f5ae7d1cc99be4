"""Which frames are worth showing, and how pictures get into the page."""

import base64

import cv2
import numpy as np
from jaxtyping import Bool, Float, Int, UInt8

from sim.errors import SimError

_WIDTH_PX = 320
_JPEG_QUALITY = 82
_APART = 5
"""Keyframes nearer than this show the same view."""


def most_confident(
    similarities: Float[np.ndarray, "n rooms"], labels: Int[np.ndarray, "n"], among: Bool[np.ndarray, "n"], count: int
) -> list[int]:
    """At most `count` keyframes of `among`, by the lead of the best prompt over the second; new labels, then new views."""
    if count < 0:
        raise SimError(f"count of sample frames is {count}; it must be 0 or more")
    ordered = np.sort(similarities, axis=1)
    lead = ordered[:, -1] - (ordered[:, -2] if ordered.shape[1] > 1 else 0)
    ranked = [int(k) for k in np.argsort(-lead, kind="stable") if among[k]]
    fresh: list[int] = []
    for k in ranked:
        if all(labels[k] != labels[j] and abs(k - j) >= _APART for j in fresh):
            fresh.append(k)
    return [*fresh, *(k for k in ranked if k not in fresh and all(abs(k - j) >= _APART for j in fresh))][:count]


def data_uri(image: UInt8[np.ndarray, "h w 3"]) -> str:
    """An RGB image as a `data:` address of a JPEG, at most 320 px wide."""
    height, width = image.shape[:2]
    if width > _WIDTH_PX:
        size = _WIDTH_PX, round(height * _WIDTH_PX / width)
        image = cv2.resize(image, size, interpolation=cv2.INTER_AREA).astype(np.uint8)
    _, jpeg = cv2.imencode(".jpg", image[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, _JPEG_QUALITY])
    return "data:image/jpeg;base64," + base64.b64encode(jpeg.tobytes()).decode()
