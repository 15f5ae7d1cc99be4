"""What a session yields: an observation beside what is true when it is made."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TypeAlias

from jaxtyping import Float64
from numpy import ndarray

from lexis.types import Observation


@dataclass(frozen=True, eq=False)
class Truth:
    """What is true when an observation is made. It never reaches LEXIS."""

    index: int
    """Of the tour's frame, the observation's too."""
    stamp: float
    """True time of the image, whatever the observation says [s]."""
    T_W_B: Float64[ndarray, "4 4"]
    room: int
    """Index into `House.rooms` of the room that holds the camera."""
    label: str
    """Of that room."""
    storey: int
    faults: tuple[str, ...] = ()
    """Names of the faults that changed this observation, in the order in which they did."""


Stream: TypeAlias = Iterator[tuple[Observation, Truth]]
