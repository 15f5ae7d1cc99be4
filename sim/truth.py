"""`Truth`: the ground truth of one observation, which a session yields beside it."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from jaxtyping import Float64

from lexis.types import Camera, Observation, Poses


@dataclass(frozen=True, eq=False)
class Truth:
    """Ground truth at the time of an observation. It is never given to LEXIS."""

    index: int
    """Index of the frame in the tour, equal to the observation's index."""
    stamp: float
    """True time of the image [s]. Faults of clocks change only the stamp of the observation. The fault `kidnap` cuts a part
    out of the tour, and shifts both stamps of all later frames."""
    T_W_B: Float64[np.ndarray, "4 4"]
    """True pose of the body B in the world W."""
    room: int
    """Index into `House.rooms` of the room that contains the first camera."""
    label: str
    """Label of this room."""
    storey: int
    """Index of the storey that contains the first camera."""
    faults: tuple[str, ...] = ()
    """Names of the faults that changed this observation, in the order in which they were applied."""


def camera_positions(T_W_B: Poses, camera: Camera) -> Float64[np.ndarray, "n 3"]:
    """Return the positions of the first camera in W at poses of the body [m]. A frame belongs to the room of its camera."""
    return np.asarray((T_W_B @ camera.T_B_C)[:, :3, 3])


Stream: TypeAlias = Iterator[tuple[Observation, Truth]]
"""Observations in order of arrival, each with its ground truth."""
