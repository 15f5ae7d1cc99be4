"""Distances and angles between poses, used to evaluate loops and place recognition."""

import numpy as np
from jaxtyping import Float64, Int
from scipy.spatial import cKDTree

from lexis.maths.se3 import between, rotation_angle
from lexis.types import Poses

_SPARE = 1.0 + 1e-9
"""Factor by which the search radius for pairs is larger, so that rounding in the search loses no pair."""


def separation(
    T_W_B: Poses, first: Int[np.ndarray, "m"], second: Int[np.ndarray, "m"]
) -> tuple[Float64[np.ndarray, "m"], Float64[np.ndarray, "m"]]:
    """Distances [m] and angles of rotation [rad] between the poses with indices `first[i]` and `second[i]`, for every i."""
    relative = between(T_W_B[first], T_W_B[second])
    return np.linalg.norm(relative[:, :3, 3], axis=1), rotation_angle(relative)


def pairs_within(T_W_B: Poses, metres: float) -> tuple[Int[np.ndarray, "m"], Int[np.ndarray, "m"]]:
    """Indices of all ordered pairs of poses that are at most `metres` apart, each pose with itself included, in order.

    Memory grows with the number of these pairs, and not with the number of all pairs.
    """
    positions = T_W_B[:, :3, 3]
    pairs = cKDTree(positions).query_pairs(metres * _SPARE, output_type="ndarray")
    each = np.arange(len(positions))
    first, second = (np.concatenate([pairs[:, i], pairs[:, 1 - i], each]) for i in (0, 1))
    near = np.linalg.norm(positions[first] - positions[second], axis=1) <= metres
    order = np.lexsort((second[near], first[near]))
    return first[near][order], second[near][order]
