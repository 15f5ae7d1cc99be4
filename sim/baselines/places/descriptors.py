"""ORB descriptors for place recognition, and the training images from which visual vocabularies are learned."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import cv2
import numpy as np
from jaxtyping import Float16, UInt8

from lexis.config import LandmarkConfig
from lexis.features import FeatureExtractor
from lexis.types import Image
from sim.baselines.places.patches import patch_features
from sim.training.frames import frames_of_house
from sim.training.houses import TRAINING_SEEDS, draw_houses
from sim.training.viewpoints import LEXIS_VIEWS

ORB_FEATURES = 1000
"""Largest number of ORB key points in an image, as in ORB-SLAM."""
_FAST_THRESHOLD = 7
"""Least contrast of a corner [grey levels]; ORB-SLAM lowers it to this value where an image has few corners."""
_HOUSES, _SEED = 10, 8
_VIEWS = replace(LEXIS_VIEWS, most=30)


@dataclass(frozen=True, eq=False)
class TrainingDescriptors:
    """Descriptors of the images that vocabularies are learned from: for every image, one array of each kind."""

    orb: tuple[UInt8[np.ndarray, "_ 32"], ...]
    akaze: tuple[UInt8[np.ndarray, "_ 61"], ...]
    patches: tuple[Float16[np.ndarray, "_ channels"], ...]


def strongest_orb(image: Image) -> UInt8[np.ndarray, "n 32"]:
    """Return the ORB descriptors of an RGB image, those of the strongest key points first; none for a blank image."""
    orb = cv2.ORB.create(nfeatures=ORB_FEATURES, fastThreshold=_FAST_THRESHOLD)  # a new one per call keeps no state
    keypoints, descriptors = orb.detectAndCompute(cv2.cvtColor(image, cv2.COLOR_RGB2GRAY), None)
    if not keypoints:
        return np.zeros((0, 32), np.uint8)
    order = np.argsort([-keypoint.response for keypoint in keypoints], kind="stable")
    return np.asarray(np.asarray(descriptors)[order])


@lru_cache(maxsize=1)
def training_descriptors() -> TrainingDescriptors:
    """Return descriptors of 300 images from houses of all presets and looks, none of which is in a benchmark.

    This takes half a minute.
    """
    draws = draw_houses(_HOUSES, TRAINING_SEEDS, np.random.default_rng(_SEED))
    return described([image for draw in draws for image in frames_of_house(draw, _VIEWS).images])


def described(images: Sequence[Image]) -> TrainingDescriptors:
    """Compute the descriptors of training images."""
    akaze = FeatureExtractor(LandmarkConfig())
    return TrainingDescriptors(
        tuple(strongest_orb(image) for image in images),
        tuple(akaze.extract(image).descriptors for image in images),
        tuple(patch_features(image) for image in images),
    )
