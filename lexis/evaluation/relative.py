"""Distances and angles between poses, used to evaluate loops and place recognition."""

import numpy as np
from jaxtyping import Float64, Int

from lexis.maths.se3 import between, rotation_angle
from lexis.maths.ties import near_pairs, rounded
from lexis.types import Poses


def separation(
    first: Float64[np.ndarray, "m 4 4"], second: Float64[np.ndarray, "m 4 4"]
) -> tuple[Float64[np.ndarray, "m"], Float64[np.ndarray, "m"]]:
    """Return the distances [m] and angles of rotation [rad] between the poses `first[i]` and `second[i]`, for every i.

    They are rounded to a millionth, so that a comparison with a limit does not depend on the choice of the world frame.
    """
    relative = between(first, second)
    return rounded(np.linalg.norm(relative[:, :3, 3], axis=1)), rounded(rotation_angle(relative))


def pairs_within(T_W_B: Poses, metres: float) -> tuple[Int[np.ndarray, "m"], Int[np.ndarray, "m"]]:
    """Indices of all ordered pairs of poses that are at most `metres` apart, each pose with itself included, in order.

    Distances are rounded to a millionth. Memory grows with the number of these pairs, and not with the number of all pairs.
    """
    positions = T_W_B[:, :3, 3]
    pairs, each = near_pairs(positions, metres), np.arange(len(positions))
    first, second = (np.concatenate([pairs[:, i], pairs[:, 1 - i], each]) for i in (0, 1))
    order = np.lexsort((second, first))
    return first[order], second[order]
