"""Landmarks as a `Percept` gives them."""

import numpy as np

from lexis.types import Landmarks


def without_key_points(points):
    """Landmarks at positions in the body frame (m, 3) [m], which no key point of the image belongs to."""
    return Landmarks(points, np.full(len(points), -1))
