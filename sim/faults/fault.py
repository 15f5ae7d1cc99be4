"""Base classes of faults: frozen dataclasses whose fields have valid ranges.

A fault class is identified by its `name` in the ground truth, and by `name` and field names on the command line.
"""

import math
from abc import ABC, abstractmethod
from dataclasses import Field, dataclass, field, fields, replace
from typing import Any, ClassVar

import numpy as np

from lexis.types import Observation
from sim.errors import SimError
from sim.truth import Stream, Truth

LARGEST = 1e10
"""Largest number in a fault. A clock that is reset to 1970 jumps back by 1.8e9 s."""


def setting(default: int | float | None, low: int | float, high: int | float = LARGEST, kw_only: bool = False) -> Any:
    """Define a field of a fault, with a default value and a valid range from `low` to `high`, both included.

    The default may be infinite; a scenario file leaves it out, because JSON has no such number.
    """
    return field(default=default, kw_only=kw_only, metadata={"range": (low, high)})


def has_pose(observation: Observation) -> bool:
    """Return whether the pose of an observation is finite: another fault may have made it NaN."""
    return bool(np.isfinite(observation.T_O_B).all())


@dataclass(frozen=True)
class Fault(ABC):
    """A disturbance that is injected into a run. Raises `SimError` for a field that is no number or out of its range."""

    name: ClassVar[str]

    def __post_init__(self) -> None:
        for each in fields(self):
            value = getattr(self, each.name)
            if isinstance(value, np.generic):  # JSON, in which scenarios are stored, has no numbers of numpy
                value = value.item()
            if each.type is int and isinstance(value, float) and value.is_integer():
                value = int(value)
            object.__setattr__(self, each.name, value)
            if valid := _what_is_valid(each, value):
                raise SimError(f"fault {self.name}: {each.name} is {value!r:.40}; valid: {valid}")


def _what_is_valid(of: "Field[Any]", value: object) -> str | None:
    """Describe the valid values of a field if `value` is none of them; return None if it is valid."""
    (low, high), whole = of.metadata["range"], of.type is int
    if value is None and of.default is None:
        return None
    if isinstance(value, bool) or not isinstance(value, int if whole else int | float):
        return f"a {'whole ' if whole else ''}number from {low:g} to {high:g}"
    return None if value == of.default or low <= value <= high else f"{low:g} to {high:g}"


@dataclass(frozen=True)
class StreamFault(Fault):
    """A fault of the sensors or of their data transfer. It changes the stream of observations, not the world."""

    @abstractmethod
    def apply(self, stream: Stream, rng: np.random.Generator) -> Stream:
        """Yield the stream with the fault. The truth of each changed observation is marked with the fault's name."""

    def mark(self, truth: Truth) -> Truth:
        """Return `truth` with this fault's name added."""
        return replace(truth, faults=(*truth.faults, self.name))


@dataclass(frozen=True)
class SpanFault(StreamFault):
    """A fault of the stream that is active during one span of the true time."""

    at_s: float = setting(0.0, 0.0, kw_only=True)
    """Time after the start of the tour at which the fault begins [s]."""
    for_s: float = setting(math.inf, 0.0, kw_only=True)
    """Duration of the fault [s]."""

    def active(self, truth: Truth) -> bool:
        """Whether the fault is active at the time of `truth`."""
        return self.at_s <= truth.stamp < self.at_s + self.for_s


@dataclass(frozen=True)
class FrameFault(SpanFault):
    """A fault that changes each observation in its time span. It keeps the number and the order of the observations."""

    def apply(self, stream: Stream, rng: np.random.Generator) -> Stream:
        """Yield the stream, with all observations in the fault's time span changed by `change`."""
        for observation, truth in stream:
            if self.active(truth):
                yield self.change(observation, rng), self.mark(truth)
            else:
                yield observation, truth

    @abstractmethod
    def change(self, observation: Observation, rng: np.random.Generator) -> Observation:
        """Return the observation with the fault."""


def settings(kind: type[Fault]) -> "list[Field[float]]":
    """Return the fields of a kind of fault: first positional fields, then keyword-only fields, such as the time span."""
    return sorted(fields(kind), key=lambda each: bool(each.kw_only))
