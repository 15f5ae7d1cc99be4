"""`Claim`: a statement about the figures of a run, such as "rooms.pq >= 0.6", and whether a result fulfils it."""

import operator
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, is_dataclass
from types import MappingProxyType
from typing import Any, Literal, get_type_hints

from sim.errors import SimError
from sim.harness.results import RunResult

_OPERATORS: Mapping[str, Callable[[float, float], bool]] = MappingProxyType(
    {"<=": operator.le, ">=": operator.ge, "==": operator.eq, "!=": operator.ne, "<": operator.lt, ">": operator.gt}
)
_FORM = re.compile(r"\s*([\w.]+)\s*(<=|>=|==|!=|<|>)\s*([-+]?[\d.]+(?:[eE][-+]?\d+)?)\s*")
Outcome = Literal["holds", "fails", "unknown"]


@dataclass(frozen=True)
class Claim:
    """A comparison of a figure with a limit. `figure` is a dotted name in `RunResult`, such as "labels.accuracy"."""

    figure: str
    comparison: str
    limit: float

    @staticmethod
    def parse(text: str) -> "Claim":
        """Read a claim such as "labels.accuracy < 0.7". Raises `SimError` for another form or an unknown figure."""
        if (match := _FORM.fullmatch(text)) is None:
            raise SimError(f"claim {text!r:.80} is not understood; valid: a figure, < <= > >= == or !=, and a number")
        try:
            claim = Claim(match[1], match[2], float(match[3]))
        except ValueError:
            raise SimError(f"claim {text!r:.80}: {match[3]!r} is no number; valid: a number such as 0.7") from None
        _check_name(claim)
        return claim

    def __str__(self) -> str:
        return f"{self.figure} {self.comparison} {self.limit:g}"

    def value(self, result: RunResult) -> float | None:
        """The figure's value in a result; None if the run cannot have it. Raises `SimError` for a name that is no figure."""
        _check_name(self)
        try:
            value = result[self.figure]
        except KeyError:  # a key of a mapping that this run lacks, such as a label that the house does not have
            return None
        if value is not None and not isinstance(value, int | float):
            raise SimError(f"claim {str(self)!r}: {self.figure} is no number; valid: the name of a figure below it")
        return None if value is None else float(value)

    def outcome(self, result: RunResult) -> Outcome:
        """Whether the claim "holds" or "fails" for a result; "unknown" if the figure is None."""
        value = self.value(result)
        if value is None:
            return "unknown"
        return "holds" if _OPERATORS[self.comparison](value, self.limit) else "fails"

    @property
    def is_about_plans(self) -> bool:
        """Whether the figure is about planning: a robot then has to drive the plans first, which takes seconds."""
        return self.figure.startswith("planning.")

    @property
    def opposite(self) -> "Claim":
        """The claim that holds exactly if this claim fails."""
        pairs = (("<", ">="), (">", "<="), ("==", "!="))
        other = dict(pairs) | {b: a for a, b in pairs}
        return Claim(self.figure, other[self.comparison], self.limit)


def _check_name(claim: Claim) -> None:
    """Raise `SimError` unless results have the figure. Names inside a mapping, such as room names, are not checked."""
    kind: Any = RunResult
    for part in claim.figure.split("."):
        if not is_dataclass(kind):
            return
        types = get_type_hints(kind)
        if part not in types:
            raise SimError(f"claim {str(claim)!r}: {claim.figure!r}: no figure {part!r}; valid: {', '.join(types)}")
        kind = types[part]
    if is_dataclass(kind):
        raise SimError(f"claim {str(claim)!r}: {claim.figure} is no number; valid: the name of a figure below it")
