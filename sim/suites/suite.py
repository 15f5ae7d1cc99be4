"""`Suite`: scenarios, and the checks that a SLAM has to pass in these scenarios."""

from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from fractions import Fraction

import numpy as np

from sim.errors import SimError
from sim.harness.claims import Claim
from sim.harness.scenario import Scenario
from sim.harness.world_tests import RENDER_FRAME_RATE_HZ
from sim.number_checks import check_count, is_finite
from sim.suites.checks import Check, ClaimCheck
from sim.wording import class_of
from worlds.valid_names import did_you_mean, listed


@dataclass(frozen=True)
class SuitePart:
    """Scenarios of one kind, with their checks.

    Raises `SimError` for two checks of one name, for no scenario or group, and for checks that cannot be hashed, as those of
    a dataclass that is not frozen.
    """

    name: str
    about: str
    """What the scenarios have in common and what they show about a SLAM, in one or two sentences."""
    draw: Callable[[np.random.Generator, int], Scenario]
    """A function that draws the scenario with a number, counted from 0. Raises `SimError` or `WorldsError` for an unlucky
    draw."""
    checks: tuple[Check, ...]
    n: int
    """Number of scenarios."""
    group: int = 1
    """Number of successive scenarios that are drawn with the same random numbers, for houses that differ in one property.
    The scenarios of a group are not independent, so a check counts once for each group, by the share of the group's
    scenarios in which it holds."""
    on_images: bool = False
    """Whether the scenarios are rendered, whatever their own fidelity is."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "checks", tuple(self.checks))
        _check_unique(f"part {self.name}", "check", (check.name for check in self.checks))
        for check in self.checks:
            _check_hashable(self.name, check)
        check_count(f"part {self.name}: n", self.n, 1)
        check_count(f"part {self.name}: group", self.group, 1)

    def scenario(self, rng: np.random.Generator, number: int) -> Scenario:
        """Draw the scenario with a number. Raises `SimError` or `WorldsError` for an unlucky draw."""
        drawn = self.draw(rng, number)
        if not self.on_images:
            return drawn
        rate_hz = max(drawn.frame_rate_hz, RENDER_FRAME_RATE_HZ)
        return replace(drawn, fidelity="render", frame_rate_hz=rate_hz)

    def check_named(self, name: str) -> Check | None:
        """Return the check with a name; None if the part has none of this name, such as that the run completes."""
        return next((check for check in self.checks if check.name == name), None)

    @property
    def limited_twice(self) -> frozenset[str]:
        """The quantities about which the part makes claims from below and claims from above."""
        made = {(check.claim.quantity, check.claim.comparison[0]) for check in self.checks if isinstance(check, ClaimCheck)}
        return frozenset(quantity for quantity, side in made if side == "<" and (quantity, ">") in made)

    def with_limits(self, limits: Mapping[str, float]) -> "SuitePart":
        """Return the part with new limits; `limits` maps the `quantity` of a claim to its new limit.

        If the part makes several claims about a quantity, only the claim with the largest rate is kept.
        """
        claims = [check for check in self.checks if isinstance(check, ClaimCheck)]
        strictest = {check.claim.quantity: check for check in sorted(claims, key=lambda check: check.rate)}
        kept = []
        for check in self.checks:
            if not isinstance(check, ClaimCheck) or check.claim.quantity not in limits:
                kept.append(check)
            elif check == strictest[check.claim.quantity]:
                kept.append(replace(check, claim=replace(check.claim, limit=limits[check.claim.quantity])))
        return replace(self, checks=tuple(kept))


@dataclass(frozen=True)
class Suite:
    """A named set of parts by which any SLAM can be checked. Raises `SimError` for two parts of one name, or for no part."""

    name: str
    about: str
    parts: tuple[SuitePart, ...]
    means: tuple[Claim, ...] = ()
    """Claims that have to hold on average over the scenarios of all parts. They are judged after the last scenario."""

    def __post_init__(self) -> None:
        _check_unique(f"suite {self.name}", "part", (part.name for part in self.parts))
        _check_unique(f"suite {self.name}", "mean", (claim.quantity for claim in self.means))
        for claim in self.means:
            if claim.comparison in ("==", "!="):
                raise SimError(f"suite {self.name}: the mean of {str(claim)!r} has no margin; valid: <, <=, > or >=")
        if not self.parts:
            raise SimError(f"suite {self.name}: has no part; valid: one or more")

    def with_limits(self, limits: Mapping[str, float]) -> "Suite":
        """Return the suite with other limits in its claims, such as {"labels.accuracy": 0.9}.

        The key of a claim that relates two figures is their ratio: "trajectory.ate_m / trajectory.ate_odometry_m". The key
        of a claim about a mean begins with "mean": "mean labels.accuracy". Raises `SimError` for a key about which the suite
        makes no claim, for a claim with == or !=, and for a limit that is not finite.
        """
        if not isinstance(limits, Mapping):
            raise SimError(f"suite {self.name}: limits is {class_of(limits)}; valid: a mapping, such as {{'rooms.pq': 0.5}}")
        made = [check.claim for part in self.parts for check in part.checks if isinstance(check, ClaimCheck)]
        known = {claim.quantity for claim in made} | {f"mean {claim.quantity}" for claim in self.means}
        equalities = {claim.quantity: claim for claim in made if claim.comparison in ("==", "!=")}
        both = {quantity for part in self.parts for quantity in part.limited_twice}
        for figure, limit in limits.items():
            if figure not in known:
                guess, valid = did_you_mean(str(figure), known), listed(sorted(known), 8)
                raise SimError(
                    f"suite {self.name}: has no claim about {figure!r:.60}{guess}; valid: {valid}, see its verdicts"
                )
            if figure in equalities:
                raise SimError(f"suite {self.name}: {equalities[figure]} has no limit; valid: claims with <, <=, > or >=")
            if figure in both:
                how = "is limited from below and from above by one part, to which one limit does not apply"
                raise SimError(f"suite {self.name}: {figure!r} {how}; valid: other claims")
            if not is_finite(limit):
                raise SimError(f"suite {self.name}: the limit of {figure} is {limit!r:.40}; valid: a finite number")
        means = (replace(claim, limit=limits.get(f"mean {claim.quantity}", claim.limit)) for claim in self.means)
        return replace(self, parts=tuple(part.with_limits(limits) for part in self.parts), means=tuple(means))

    def with_size(self, share: float) -> "Suite":
        """Return the suite with `share` times as many scenarios, and at least one scenario or one group in each part.

        The claims about means are left out if rounding changes the proportions of the parts, because their limits were set
        for the suite's own mixture of parts. Raises `SimError` for a share that is not positive and finite.
        """
        if not is_finite(share) or share <= 0.0:
            raise SimError(f"suite {self.name}: the share is {share!r:.40}; valid: a positive number, such as 0.5 or 2")
        parts = tuple(replace(part, n=max(1, round(share * part.n / part.group)) * part.group) for part in self.parts)
        shares = {Fraction(new.n, old.n) for new, old in zip(parts, self.parts, strict=True)}
        return replace(self, parts=parts, means=self.means if len(shares) == 1 else ())

    def without_laws(self) -> "Suite":
        """Return the suite with its claims only, which takes less time because laws run the SLAM again.

        Parts that consist of laws only are left out, unless the suite makes claims about means: these are about the
        scenarios of all parts, which are therefore still run. Raises `SimError` if nothing is left.
        """
        claims = [(part, tuple(check for check in part.checks if isinstance(check, ClaimCheck))) for part in self.parts]
        if not self.means and not any(checks for _, checks in claims):
            raise SimError(f"suite {self.name}: has laws only; valid: with laws, or a suite that makes claims")
        return replace(self, parts=tuple(replace(part, checks=checks) for part, checks in claims if checks or self.means))

    def with_images(self) -> "Suite":
        """Return the suite with rendered images in all scenarios, for a SLAM that does not accept features."""
        return replace(self, parts=tuple(replace(part, on_images=True) for part in self.parts))


def claims(rate: float, *texts: str) -> tuple[ClaimCheck, ...]:
    """Make claims, each of which has to hold in the share `rate` of the scenarios."""
    return tuple(ClaimCheck(Claim.parse(text), rate) for text in texts)


def _check_hashable(part: str, check: Check) -> None:
    """Raise `SimError` unless a check can be hashed: drawn scenarios are remembered by part and checks."""
    try:
        hash(check)
    except TypeError as error:
        valid = "a check such as a frozen dataclass of texts, numbers and tuples"
        raise SimError(f"part {part}: check {check.name!r} cannot be hashed: {error}; valid: {valid}") from None


def _check_unique(where: str, what: str, names: Iterable[str]) -> None:
    twice = [name for name, count in Counter(names).items() if count > 1]
    if twice:
        raise SimError(f"{where}: the {what} {twice[0]!r} occurs twice; valid: different names")
