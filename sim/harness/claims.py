"""`Claim`: a statement about the figures of a run, and whether a result fulfils it.

A claim compares a figure with a number, such as "rooms.pq >= 0.6", or with a multiple of another figure of the same run,
such as "trajectory.ate_m <= 0.5 * trajectory.ate_odometry_m".
"""

import operator
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, is_dataclass, replace
from functools import lru_cache
from types import MappingProxyType, NoneType, UnionType
from typing import Any, Literal, get_args, get_origin, get_type_hints

from sim.errors import SimError
from sim.harness.results import MATCHES, RunResult, figure_meant
from sim.number_checks import is_finite
from sim.wording import class_of

_OPERATORS: Mapping[str, Callable[[float, float], bool]] = MappingProxyType(
    {"<=": operator.le, ">=": operator.ge, "==": operator.eq, "!=": operator.ne, "<": operator.lt, ">": operator.gt}
)
_NUMBER = r"[-+]?[\d.]+(?:[eE][-+]?\d+)?"
_FIGURE = r"[^\W\d][\w.]*(?:[ '-]+[\w.]+)*"
"""Name of a figure. The keys of mappings, such as names of rooms, may have several words."""
_FORM = re.compile(rf"\s*({_FIGURE})\s*(<=|>=|==|!=|<|>)\s*(?:({_NUMBER})|(?:({_NUMBER})\s*\*\s*)?({_FIGURE}))\s*")
ClaimOutcome = Literal["holds", "fails", "unknown"]
"""What a result says about a claim; "unknown" if the result lacks a figure of the claim."""


@dataclass(frozen=True)
class Claim:
    """A comparison of a figure with a limit. `figure` is a dotted name in `RunResult`, such as "labels.accuracy"."""

    figure: str
    comparison: str
    limit: float
    of: str | None = None
    """Another figure, of which `limit` is a multiple. None: the claim compares with `limit` itself."""

    def __post_init__(self) -> None:
        """Raise `SimError` for an unknown comparison or a limit that is not a finite number."""
        if self.comparison not in _OPERATORS:
            raise SimError(f"claim {str(self)!r:.80}: unknown comparison; valid: {' '.join(_OPERATORS)}")
        if not is_finite(self.limit):
            raise SimError(f"claim {self.figure!r:.80}: the limit is {self.limit!r:.40}; valid: a finite number")

    @staticmethod
    def parse(text: str, noun: str = "claim") -> "Claim":
        """Read a claim such as "labels.accuracy < 0.7" or "labels.accuracy > 1.1 * labels.accuracy_baseline".

        Raises `SimError` for another form or an unknown figure. The message calls the text by the `noun`.
        """
        if (match := _FORM.fullmatch(text)) is None:
            raise SimError(
                f"{noun} {text!r:.80} is not understood; "
                "valid: a figure, < <= > >= == or !=, and a number, or a number * figure"
            )
        figure, comparison, limit, factor, of = match.groups()
        number = limit or factor or "1"
        try:
            value = float(number)
        except ValueError:
            raise SimError(f"{noun} {text!r:.80}: {number!r} is no number; valid: a number such as 0.7") from None
        claim = Claim(figure, comparison, value, of)
        claim._check_names(noun)
        return claim

    @staticmethod
    def of_argument(place: str, claim: object) -> "Claim":
        """Return the claim that an argument gives as a `Claim` or as text; `place` names the argument in messages.

        Raises `SimError` for anything else, and for a text that `parse` does not understand.
        """
        if isinstance(claim, Claim):
            return claim
        if not isinstance(claim, str):
            raise SimError(f'{place} is {class_of(claim)}; valid: a claim, such as "rooms.pq >= 0.6"')
        return Claim.parse(claim)

    def __str__(self) -> str:
        limit = repr(float(self.limit)).removesuffix(".0")
        return f"{self.figure} {self.comparison} {limit}" + ("" if self.of is None else f" * {self.of}")

    @property
    def figures(self) -> tuple[str, ...]:
        """The names of the figures that the claim is about."""
        return (self.figure,) if self.of is None else (self.figure, self.of)

    @property
    def quantity(self) -> str:
        """What is compared with the number `limit`: the figure, or its ratio to the figure `of`."""
        return self.figure if self.of is None else f"{self.figure} / {self.of}"

    def value(self, result: RunResult) -> float | None:
        """Return the value of the figure in a result; None if this figure or the figure `of` is null.

        Raises `SimError` for a name that is no figure.
        """
        self._check_names()
        values = [self._number(result, name) for name in self.figures]
        return None if None in values else values[0]

    def outcome(self, result: RunResult) -> ClaimOutcome:
        """Return whether the claim "holds" or "fails" for a result; "unknown" if one of its figures is null."""
        if (value := self.value(result)) is None:
            return "unknown"
        return "holds" if _OPERATORS[self.comparison](value, self._bound(result)) else "fails"

    def margin(self, result: RunResult) -> float | None:
        """Return by how much a result fulfils the claim, in the unit of the figure; negative if the claim is violated.

        None if one of the claim's figures is null. Raises `SimError` for a claim with == or !=, which has no margin.
        """
        if self.comparison in ("==", "!="):
            raise SimError(f"claim {str(self)!r}: has no margin; valid: a claim with <, <=, > or >=")
        if (value := self.value(result)) is None:
            return None
        above = value - self._bound(result)
        return above if self.comparison.startswith(">") else -above

    def _bound(self, result: RunResult) -> float:
        """Return what the figure is compared with in a result in which no figure of the claim is null."""
        return self.limit * (1.0 if self.of is None else result[self.of])

    def described(self, result: RunResult) -> str:
        """Return the values of the claim's figures in a result as text, such as "labels.accuracy is 0.71"."""
        values = ((name, self._number(result, name)) for name in self.figures)
        return ", ".join(f"{name} is {'null' if value is None else f'{value:.4g}'}" for name, value in values)

    @property
    def is_about_plans(self) -> bool:
        """Whether a figure is about planning. If so, a robot has to drive the plans first, which takes seconds."""
        return any(name.startswith("planning.") for name in self.figures)

    @property
    def opposite(self) -> "Claim":
        """The claim that holds exactly if this claim fails."""
        pairs = (("<", ">="), (">", "<="), ("==", "!="))
        other = dict(pairs) | {b: a for a, b in pairs}
        return replace(self, comparison=other[self.comparison])

    def _number(self, result: RunResult, name: str) -> float | None:
        """Return the value of a figure; None for a missing key of a mapping, such as the label of an absent room."""
        try:
            value = result[name]
        except KeyError:
            return None
        return None if value is None else float(value)

    def _check_names(self, noun: str = "claim") -> None:
        for name in self.figures:
            _check_name(f"{noun} {str(self)!r}", name)


