"""AKAZE key points and binary descriptors (paper, Sec. III-A), and how they are matched."""

import cv2
import numpy as np
from jaxtyping import Bool, Int, UInt8

from lexis.config import LandmarkConfig
from lexis.inputs import DESCRIPTOR_BYTES
from lexis.types import Features, Image


class FeatureExtractor:
    """Holds one AKAZE detector."""

    def __init__(self, config: LandmarkConfig) -> None:
        """Create the detector."""
        self._akaze = cv2.AKAZE.create(threshold=config.akaze_threshold, max_points=config.max_features)

    def extract(self, image: Image) -> Features:
        """Key points of an RGB image; none is a valid answer (a bare wall)."""
        grey = cv2.cvtColor(image, cv2.COLOR_RGB2GRAY)
        keypoints, descriptors = self._akaze.detectAndCompute(grey, None)
        if not keypoints:
            return Features(np.zeros((0, 2), np.float32), np.zeros((0, DESCRIPTOR_BYTES), np.uint8))
        return Features(np.array([keypoint.pt for keypoint in keypoints], np.float32), np.asarray(descriptors))


def mutual_matches(
    first: UInt8[np.ndarray, "n bytes"],
    second: UInt8[np.ndarray, "m bytes"],
    ratio: float,
    allowed: Bool[np.ndarray, "n m"] | None = None,
    max_distance: int = 488,
) -> Int[np.ndarray, "k 2"]:
    """Row pairs that are each other's nearest by Hamming distance, and clearly so (Lowe's ratio, from the first's side).

    With `allowed`, only those pairs exist: both the nearest and the second-nearest are sought among them; as that may leave
    a wrong pair without a rival, bound its distance by `max_distance` [bits].
    """
    if len(first) == 0 or len(second) == 0:
        return np.zeros((0, 2), np.intp)
    forward, forward_ids = _two_nearest(first, second, allowed)
    _, backward_ids = _two_nearest(second, first, None if allowed is None else allowed.T)
    rows = np.arange(len(first))
    nearest = forward_ids[:, 0]
    found = (nearest >= 0) & (forward[:, 0] <= max_distance)
    mutual = backward_ids[nearest, 0] == rows
    distinct = forward[:, 0] <= ratio * forward[:, 1]
    keep = found & mutual & distinct
    return np.stack([rows[keep], nearest[keep]], axis=1)


def _two_nearest(
    queries: UInt8[np.ndarray, "n bytes"], train: UInt8[np.ndarray, "m bytes"], allowed: Bool[np.ndarray, "n m"] | None
) -> tuple[Int[np.ndarray, "n 2"], Int[np.ndarray, "n 2"]]:
    """Distances and rows of the two nearest; where there is none, the largest int32 and -1."""
    mask = None if allowed is None else np.ascontiguousarray(allowed, dtype=np.uint8)
    if len(train) == 1:  # OpenCV asks for at least as many rows as neighbours
        train = np.repeat(train, 2, axis=0)
        mask = np.pad(mask, ((0, 0), (0, 1))) if mask is not None else np.tile(np.array([1, 0], np.uint8), (len(queries), 1))
    distances, ids = cv2.batchDistance(queries, train, cv2.CV_32S, normType=cv2.NORM_HAMMING, K=2, mask=mask)
    return distances, ids.astype(np.intp)
