"""`Truth`: the ground truth of one observation, which a session yields beside it."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TypeAlias

from jaxtyping import Float64
from numpy import ndarray

from lexis.types import Observation


@dataclass(frozen=True, eq=False)
class Truth:
    """Ground truth at the time of an observation. It is never given to LEXIS."""

    index: int
    """Index of the frame in the tour, equal to the observation's index."""
    stamp: float
    """True time of the image [s]. Faults of clocks change only the stamp of the observation. The fault `kidnap` cuts a part
    out of the tour, and shifts both stamps of all later frames."""
    T_W_B: Float64[ndarray, "4 4"]
    """True pose of the body B in the world W."""
    room: int
    """Index into `House.rooms` of the room that contains the body."""
    label: str
    """Label of the room that contains the body."""
    storey: int
    """Index of the storey that contains the body."""
    faults: tuple[str, ...] = ()
    """Names of the faults that changed this observation, in the order in which they were applied."""


Stream: TypeAlias = Iterator[tuple[Observation, Truth]]
"""Observations in order of arrival, each with its ground truth."""
