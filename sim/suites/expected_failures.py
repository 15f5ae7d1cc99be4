"""`ExpectedFailure`: checks of a suite that a SLAM is known to fail. The list is strict, so that it stays true."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from types import MappingProxyType

from sim.errors import SimError
from sim.wording import kind_of
from worlds.valid_names import did_you_mean, listed

NONE_EXPECTED: Mapping[str, str] = MappingProxyType({})
_INSTEAD = {
    "holds": "it holds now",
    "undecided": "it is undecided: more scenarios are needed",
    "not claimed": "it could not be decided in any scenario",
    "not examined": "no scenario reaches it",
}
"""What a check does instead of failing, by its outcome."""


@dataclass(frozen=True)
class ExpectedFailure:
    """A name of a check, or a pattern for the names of several checks, which are all expected to fail."""

    pattern: str
    reason: str
    checks: frozenset[str]
    """The names of the checks that the pattern stands for, each in the form "part: check"."""

    def instead(self, outcome: str) -> str:
        """Return what is wrong with this entry if one of its checks has the outcome, which is not "fails"."""
        said = f"expected to fail ({self.reason}), but {_INSTEAD[outcome]}"
        if outcome not in ("holds", "not claimed"):
            return said
        if len(self.checks) > 1:
            return f"{said}: let {self.pattern!r} in expected_failures name fewer checks, or remove it"
        return f"{said}: remove {self.pattern!r} from expected_failures"


def expected_failures_of(where: str, reasons: object, names: Sequence[str]) -> tuple[ExpectedFailure, ...]:
    """Return one entry for each pattern.

    Args:
        where: the function or the option that the reasons were given to, for messages.
        reasons: a mapping of patterns to the reasons why these checks fail. In a pattern, `*` stands for any text.
        names: the names of the checks, each in the form "part: check".

    Raises `SimError` if the reasons are no such mapping, or if a pattern stands for no check.
    """
    if not isinstance(reasons, Mapping):
        raise SimError(f"{where}: expected_failures is {kind_of(reasons)}; valid: a mapping of 'part: check' to a reason")
    return tuple(_entry(where, pattern, reason, names) for pattern, reason in reasons.items())


def _entry(where: str, pattern: object, reason: object, names: Sequence[str]) -> ExpectedFailure:
    if not isinstance(pattern, str):
        raise SimError(f"{where}: expected_failures has the key {pattern!r:.40}; valid: text, such as 'homes: a pause'")
    if not isinstance(reason, str) or not reason.strip():
        raise SimError(f"{where}: the reason of {pattern!r:.80} is {reason!r:.40}; valid: text that says why it fails")
    meant = frozenset(name for name in names if fnmatchcase(name, pattern))
    if not meant:
        raise SimError(f"{where}: no check {pattern!r:.80}{_guess(pattern, names)}; valid: {listed(names, most=10)}")
    return ExpectedFailure(pattern, reason, meant)


def _guess(pattern: str, names: Sequence[str]) -> str:
    """Return what was probably meant by a pattern that stands for no check; often, the part is missing."""
    for part, _, check in (name.partition(": ") for name in names):
        if fnmatchcase(check, pattern):
            return f" (did you mean {f'{part}: {pattern}'!r}?)"
    return did_you_mean(pattern, names)
