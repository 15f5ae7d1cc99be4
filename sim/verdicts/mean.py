"""`assert_mean`: a test of whether a claim holds on average over houses.

A rate says in how many houses a claim holds, and therefore little about a SLAM that is slightly worse in every house. A mean
shows small differences much sooner. The test is the one-sided t test ("Student", "The probable error of a mean", Biometrika
6, 1908). It is valid if the number of houses was chosen beforehand: unlike a rate, a mean must not be judged after every
house. It is approximate: it assumes that the mean of so many margins is nearly normal. Where a few houses have much smaller
margins than all others, "fails" is more certain than stated, and "holds" is less certain, because the examined houses may
lack such a house. Where a few houses have much larger margins, it is the other way round.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from scipy.stats import t as student

from sim.errors import SimError
from sim.harness.claims import Claim
from sim.harness.results import RunResult
from sim.number_checks import check_between
from sim.verdicts.items import independent_results
from sim.verdicts.outcome import Outcome
from sim.wording import counted, percent

_ROUNDING = 1e-12
"""Largest margin below 0 that counts as 0, because figures are rounded when they are computed."""
_FEWEST = 8
"""Fewest houses over which a mean is judged. With fewer, one unusual house decides."""


@dataclass(frozen=True)
class MeanVerdict:
    """What the results in some houses show about the mean margin of a claim. Raises `SimError` for values out of range."""

    confidence: float
    """1 minus the probability of a wrong answer where the mean is at the limit and margins are normal, in (0.5, 1)."""
    margins: tuple[float, ...]
    """By how much each house fulfils the claim; negative where the claim is violated. See `Claim.margin`."""

    def __post_init__(self) -> None:
        check_between("mean: confidence", self.confidence, 0.5, 1.0, 0.95)
        if not all(map(math.isfinite, self.margins)):
            raise SimError("mean: a margin is not finite; valid: finite numbers")

    @property
    def mean(self) -> float | None:
        """The mean margin; None without a house."""
        return float(np.mean(self.margins)) if self.margins else None

    @property
    def interval(self) -> tuple[float, float]:
        """Lower and upper confidence bound of the mean margin; each is wrong with probability 1 - `confidence`."""
        if len(self.margins) < _FEWEST:
            return -math.inf, math.inf
        half = student.ppf(self.confidence, len(self.margins) - 1) * np.std(self.margins, ddof=1) / len(self.margins) ** 0.5
        mean = float(np.mean(self.margins))
        return mean - float(half), mean + float(half)

    @property
    def outcome(self) -> Outcome:
        """Whether the mean margin is at least 0 ("holds"), below 0 ("fails"), or not known well enough ("undecided")."""
        low, high = self.interval
        return "holds" if low >= -_ROUNDING else "fails" if high < -_ROUNDING else "undecided"

    def __str__(self) -> str:
        mean = "without a value"
        if self.mean is not None:
            mean = f"{'fulfilled' if self.mean >= 0.0 else 'missed'} by {abs(self.mean):.3g} on average"
        low, high = self.interval
        bounds = f"at least {low:.3g}, at most {high:.3g} with {percent(self.confidence)} confidence"
        return f"in {counted(len(self.margins), 'house')} {mean} ({bounds}): {self.outcome}"


def assert_mean(results: Iterable[RunResult], claim: Claim | str, confidence: float = 0.95) -> MeanVerdict:
    """Assert that a claim such as "rooms.pq >= 0.6" is not violated on average over houses.

    The assertion passes unless the results show that the mean violates the claim. The verdict that is returned says whether
    they show that the mean fulfils it. Results without the figure are left out. All results are read before the mean is
    judged.

    Args:
        results: results of independent scenarios, whose number does not depend on the results.
        claim: a claim with <, <=, > or >=.
        confidence: 1 minus the largest probability that the assertion fails although the claim holds on average, if the
            margins are normal or a few of them are much smaller than the others.

    Raises:
        AssertionError: the mean violates the claim, with this confidence.
        SimError: an argument is not valid, two results are of one scenario, or fewer than 8 results have the figure, which
            could not fail.
    """
    __tracebackhide__ = True  # pytest then shows the line of the test instead of these lines
    wanted = Claim.of_argument("assert_mean: claim", claim)
    margins = (wanted.margin(result) for result in independent_results("assert_mean: results", results))
    verdict = MeanVerdict(confidence, tuple(margin for margin in margins if margin is not None))
    if (n := len(verdict.margins)) < _FEWEST:
        have = f"{counted(n, 'result')} with the figures of {str(wanted)!r}"
        raise SimError(f"assert_mean: there {'is' if n == 1 else 'are'} {have}; valid: {_FEWEST} or more")
    if verdict.outcome == "fails":
        raise AssertionError(f"{wanted} {verdict}")
    return verdict
