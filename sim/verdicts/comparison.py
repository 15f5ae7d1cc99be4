"""`compare`: are a SLAM's figures worse or better than another SLAM's on the same scenarios?

Each scenario gives a pair of results, so that differences between houses cancel. Scenarios of one house and one seed, such
as those with several values of openness, count as one, because they are not independent. Walks through one house with
several seeds count as several; their verdict is about that house alone. No distribution of the differences is assumed: a
figure is compared by the exact sign test, a claim by McNemar's exact test. Both count the scenarios in which one SLAM does
better. If the SLAMs were equal, each of these scenarios would be like the toss of a fair coin; the p-value is the
probability that as many tosses give counts at least as unequal. Several figures are compared at once, so p-values are
corrected by Holm's method: the stated confidence holds for all verdicts together.
"""

from collections import Counter
from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import count
from types import MappingProxyType
from typing import Literal, NamedTuple

import numpy as np
from jaxtyping import Bool, Float64
from scipy.stats import binom, binomtest

from sim.errors import SimError
from sim.harness.claims import Claim
from sim.harness.crash import COMPLETES
from sim.harness.figures import check
from sim.harness.results import RunResult
from sim.harness.scenario import Scenario
from sim.harness.slam_under_test import SlamUnderTest, check_slam_factory, made_slam
from sim.number_checks import check_between
from sim.verdicts.items import items
from sim.wording import counted, percent

Change = Literal["worse", "better", "not shown to differ"]


class Rule(NamedTuple):
    """How two values of a figure are compared."""

    sign: int
    """1 if a larger figure is better, -1 if a smaller figure is better."""
    tie: float
    """Differences up to this size do not matter and count as ties."""


FIGURES: Mapping[str, Rule] = MappingProxyType(
    {
        "labels.accuracy": Rule(1, 0.002),
        "rooms.pq": Rule(1, 0.002),
        "floors.accuracy": Rule(1, 0.002),
        "loops.recall": Rule(1, 0.002),
        "loops.false": Rule(-1, 0.5),
        "place_recognition.1.precision": Rule(1, 0.0005),
        "trajectory.ate_m": Rule(-1, 0.001),
        "trajectory.rpe_8m_m": Rule(-1, 0.001),
        "planning.success": Rule(1, 0.002),
        "coverage.path_covered": Rule(1, 0.01),  # the walk goes on after the last keyframe, by up to 1 % of a short one
    }
)
"""Figures that are compared by default."""
_Pair = tuple[RunResult, RunResult]


@dataclass(frozen=True, eq=False)
class FigureChange:
    """How a figure differs between SLAM a and SLAM b, over independent scenarios; scenarios of one house count as one."""

    name: str
    rule: Rule
    a: Float64[np.ndarray, "n"]
    """The figure of SLAM a in each independent scenario, as a mean if several scenarios have one house; NaN without the
    figure."""
    b: Float64[np.ndarray, "n"]
    """The figure of SLAM b in each independent scenario, as a mean if several scenarios have one house; NaN without the
    figure."""

    @property
    def better(self) -> int:
        """Number of scenarios in which SLAM b does better, or has the figure where SLAM a does not."""
        gained = np.isnan(self.a) & ~np.isnan(self.b)
        return int((self.rule.sign * self.changes > self.rule.tie).sum() + gained.sum())

    @property
    def worse(self) -> int:
        """Number of scenarios in which SLAM b does worse, or does not have the figure where SLAM a has it."""
        lost = np.isnan(self.b) & ~np.isnan(self.a)
        return int((self.rule.sign * self.changes < -self.rule.tie).sum() + lost.sum())

    @property
    def means(self) -> tuple[float | None, float | None]:
        """Mean of the figure of SLAM a and of SLAM b over the scenarios in which both have it.

        If there is no such scenario, each mean is over the scenarios in which the SLAM has the figure; None without any.
        """
        a, b = (self.a[self._both], self.b[self._both]) if self._both.any() else (_known(self.a), _known(self.b))
        return (float(a.mean()) if len(a) else None, float(b.mean()) if len(b) else None)

    @property
    def p_value(self) -> float:
        """Two-sided p-value of the exact sign test; ties are left out."""
        return _coin(self.better, self.worse)

    @property
    def changes(self) -> Float64[np.ndarray, "k"]:
        """Figure of SLAM b minus that of SLAM a, in ascending order, for the scenarios in which both have the figure."""
        return np.sort(self.b[self._both] - self.a[self._both])

    @property
    def _both(self) -> Bool[np.ndarray, "n"]:
        """Whether both SLAMs have the figure in each scenario."""
        return np.asarray(~np.isnan(self.a) & ~np.isnan(self.b))

    def interval(self, confidence: float) -> tuple[float, float] | None:
        """Return the confidence interval of the median change, found by inverting the sign test.

        The result is None if there are too few scenarios.
        """
        changes = self.changes
        rank = int(binom.ppf((1.0 - confidence) / 2.0, len(changes), 0.5)) if len(changes) else 0
        if rank < 1:
            return None
        return float(changes[rank - 1]), float(changes[-rank])


