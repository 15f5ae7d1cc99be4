"""`assert_rate`: a sequential test of whether a claim holds in a wanted share of houses.

The test may be evaluated after every house, and stops as soon as the answer is known. It is a sequential probability ratio
test whose alternative is a mixture of rates (Robbins, "Statistical methods related to the law of the iterated logarithm",
Annals of Mathematical Statistics 41, 1970). The evidence for a rate above the wanted rate `p` is a ratio: the probability of
the data averaged over all rates above `p`, divided by their probability at the rate `p`. If the true rate is `p` or below,
this ratio ever exceeds 1 / error with a probability of at most `error` (Ville's inequality). The evidence for a rate below
`p` is built in the same way.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.optimize import brentq
from scipy.special import betainc, betaincc, betaln, xlog1py, xlogy

from sim.errors import SimError
from sim.harness.claims import Claim
from sim.harness.results import RunResult
from sim.number_checks import check_between
from sim.verdicts.items import independent_results
from sim.verdicts.outcome import Outcome
from sim.wording import counted, percent

_LOWEST = 1e-9
"""Confidence bounds are searched among the rates from this rate to 1 minus this rate."""
_PRIOR = 0.5
"""Both parameters of the beta distribution that weights the alternative rates (Jeffreys' prior)."""


@dataclass(frozen=True)
class RateVerdict:
    """What the results in some houses show about the rate of a claim. Raises `SimError` for values out of range."""

    p: float
    """Wanted rate, in (0, 1)."""
    confidence: float
    """1 minus the largest probability of a wrong answer, in (0.5, 1). The bound holds for any true rate, and even if the
    answer is read after every house."""
    held: float
    """Number of houses in which the claim holds. A house that was examined several times counts by the share of its
    examinations in which the claim holds. The error bound stays valid, because the evidence is a convex function of this
    share."""
    houses: int
    """Number of houses that were examined."""

    def __post_init__(self) -> None:
        check_between("rate: p", self.p, 0.0, 1.0, 0.9)
        check_between("rate: confidence", self.confidence, 0.5, 1.0, 0.95)
        if not 0 <= self.held <= self.houses:
            raise SimError(f"rate: held is {self.held!r:.40} of {self.houses} houses; valid: 0 to {self.houses}")

    @property
    def outcome(self) -> Outcome:
        """Whether the rate is at least `p` ("holds"), below `p` ("fails"), or not yet known ("undecided")."""
        above, below = _log_evidence(self.p, self.held, self.houses - self.held)
        enough = -math.log1p(-self.confidence)
        return "holds" if above >= enough else "fails" if below >= enough else "undecided"

    @property
    def interval(self) -> tuple[float, float]:
        """Lower and upper confidence bound of the rate.

        The test holds for wanted rates below the lower bound, and fails for wanted rates above the upper bound. Each bound
        is wrong after any number of houses with a probability of at most 1 - `confidence`.
        """
        enough = -math.log1p(-self.confidence)

        def excess(rate: float, side: int) -> float:
            return _log_evidence(rate, self.held, self.houses - self.held)[side] - enough

        low, high = _LOWEST, 1.0 - _LOWEST
        lower = 0.0 if excess(low, 0) < 0.0 else brentq(excess, low, high, args=(0,))
        upper = 1.0 if excess(high, 1) < 0.0 else brentq(excess, low, high, args=(1,))
        return float(lower), float(upper)

    def __str__(self) -> str:
        low, high = (_beside(bound, self.p) for bound in self.interval)
        rate = f"rate at least {low}, at most {high} with {percent(self.confidence)} confidence"
        counts = f"holds in {round(self.held, 2):g} of {counted(self.houses, 'house')}"
        return f"{counts} (wanted: in {percent(self.p)}; {rate}): {self.outcome}"


def _beside(bound: float, p: float) -> str:
    """Return a bound as text, with as many decimals as are needed to tell it from `p`, but at least three."""
    return next((text for decimals in range(3, 9) if float(text := f"{bound:.{decimals}f}") != p), f"{bound:.3f}")


def _log_evidence(p: float, held: float, failed: float) -> tuple[float, float]:
    """Return the logarithms of the evidence for a rate above `p`, and for a rate below `p`."""
    a, b = held + _PRIOR, failed + _PRIOR
    whole = betaln(a, b) - betaln(_PRIOR, _PRIOR) - xlogy(held, p) - xlog1py(failed, -p)
    with np.errstate(divide="ignore"):  # data that exclude a side give it the evidence 0, whose logarithm is -inf
        above = whole + np.log(betaincc(a, b, p) / betaincc(_PRIOR, _PRIOR, p))
        below = whole + np.log(betainc(a, b, p) / betainc(_PRIOR, _PRIOR, p))
    return float(above), float(below)


def assert_rate(
    results: Iterable[RunResult],
    claim: Claim | str,
    p: float,
    confidence: float = 0.95,
    undecided: Literal["fail", "pass", "skip"] = "fail",
) -> RateVerdict:
    """Assert that a claim holds in at least a share `p` of houses; results are read only until the answer is known.

    A result without the figure counts as a failure of the claim, because the run did not show that the claim holds.

    Args:
        results: results of independent scenarios. A generator that runs one house at a time runs no more than needed.
        claim: a claim such as "rooms.pq >= 0.6".
        p: wanted rate, in (0, 1).
        confidence: 1 minus the largest probability of a wrong answer, in (0.5, 1).
        undecided: what happens if the results do not suffice for an answer: the test fails, passes or is skipped.

    Raises:
        AssertionError: the rate is below `p`, or the answer is undecided and `undecided` is "fail".
        SimError: an argument is not valid, or two results are of one scenario.
    """
    __tracebackhide__ = True  # pytest then shows the line of the test instead of these lines
    if undecided not in ("fail", "pass", "skip"):
        raise SimError(f"assert_rate: undecided is {undecided!r:.40}; valid: 'fail', 'pass' or 'skip'")
    wanted = Claim.of_argument("assert_rate: claim", claim)
    verdict, not_estimated = RateVerdict(p, confidence, 0, 0), 0
    for result in independent_results("assert_rate: results", results):
        outcome = wanted.outcome(result)
        not_estimated += outcome == "unknown"
        verdict = RateVerdict(p, confidence, verdict.held + (outcome == "holds"), verdict.houses + 1)
        if verdict.outcome != "undecided":
            break
    lacking = (
        f"; not estimated in {not_estimated} of {verdict.houses} results, which count as failures" if not_estimated else ""
    )
    if verdict.outcome == "fails" or (verdict.outcome == "undecided" and undecided == "fail"):
        raise AssertionError(f"{wanted}: {verdict}{lacking}")
    if verdict.outcome == "undecided" and undecided == "skip":
        import pytest  # only tests skip; elsewhere pytest need not be installed

        pytest.skip(f"{wanted}: {verdict}{lacking}")
    return verdict
