"""`compare`: are a SLAM's figures worse or better than another SLAM's on the same scenarios?

Each scenario gives a pair of results, so that differences between houses cancel. No distribution of the differences is
assumed: a figure is compared by the exact sign test, a claim by McNemar's exact test. Both count the scenarios in which one
SLAM does better, and ask whether these counts are as unequal as a fair coin hardly makes them. Several figures are compared
at once, so p-values are corrected by Holm's method: the stated confidence is that of all verdicts together.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from types import MappingProxyType
from typing import Literal

import numpy as np
from jaxtyping import Float64
from scipy.stats import binomtest, bootstrap

from sim.errors import SimError
from sim.harness.claims import Claim
from sim.harness.figures import check
from sim.harness.results import RunResult
from sim.harness.scenario import Scenario
from sim.harness.slam_under_test import SlamUnderTest

Change = Literal["worse", "better", "not shown to differ"]
FIGURES: Mapping[str, int] = MappingProxyType(
    {
        "labels.accuracy": 1,
        "rooms.pq": 1,
        "floors.accuracy": 1,
        "loops.recall": 1,
        "loops.false": -1,
        "trajectory.ate_m": -1,
        "planning.success": 1,
    }
)
"""Figures that are compared by default: 1 if a larger figure is better, -1 if a smaller one is."""
_ROUNDING = 1e-9
"""Differences up to this size are ties: the last digits of a figure may differ from machine to machine."""
_RESAMPLES = 2000


@dataclass(frozen=True, eq=False)
class FigureChange:
    """How a figure differs between SLAM a and SLAM b, over the scenarios for which both have the figure."""

    name: str
    sign: int
    """1 if a larger figure is better, -1 if a smaller one is."""
    a: Float64[np.ndarray, "n"]
    """The figure of SLAM a in each scenario."""
    b: Float64[np.ndarray, "n"]
    """The figure of SLAM b in each scenario."""

    @property
    def better(self) -> int:
        """Number of scenarios in which SLAM b does better."""
        return int((self.sign * (self.b - self.a) > _ROUNDING).sum())

    @property
    def worse(self) -> int:
        """Number of scenarios in which SLAM b does worse."""
        return int((self.sign * (self.b - self.a) < -_ROUNDING).sum())

    @property
    def p_value(self) -> float:
        """Two-sided p-value of the exact sign test; ties are left out."""
        return _coin(self.better, self.worse)

    @property
    def mean_change(self) -> float:
        """Mean of the figure of SLAM b minus that of SLAM a; NaN without scenarios."""
        return float((self.b - self.a).mean()) if len(self.a) else float("nan")

    def interval(self, confidence: float) -> tuple[float, float]:
        """Confidence interval of the mean change, by resampling the scenarios (bootstrap).

        If all changes are equal, both ends are that change.
        """
        changes = self.b - self.a
        if len(changes) < 2 or np.ptp(changes) <= _ROUNDING:
            return self.mean_change, self.mean_change
        resampled = bootstrap(
            (changes,), np.mean, n_resamples=_RESAMPLES, confidence_level=confidence, method="percentile", rng=0
        )
        low, high = resampled.confidence_interval
        return float(low), float(high)


@dataclass(frozen=True)
class ClaimChange:
    """In how many scenarios a claim holds for SLAM a, for SLAM b, or for both."""

    name: str
    only_a: int
    only_b: int
    both: int
    neither: int

    @property
    def better(self) -> int:
        """Number of scenarios in which the claim holds for SLAM b alone."""
        return self.only_b

    @property
    def worse(self) -> int:
        """Number of scenarios in which the claim holds for SLAM a alone."""
        return self.only_a

    @property
    def p_value(self) -> float:
        """Two-sided p-value of McNemar's exact test."""
        return _coin(self.better, self.worse)


@dataclass(frozen=True, eq=False)
class Comparison:
    """All changes from SLAM a to SLAM b. The confidence is that of all verdicts together."""

    scenarios: int
    """Number of scenarios that both SLAMs have run."""
    figures: tuple[FigureChange, ...]
    claims: tuple[ClaimChange, ...]
    confidence: float

    @cached_property
    def verdicts(self) -> Mapping[str, Change]:
        """Whether each figure and each claim, by name, is worse or better for SLAM b.

        By Holm's method, the smallest of k p-values may be at most (1 - confidence) / k, the next (1 - confidence) / (k - 1)
        and so on, until one is too large.
        """
        every: list[FigureChange | ClaimChange] = [*self.figures, *self.claims]
        changes = sorted(every, key=lambda change: change.p_value)
        verdicts: dict[str, Change] = {}
        shown = True
        for rank, change in enumerate(changes):
            shown = shown and change.p_value * (len(changes) - rank) <= 1.0 - self.confidence
            side: Change = "worse" if change.worse > change.better else "better"
            verdicts[change.name] = side if shown else "not shown to differ"
        return verdicts

    @property
    def worse(self) -> tuple[str, ...]:
        """Names of the figures and claims that are worse for SLAM b."""
        return tuple(name for name, verdict in self.verdicts.items() if verdict == "worse")

    def __str__(self) -> str:
        header = f"{'':22} {'a':>8} {'b':>8}   {'change':<29} {'better/worse':>12}  {'p':>7}  verdict"
        rows = [self._figure_row(each) for each in self.figures] + [self._claim_row(each) for each in self.claims]
        return "\n".join([f"{self.scenarios} scenarios, {self.confidence:.0%} confidence", header, *rows])

    def _figure_row(self, change: FigureChange) -> str:
        if not len(change.a):
            return f"{change.name:22} {'-':>8} {'-':>8}   no scenario in which both have the figure"
        low, high = change.interval(self.confidence)
        effect = f"{change.mean_change:+.3f} ({low:+.3f} to {high:+.3f})"
        return f"{change.name:22} {change.a.mean():8.3f} {change.b.mean():8.3f}   {effect:<29} {self._counts(change)}"

    def _claim_row(self, change: ClaimChange) -> str:
        a, b = change.only_a + change.both, change.only_b + change.both
        return f"{change.name:22} {a:8} {b:8}   {f'{b - a:+d} scenarios':<29} {self._counts(change)}"

    def _counts(self, change: FigureChange | ClaimChange) -> str:
        counts = f"{change.better}/{change.worse}"
        return f"{counts:>12}  {change.p_value:7.2g}  {self.verdicts[change.name]}"


