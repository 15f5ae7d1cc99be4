"""What a fault is: a frozen dataclass whose fields have ranges, with a name that truth and command line use."""

import math
from abc import ABC, abstractmethod
from dataclasses import Field, dataclass, field, fields, replace
from typing import Any, ClassVar

import numpy as np

from lexis.types import Observation
from sim.errors import SimError
from sim.truth import Stream, Truth


def setting(default: int | float | None, low: int | float, high: int | float = math.inf, kw_only: bool = False) -> Any:
    """A field with a default and the range that its values have to be in, both ends included."""
    return field(default=default, kw_only=kw_only, metadata={"range": (low, high)})


@dataclass(frozen=True)
class Fault(ABC):
    """Something that goes wrong in a run. Raises `SimError` for a field out of its range."""

    name: ClassVar[str]

    def __post_init__(self) -> None:
        for each in fields(self):
            low, high = each.metadata["range"]
            value = getattr(self, each.name)
            if value is not None and not low <= value <= high:
                raise SimError(f"fault {self.name}: {each.name} is {value}; valid: {low:g} to {high:g}")


@dataclass(frozen=True)
class StreamFault(Fault):
    """A fault of the sensors or of what carries their data: it changes a stream, whichever scene that comes from."""

    @abstractmethod
    def apply(self, stream: Stream, rng: np.random.Generator) -> Stream:
        """The stream with the fault; every observation that is not as it was has the fault's name in its truth."""

    def mark(self, truth: Truth) -> Truth:
        """The truth that this fault is recorded in."""
        return replace(truth, faults=(*truth.faults, self.name))


@dataclass(frozen=True)
class SpanFault(StreamFault):
    """A fault that lasts for a span of true time."""

    at_s: float = setting(0.0, 0.0, kw_only=True)
    """When it begins, after the start of the tour [s]."""
    for_s: float = setting(math.inf, 0.0, kw_only=True)
    """How long it lasts [s]."""

    def active(self, truth: Truth) -> bool:
        """Whether the fault is there when this is true."""
        return self.at_s <= truth.stamp < self.at_s + self.for_s


@dataclass(frozen=True)
class FrameFault(SpanFault):
    """A fault that changes the observations of its span one by one; their number and order stay."""

    def apply(self, stream: Stream, rng: np.random.Generator) -> Stream:
        """The stream with the observations of the span changed."""
        for observation, truth in stream:
            if self.active(truth):
                yield self.change(observation, rng), self.mark(truth)
            else:
                yield observation, truth

    @abstractmethod
    def change(self, observation: Observation, rng: np.random.Generator) -> Observation:
        """The observation with the fault."""


def settings(kind: type[Fault]) -> "list[Field[float]]":
    """The fields of a kind of fault, its own before those that say when it happens."""
    return sorted(fields(kind), key=lambda each: bool(each.kw_only))
