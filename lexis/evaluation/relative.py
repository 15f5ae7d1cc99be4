"""Distances and angles between poses, used to evaluate loops and place recognition."""

import numpy as np
from jaxtyping import Float64, Int

from lexis.maths.se3 import between, rotation_angle
from lexis.types import Poses


def separation(
    T_W_B: Poses, first: Int[np.ndarray, "m"], second: Int[np.ndarray, "m"]
) -> tuple[Float64[np.ndarray, "m"], Float64[np.ndarray, "m"]]:
    """Distances [m] and angles of rotation [rad] between the poses with indices `first[i]` and `second[i]`, for every i."""
    relative = between(T_W_B[first], T_W_B[second])
    return np.linalg.norm(relative[:, :3, 3], axis=1), rotation_angle(relative)
