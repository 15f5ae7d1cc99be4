"""Extraction of AKAZE key points with binary descriptors (paper, Sec. III-A), and matching of descriptors."""

import cv2
import numpy as np
from jaxtyping import Bool, Int, UInt8

from lexis.config import LandmarkConfig
from lexis.errors import LexisError
from lexis.types import NO_FEATURES, Features, Image

OPENCV = "opencv-python-headless>=4.10,<5"
"""Versions of OpenCV that LEXIS works with, as pip writes them. OpenCV 5 has no AKAZE in its main package."""


class FeatureExtractor:
    """Extracts AKAZE features from images."""

    def __init__(self, config: LandmarkConfig) -> None:
        """Create the detector. Raises LexisError if the installed OpenCV has no AKAZE."""
        if not hasattr(cv2, "AKAZE"):
            found = getattr(cv2, "__version__", "of unknown version")  # a half-removed OpenCV is an empty package
            raise LexisError(f"OpenCV {found} has no AKAZE; valid: '{OPENCV}', installed without any other OpenCV")
        self._akaze = cv2.AKAZE.create(threshold=config.akaze_threshold, max_points=config.max_features)

    def extract(self, image: Image) -> Features:
        """Return key points and descriptors of an RGB image. An image without texture may have none."""
        grey = cv2.cvtColor(image, cv2.COLOR_RGB2GRAY)
        keypoints, descriptors = self._akaze.detectAndCompute(grey, None)
        if not keypoints:
            return NO_FEATURES
        return Features(np.array([keypoint.pt for keypoint in keypoints], np.float32), np.asarray(descriptors))


def mutual_matches(
    first: UInt8[np.ndarray, "n bytes"],
    second: UInt8[np.ndarray, "m bytes"],
    ratio: float,
    allowed: Bool[np.ndarray, "n m"] | None = None,
    max_distance: int = 488,
) -> Int[np.ndarray, "k 2"]:
    """Match two arrays of descriptors; return pairs of row numbers, the first in `first` and the second in `second`.

    The two rows are nearest neighbours of each other by Hamming distance. The row of `first` must also pass Lowe's ratio
    test: its distance to the nearest row is less than to the second-nearest, and at most `ratio` times the latter.

    With `allowed`, only the pairs that it marks are compared. A wrong pair may then have no second-nearest row and pass the
    ratio test, so bound the distance of pairs by `max_distance` [bits].
    """
    if len(first) == 0 or len(second) == 0:
        return np.zeros((0, 2), np.intp)
    forward, forward_ids = _two_nearest(first, second, allowed)
    _, backward_ids = _two_nearest(second, first, None if allowed is None else allowed.T)
    rows = np.arange(len(first))
    nearest = forward_ids[:, 0]
    found = (nearest >= 0) & (forward[:, 0] <= max_distance)
    mutual = backward_ids[nearest, 0] == rows
    distinct = (forward[:, 0] < forward[:, 1]) & (forward[:, 0] <= ratio * forward[:, 1])
    keep = found & mutual & distinct
    return np.stack([rows[keep], nearest[keep]], axis=1)


def _two_nearest(
    queries: UInt8[np.ndarray, "n bytes"], train: UInt8[np.ndarray, "m bytes"], allowed: Bool[np.ndarray, "n m"] | None
) -> tuple[Int[np.ndarray, "n 2"], Int[np.ndarray, "n 2"]]:
    """Return distances and rows of the two nearest neighbours.

    A missing neighbour has the largest int32 as distance, and row -1.
    """
    mask = None if allowed is None else np.ascontiguousarray(allowed, dtype=np.uint8)
    if len(train) == 1:  # OpenCV needs at least as many rows as neighbours: add a masked copy
        train = np.repeat(train, 2, axis=0)
        mask = np.pad(mask, ((0, 0), (0, 1))) if mask is not None else np.tile(np.array([1, 0], np.uint8), (len(queries), 1))
    distances, ids = cv2.batchDistance(queries, train, cv2.CV_32S, normType=cv2.NORM_HAMMING, K=2, mask=mask)
    return distances, ids.astype(np.intp)