@lru_cache(maxsize=1000)  # every value of a claim checks its names
def _check_name(place: str, name: str) -> None:
    """Raise `SimError` unless results have a number of this name. The message begins with `place`.

    The keys of mappings are free, as they depend on the run: names of rooms, for example. Those of `place_recognition` are
    not free.
    """
    kind: Any = RunResult
    parts = name.split(".")
    for depth, part in enumerate(parts):
        if is_dataclass(kind):
            types = get_type_hints(kind)
            if part not in types:
                raise SimError(f"{place}: no figure {part!r}{figure_meant(kind, part)}; valid: {', '.join(types)}")
            kind = _without_none(types[part])
        elif get_origin(kind) is Mapping:
            if parts[:depth] == ["place_recognition"] and part not in map(str, MATCHES):
                raise SimError(f"{place}: no figure {part!r}; valid: {', '.join(map(str, MATCHES))}")
            kind = _without_none(get_args(kind)[1])
        else:
            raise SimError(f"{place}: {name} is no figure; valid: {'.'.join(parts[:depth])}")
    if is_dataclass(kind) or get_origin(kind) is Mapping:
        raise SimError(f"{place}: {name} is no number; valid: the name of a figure below it")
    if kind not in (int, float):
        raise SimError(f"{place}: {name} is no number; valid: a figure, such as labels.accuracy")


def _without_none(hint: Any) -> Any:
    """Return the type that an optional value has if it is not None; any other type as it is."""
    kinds = [kind for kind in get_args(hint) if kind is not NoneType]
    return kinds[0] if isinstance(hint, UnionType) else hint
