"""`ExpectedFailure`: checks of a suite that a SLAM is known to fail. The list is strict, so that it stays true."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from pathlib import Path
from types import MappingProxyType

from pydantic import BaseModel

from lexis.files.reading import FileKind, read_model
from sim.errors import SimError
from sim.suites.suite_means import name_of_mean
from sim.wording import class_of
from worlds.valid_names import did_you_mean, listed

NONE_EXPECTED: Mapping[str, str] = MappingProxyType({})
_FAILS = "fails"
_FILE = FileKind("a file of lexis-sim check --suite --json", 500_000_000, SimError)
_INSTEAD = {
    "holds": "it holds now",
    "undecided": "it is undecided: more scenarios are needed",
    "not applicable": "it could not be decided in any scenario",
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
        if outcome == "not examined":
            return said
        advice = f"remove {self.pattern!r} from the expected failures"
        if len(self.checks) > 1:
            advice = f"let {self.pattern!r} in the expected failures name fewer checks, or remove it"
        return f"{said}, or {advice}" if outcome == "undecided" else f"{said}: {advice}"


class _Check(BaseModel):
    part: str
    check: str
    outcome: str


class _Mean(BaseModel):
    claim: str
    outcome: str


class _Verdicts(BaseModel):
    """The fields of a file of `lexis-sim check --suite --json` that say what failed."""

    suite: str
    seed: int
    checks: list[_Check]
    means: list[_Mean]


def known_failures(path: Path, suite: str, seed: int) -> dict[str, str]:
    """Return the checks and means that failed in an earlier run of a suite, each with a reason, as expected failures.

    `path` is a file of `lexis-sim check --suite --json`. Raises `SimError` for any other file, suite or seed.
    """
    found = read_model(path, _FILE, _Verdicts)
    if (found.suite, found.seed) != (suite, seed):
        raise SimError(
            f"{path}: is about the suite {found.suite} with seed {found.seed}; valid: a file of "
            f"lexis-sim check --suite {suite} --seed {seed} --json {path}"
        )
    names = [f"{each.part}: {each.check}" for each in found.checks if each.outcome == _FAILS]
    names += [name_of_mean(each.claim) for each in found.means if each.outcome == _FAILS]
    return dict.fromkeys(names, f"as in {path}")


def expected_failures_of(reasons: object, names: Sequence[str]) -> tuple[ExpectedFailure, ...]:
    """Return one entry for each pattern.

    Args:
        reasons: a mapping of patterns to the reasons why these checks fail. In a pattern, `*` stands for any text.
        names: the names of the checks, each in the form "part: check".

    Raises `SimError` if the reasons are no such mapping, or if a pattern stands for no check.
    """
    if not isinstance(reasons, Mapping):
        raise SimError(f"expected_failures is {class_of(reasons)}; valid: a mapping of 'part: check' to a reason")
    return tuple(_entry(pattern, reason, names) for pattern, reason in reasons.items())


def _entry(pattern: object, reason: object, names: Sequence[str]) -> ExpectedFailure:
    if not isinstance(pattern, str):
        raise SimError(f"expected_failures has the key {pattern!r:.40}; valid: text, such as 'homes: a pause'")
    if not isinstance(reason, str) or not reason.strip():
        raise SimError(
            f"expected_failures: the reason of {pattern!r:.80} is {reason!r:.40}; valid: text that says why it fails"
        )
    meant = frozenset([pattern] if pattern in names else [name for name in names if fnmatchcase(name, pattern)])
    if not meant:
        raise SimError(
            f"expected failures: no check {pattern!r:.80}{_guess(pattern, names)}; valid: {listed(names, most=10)}"
        )
    return ExpectedFailure(pattern, reason, meant)


def _guess(pattern: str, names: Sequence[str]) -> str:
    """Return what was probably meant by a pattern that stands for no check; often, the part or the limit is missing."""
    parts = dict.fromkeys(name.partition(": ")[0] for name in names)
    part, colon, check = pattern.partition(":")
    if colon and part not in parts:
        return did_you_mean(part, list(parts))
    for ending in ("", "*"):
        wanted = check.strip() + ending if colon else pattern + ending
        for place in [part] if colon else parts:
            if any(fnmatchcase(name, f"{place}: {wanted}") for name in names):
                return f" (did you mean {f'{place}: {wanted}'!r}?)"
    return did_you_mean(pattern, names)