@dataclass(frozen=True)
class ClaimChange:
    """Numbers of independent scenarios in which a claim holds more often for SLAM a, or more often for SLAM b."""

    name: str
    only_a: int
    only_b: int
    others: int
    """Number of scenarios in which the claim holds equally often for both SLAMs."""
    shares: tuple[float, float]
    """Share of all scenarios in which the claim holds for SLAM a and for SLAM b."""

    @property
    def better(self) -> int:
        """Number of scenarios in which the claim holds more often for SLAM b than for SLAM a."""
        return self.only_b

    @property
    def worse(self) -> int:
        """Number of scenarios in which the claim holds more often for SLAM a than for SLAM b."""
        return self.only_a

    @property
    def p_value(self) -> float:
        """Two-sided p-value of McNemar's exact test."""
        return _coin(self.better, self.worse)


@dataclass(frozen=True, eq=False)
class Comparison:
    """All changes from SLAM a to SLAM b. The confidence holds for all verdicts together."""

    names: tuple[str, str]
    """Names of both SLAMs, for the title of the table."""
    scenarios: int
    """Number of scenarios for which both SLAMs have a result."""
    houses: int
    """Number of independent scenarios among `scenarios`: scenarios of one house count as one."""
    figures: tuple[FigureChange, ...]
    claims: tuple[ClaimChange, ...]
    confidence: float

    @cached_property
    def verdicts(self) -> Mapping[str, Change]:
        """Whether each figure and each claim, by name, is worse or better for SLAM b.

        By Holm's method, the smallest of k p-values may be at most (1 - confidence) / k, the next (1 - confidence) / (k - 1)
        and so on. The first p-value that is larger than its limit, and all p-values after it, show no difference.
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
    def fewest_houses(self) -> int:
        """Smallest number of houses in which a difference can be shown, if each of them is worse for the same SLAM."""
        return next(n for n in count(1) if _coin(n, 0) * (len(self.figures) + len(self.claims)) <= 1.0 - self.confidence)

    @property
    def worse(self) -> tuple[str, ...]:
        """Names of the figures and claims that are worse for SLAM b."""
        return tuple(name for name, verdict in self.verdicts.items() if verdict == "worse")

    def __str__(self) -> str:
        size = f"{counted(self.scenarios, 'scenario')} in {counted(self.houses, 'house')}"
        title = f"a: {self.names[0]}, b: {self.names[1]}; {size}"
        sure = percent(self.confidence)
        confidence = f"confidence: {sure} for all verdicts together, and {sure} for the interval of each median change"
        width = max(len(name) for name in self.verdicts)
        means = f"{'mean a':>8} {'mean b':>8}"
        header = f"{'':{width}} {means}   {'median change':<28} {'better/worse':>12}  {'p':>7}  verdict"
        rows = [self._figure_row(each, width) for each in self.figures]
        rows += [self._claim_row(each, width) for each in self.claims]
        return "\n".join([title, *self._shortage(), confidence, header, *rows, *self._gaps()])

    def _gaps(self) -> Iterator[str]:
        """Yield a sentence for every figure that one of the SLAMs does not have in all houses."""
        for change in self.figures:
            if alone := int((np.isnan(change.a) != np.isnan(change.b)).sum()):
                houses = f"{alone} of {counted(len(change.a), 'house')}"
                left_out = ", and these are left out of the means and the median" if change.changes.size else ""
                yield f"{change.name}: only one SLAM has it in {houses}, which count for this SLAM{left_out}"

    def _shortage(self) -> Iterator[str]:
        """Yield a sentence if the houses are too few for any difference, however large it is."""
        none_shown = set(self.verdicts.values()) == {"not shown to differ"}
        if none_shown and self.houses < self.fewest_houses:
            houses = counted(self.houses, "house")
            yield f"with {houses} no difference can be shown; at least {self.fewest_houses} are needed"

    def _figure_row(self, change: FigureChange, width: int) -> str:
        within = change.interval(self.confidence)
        median = f"{np.median(change.changes):+.3f}" if len(change.changes) else ""
        effect = f"{median} ({within[0]:+.3f} to {within[1]:+.3f})" if within else median
        means = ["-" if mean is None else f"{mean:.3f}" for mean in change.means]
        return f"{change.name:{width}} {means[0]:>8} {means[1]:>8}   {effect:<28} {self._counts(change)}"

    def _claim_row(self, change: ClaimChange, width: int) -> str:
        shares = [f"{share:.0%}" for share in change.shares]
        return f"{change.name:{width}} {shares[0]:>8} {shares[1]:>8}   {'':<28} {self._counts(change)}"

    def _counts(self, change: FigureChange | ClaimChange) -> str:
        counts = f"{change.better}/{change.worse}"
        return f"{counts:>12}  {change.p_value:7.2g}  {self.verdicts[change.name]}"


def compare(
    a: Callable[[], SlamUnderTest],
    b: Callable[[], SlamUnderTest],
    scenarios: Iterable[Scenario],
    claims: Sequence[Claim | str] = (),
    figures: Mapping[str, Rule] = FIGURES,
    confidence: float = 0.95,
) -> Comparison:
    """Run two SLAMs on the same scenarios and compare their results. An exception of a SLAM ends the comparison.

    Args:
        a: makes the SLAM to compare with, such as a class that takes no arguments.
        b: makes the SLAM that is judged.
        scenarios: the scenarios; each is run twice.
        claims: claims such as "rooms.pq >= 0.6" that are compared besides the figures.
        figures: the figures to compare, by dotted name.
        confidence: 1 minus the largest probability that a difference is stated where there is none, in (0.5, 1).

    Raises:
        SimError: an argument is not valid, what `a` or `b` makes is no SLAM, or a scenario cannot be run.
    """
    valid = "a class or function without arguments; results of programs are compared by `compare_results`"
    for name, new_slam in (("a", a), ("b", b)):
        check_slam_factory(f"compare: {name}", new_slam, valid)
    wanted = _checked(claims, figures, confidence)
    chosen = list(items("compare: scenarios", Scenario, scenarios))
    hashes = Counter(scenario.content_hash for scenario in chosen)
    if repeated := [scenario for scenario in chosen if hashes[scenario.content_hash] > 1]:
        raise SimError(f"compare: the scenario with seed {repeated[0].seed} is given twice; valid: different scenarios")
    pairs = [(check(scenario, made_slam(a)), check(scenario, made_slam(b))) for scenario in chosen]
    return compare_results([first for first, _ in pairs], [second for _, second in pairs], wanted, figures, confidence)


def compare_results(
    a: Sequence[RunResult],
    b: Sequence[RunResult],
    claims: Sequence[Claim | str] = (),
    figures: Mapping[str, Rule] = FIGURES,
    confidence: float = 0.95,
) -> Comparison:
    """Compare results of SLAM a with results of SLAM b; results of one scenario form a pair.

    A scenario for which only one of the SLAMs has a result counts under "the run completes". There, too, scenarios of one
    house count as one: the SLAM that has results for more of these scenarios does better.

    Args:
        a: results of the SLAM to compare with, at most one for each scenario.
        b: results of the SLAM that is judged, at most one for each scenario.
        claims: claims that are compared besides the figures. A claim about a null figure counts as one that fails.
        figures: the figures to compare, by dotted name. A figure that neither SLAM has is left out.
        confidence: see `compare`.

    Raises:
        SimError: no scenario is common to both, a scenario occurs twice on one side, or an argument is not valid.
    """
    wanted = _checked(claims, figures, confidence)
    a, b = list(items("compare: a", RunResult, a)), list(items("compare: b", RunResult, b))
    first, second = _by_scenario(a), _by_scenario(b)
    common = [scenario for scenario in first if scenario in second]
    if not common:
        raise SimError(
            f"compare: the results of a ({len(first)} scenarios) and of b ({len(second)}) have no scenario in common; "
            "valid: results of two SLAMs on the same scenarios"
        )
    groups: dict[Hashable, list[_Pair]] = {}
    for scenario in common:
        groups.setdefault(_house(first[scenario]), []).append((first[scenario], second[scenario]))
    houses = list(groups.values())
    changes = (_figure_change(name, rule, houses) for name, rule in figures.items())
    return Comparison(
        (a[0].slam, b[0].slam),
        len(common),
        len(houses),
        tuple(change for change in changes if not np.isnan([*change.a, *change.b]).all()),
        (_completed_change(a, b), *(_claim_change(claim, houses) for claim in wanted)),
        confidence,
    )


def _checked(claims: object, figures: object, confidence: object) -> list[Claim]:
    """Return the claims, each once. Raises SimError for a claim, a figure or a confidence that is not valid."""
    check_between("compare: confidence", confidence, 0.5, 1.0, 0.95)
    if not isinstance(figures, Mapping) or not all(isinstance(rule, Rule) for rule in figures.values()):
        raise SimError(f"compare: figures is {figures!r:.60}; valid: a mapping, such as {{'rooms.pq': Rule(1, 0.002)}}")
    for name in figures:
        Claim.parse(f"{name} >= 0")
    if isinstance(claims, str):
        raise SimError(f"compare: claims is the text {claims!r:.60}; valid: a list of claims, such as [{claims!r:.60}]")
    given = items("compare: claims", object, claims)
    return list(dict.fromkeys(Claim.of_argument(f"compare: claims[{i}]", claim) for i, claim in enumerate(given)))


def _figure_change(name: str, rule: Rule, houses: Sequence[Sequence[_Pair]]) -> FigureChange:
    claim = Claim(name, ">=", 0.0)

    means = [_house_means([(claim.value(a), claim.value(b)) for a, b in house]) for house in houses]
    values = np.array(means, float)
    return FigureChange(name, rule, values[:, 0], values[:, 1])


def _house_means(pairs: Sequence[tuple[float | None, float | None]]) -> tuple[float, float]:
    """Return the means of both sides over the scenarios of one house in which both have the figure.

    If there is no such scenario, each side has the mean of its own figures; NaN stands for no figure.
    """
    shared = [pair for pair in pairs if None not in pair] or pairs
    a, b = ([value for value in side if value is not None] for side in zip(*shared, strict=True))
    return float(np.mean(a)) if a else np.nan, float(np.mean(b)) if b else np.nan


def _claim_change(claim: Claim, houses: Sequence[Sequence[_Pair]]) -> ClaimChange:
    held = ([[claim.outcome(result) == "holds" for result in pair] for pair in house] for house in houses)
    counts = [(sum(a for a, _ in house), sum(b for _, b in house)) for house in held]
    return _counted(str(claim), counts, sum(len(house) for house in houses))


def _completed_change(a: Sequence[RunResult], b: Sequence[RunResult]) -> ClaimChange:
    """Compare how many scenarios of each house have a result."""
    done_a, done_b = (Counter(map(_house, side)) for side in (a, b))
    counts = [(done_a[house], done_b[house]) for house in done_a.keys() | done_b.keys()]
    return _counted(COMPLETES, counts, len({result.scenario for result in (*a, *b)}))


def _house(result: RunResult) -> Hashable:
    """Return what identifies the house and the seed of a result.

    Scenarios of one house and one seed may differ in openness, light or furniture.
    """
    return result.seed, result.preset, result.house.rooms, result.house.floors, result.house.area_m2


def _counted(name: str, counts: Sequence[tuple[int, int]], scenarios: int) -> ClaimChange:
    """Return the change of a claim from the numbers of scenarios in which it holds for SLAM a and SLAM b, for each house.

    `scenarios` is the number of scenarios of all houses together.
    """
    only_a, only_b = sum(a > b for a, b in counts), sum(b > a for a, b in counts)
    shares = sum(a for a, _ in counts) / scenarios, sum(b for _, b in counts) / scenarios
    return ClaimChange(name, only_a, only_b, len(counts) - only_a - only_b, shares)


def _by_scenario(results: Sequence[RunResult]) -> dict[str, RunResult]:
    found: dict[str, RunResult] = {}
    for result in results:
        if result.scenario in found:
            raise SimError(f"compare: scenario {result.scenario} has two results on one side; valid: one result a scenario")
        found[result.scenario] = result
    return found


def _known(values: Float64[np.ndarray, "n"]) -> Float64[np.ndarray, "k"]:
    return np.asarray(values[~np.isnan(values)])


def _coin(first: int, second: int) -> float:
    """Return the two-sided p-value of counts as unequal as these, if both sides are equally likely."""
    return float(binomtest(first, first + second).pvalue) if first + second else 1.0
