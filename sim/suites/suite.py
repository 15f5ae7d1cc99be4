"""`Suite`: scenarios, with what a SLAM has to fulfil in them."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from sim.errors import SimError
from sim.harness.claims import Claim
from sim.harness.scenario import Scenario
from sim.suites.checks import Check, ClaimCheck
from worlds.valid_names import did_you_mean


@dataclass(frozen=True)
class SuitePart:
    """Scenarios of one distribution, with their checks."""

    name: str
    about: str
    """What the scenarios have in common and what they are to show, in one or two sentences."""
    draw: Callable[[np.random.Generator, int], Scenario]
    """Draws the scenario with a number, counted from 0. Raises `SimError` or `WorldsError` for an unlucky draw."""
    checks: tuple[Check, ...]
    n: int
    """Number of scenarios."""
    group: int = 1
    """Number of successive scenarios that are drawn with the same random numbers, for houses that differ in one property."""

    def with_limits(self, limits: Mapping[str, float]) -> "SuitePart":
        """Return the part with new limits; `limits` maps the name of a figure to the new limit of the claims about it."""
        return replace(self, checks=tuple(_with_limit(check, limits) for check in self.checks))


@dataclass(frozen=True)
class Suite:
    """A named set of parts, which any SLAM can be checked by."""

    name: str
    about: str
    parts: tuple[SuitePart, ...]
    budget_s: float
    """Time that the whole suite takes LEXIS on two processor cores [s]."""

    def with_limits(self, limits: Mapping[str, float]) -> "Suite":
        """Return the suite with other limits in its claims, such as {"labels.accuracy": 0.9}.

        Raises `SimError` for a figure about which the suite makes no claim.
        """
        checks = [check for part in self.parts for check in part.checks]
        known = {check.claim.figure for check in checks if isinstance(check, ClaimCheck)}
        for figure in limits:
            if figure not in known:
                guess = did_you_mean(figure, known)
                raise SimError(
                    f"suite {self.name}: has no claim about {figure!r:.60}{guess}; valid: {', '.join(sorted(known))}"
                )
        return replace(self, parts=tuple(part.with_limits(limits) for part in self.parts))

    def with_size(self, share: float) -> "Suite":
        """Return the suite with a multiple of its scenarios, at least one in each part."""
        return replace(self, parts=tuple(replace(part, n=max(1, round(share * part.n))) for part in self.parts))


def claims(rate: float, *texts: str) -> tuple[ClaimCheck, ...]:
    """Make claims, each of which has to hold in the share `rate` of the scenarios."""
    return tuple(ClaimCheck(Claim.parse(text), rate) for text in texts)


def _with_limit(check: Check, limits: Mapping[str, float]) -> Check:
    if not isinstance(check, ClaimCheck) or check.claim.figure not in limits:
        return check
    return replace(check, claim=replace(check.claim, limit=limits[check.claim.figure]))