def compare(
    a: Callable[[], SlamUnderTest],
    b: Callable[[], SlamUnderTest],
    scenarios: Iterable[Scenario],
    claims: Sequence[Claim | str] = (),
    confidence: float = 0.95,
) -> Comparison:
    """Run two SLAMs on the same scenarios and compare their results.

    Args:
        a: makes the SLAM to compare with, such as a class that takes no arguments.
        b: makes the SLAM that is judged.
        scenarios: the scenarios; each is run twice.
        claims: claims such as "rooms.pq >= 0.6" that are compared besides the figures.
        confidence: 1 minus the largest probability that a difference is stated where there is none, in (0.5, 1).

    Raises:
        SimError: an argument is not valid, or a scenario cannot be run.
    """
    pairs = [(check(scenario, a()), check(scenario, b())) for scenario in scenarios]
    return compare_results([first for first, _ in pairs], [second for _, second in pairs], claims, confidence=confidence)


def compare_results(
    a: Sequence[RunResult],
    b: Sequence[RunResult],
    claims: Sequence[Claim | str] = (),
    figures: Mapping[str, int] = FIGURES,
    confidence: float = 0.95,
) -> Comparison:
    """Compare results of SLAM a with results of SLAM b; results of one scenario form a pair, and others are ignored.

    Args:
        a: results of the SLAM to compare with, at most one for each scenario.
        b: results of the SLAM that is judged, at most one for each scenario.
        claims: claims that are compared besides the figures. A claim about an unknown figure counts as one that fails.
        figures: figures to compare by dotted name: 1 if a larger figure is better, -1 if a smaller one is.
        confidence: see `compare`.

    Raises:
        SimError: no scenario is common to both, a scenario occurs twice on one side, or an argument is not valid.
    """
    if not 0.5 < confidence < 1.0:
        raise SimError(f"compare: confidence is {confidence!r:.40}; valid: above 0.5, below 1, such as 0.95")
    first, second = _by_scenario(a), _by_scenario(b)
    common = [scenario for scenario in first if scenario in second]
    if not common:
        raise SimError(
            f"compare: the results of a ({len(first)} scenarios) and of b ({len(second)}) have no scenario in common; "
            "valid: results of two SLAMs on the same scenarios"
        )
    pairs = [(first[scenario], second[scenario]) for scenario in common]
    parsed = [Claim.parse(claim) if isinstance(claim, str) else claim for claim in claims]
    changes = tuple(_figure_change(name, sign, pairs) for name, sign in figures.items())
    return Comparison(len(pairs), changes, tuple(_claim_change(claim, pairs) for claim in parsed), confidence)


def _figure_change(name: str, sign: int, pairs: Sequence[tuple[RunResult, RunResult]]) -> FigureChange:
    claim = Claim.parse(f"{name} >= 0")  # checks the name
    values = [(claim.value(a), claim.value(b)) for a, b in pairs]
    known = np.array([(x, y) for x, y in values if x is not None and y is not None], float).reshape(-1, 2)
    return FigureChange(name, sign, known[:, 0], known[:, 1])


def _claim_change(claim: Claim, pairs: Sequence[tuple[RunResult, RunResult]]) -> ClaimChange:
    held = [(claim.outcome(a) == "holds", claim.outcome(b) == "holds") for a, b in pairs]
    counts = [held.count(case) for case in ((True, False), (False, True), (True, True), (False, False))]
    return ClaimChange(str(claim), *counts)


def _by_scenario(results: Sequence[RunResult]) -> dict[str, RunResult]:
    found: dict[str, RunResult] = {}
    for result in results:
        if result.scenario in found:
            raise SimError(f"compare: scenario {result.scenario} has two results on one side; valid: one result a scenario")
        found[result.scenario] = result
    return found


def _coin(first: int, second: int) -> float:
    """Two-sided p-value of counts as unequal as these, if both sides are equally likely."""
    return float(binomtest(first, first + second).pvalue) if first + second else 1.0
