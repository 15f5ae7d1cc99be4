"""What a suite checks in each scenario: claims about figures, and laws that relate two runs.

A law needs no threshold for how good a SLAM is. It compares a run with a second run whose input was changed in a way that
must not matter, or that may only help (metamorphic testing; Chen et al., "Metamorphic testing: a review of challenges and
opportunities", ACM Computing Surveys 51, 2018). Each law states its tolerance, and why it needs one.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple, Protocol

from sim.errors import SimError
from sim.harness.claims import Claim
from sim.harness.figures import evaluate
from sim.harness.results import RunResult
from sim.harness.runner import Run, run
from sim.harness.scenario import Scenario
from sim.harness.slam_under_test import SlamUnderTest
from sim.suites.agreement import ClaimAgreement, agreement
from sim.suites.stream_changes import StreamChange, changed
from worlds.errors import WorldsError

NewSlam = Callable[[], SlamUnderTest]
"""Makes a SLAM that has not run yet."""
ALWAYS = 0.99
"""Rate of a check that may never fail: one scenario in which it fails decides."""
_SMALLER_IS_BETTER = ("trajectory.", "loops.false", "rooms.splits", "rooms.merges")


class Examined(NamedTuple):
    """A finished run and its figures."""

    run: Run
    result: RunResult


class CheckFinding(NamedTuple):
    """What a check found in one scenario."""

    holds: bool | None
    """Whether the check holds in this scenario. None: it cannot be decided, for example because the SLAM does not report the
    figure."""
    measured: str
    """The measured values, for the report."""


class Check(Protocol):
    """Interface of what a suite checks in each scenario."""

    @property
    def name(self) -> str:
        """Name of the check, unique in its suite."""

    @property
    def says(self) -> str:
        """What the check demands, and for a law why its tolerance is as it is, in one or two sentences."""

    @property
    def rate(self) -> float:
        """Share of scenarios in which the check has to hold, in (0, 1)."""

    def examine(self, base: Examined, new_slam: NewSlam) -> CheckFinding:
        """Examine one scenario, of which `base` is the unchanged run. Laws make a second run."""


@dataclass(frozen=True)
class ClaimCheck:
    """A claim about a figure, such as "rooms.pq >= 0.5", which has to hold in a share of the scenarios."""

    claim: Claim
    rate: float

    @property
    def name(self) -> str:
        """The claim as text."""
        return str(self.claim)

    @property
    def says(self) -> str:
        """The claim and its rate."""
        return f"{self.claim} in {self.rate:.0%} of the scenarios"

    def examine(self, base: Examined, new_slam: NewSlam) -> CheckFinding:
        """Compare the figure of the unchanged run with the limit."""
        value = self.claim.value(base.result)
        if value is None:
            return CheckFinding(None, f"{self.claim.figure} is null")
        return CheckFinding(self.claim.outcome(base.result) == "holds", f"{self.claim.figure} is {value:.3g}")


@dataclass(frozen=True)
class SameClaims:
    """A law about the input: after a change that must not matter, the SLAM makes the same claims about every frame."""

    name: str
    says: str
    change: StreamChange
    least: float = 1.0
    """Least agreement of frames, labels, rooms, floors and loops, in [0, 1]; see `ClaimAgreement`."""
    position_m: float = 1e-3
    """Largest allowed distance between the positions that the two runs report for the same frame [m]."""
    rate: float = ALWAYS
    compare_loops: bool = True
    """Whether the loop closures have to agree, too."""

    def examine(self, base: Examined, new_slam: NewSlam) -> CheckFinding:
        """Run the SLAM on the changed input, and compare the claims."""
        second = run(base.run.scenario, changed(new_slam(), self.change))
        found = agreement(base.run.estimate, second.estimate)
        return CheckFinding(self._holds(found), _written(found))

    def _holds(self, found: ClaimAgreement) -> bool:
        loops = found.loops if self.compare_loops else None
        shares = (found.frames, found.labels, found.rooms, found.floors, loops)
        near = found.position_m is None or found.position_m <= self.position_m
        return near and all(share is None or share >= self.least - 1e-9 for share in shares)


@dataclass(frozen=True)
class SimilarFigures:
    """A law about the scenario: after a change, figures stay within tolerances of those of the unchanged scenario."""

    name: str
    says: str
    change: Callable[[Scenario], Scenario]
    """Returns the changed scenario. Raises `SimError` or `WorldsError` where the change is impossible."""
    tolerances: tuple[tuple[str, float], ...]
    """For each figure, how much worse it may be after the change."""
    both_ways: bool = True
    """Whether a figure may not be better by more than the tolerance, either, because the change is neutral."""
    rate: float = 0.7

    def examine(self, base: Examined, new_slam: NewSlam) -> CheckFinding:
        """Run the SLAM on the changed scenario, and compare the figures."""
        try:
            scenario = self.change(base.run.scenario)
            second = evaluate(run(scenario, new_slam()))
        except (WorldsError, SimError) as error:
            return CheckFinding(None, f"the change is impossible: {error}")
        pairs = {
            name: (before, after)
            for name, _ in self.tolerances
            if (before := base.result[name]) is not None and (after := second[name]) is not None
        }
        if not pairs:
            return CheckFinding(None, "no figure in both runs")
        holds = all(self._within(name, *pair) for name, pair in pairs.items())
        return CheckFinding(holds, ", ".join(f"{name} {a:.3g} -> {b:.3g}" for name, (a, b) in pairs.items()))

    def _within(self, name: str, before: float, after: float) -> bool:
        worse = after - before if name.startswith(_SMALLER_IS_BETTER) else before - after
        tolerance = dict(self.tolerances)[name]
        return worse <= tolerance and (not self.both_ways or -worse <= tolerance)


def _written(found: ClaimAgreement) -> str:
    """Write an agreement in one line: the shares that agree, and how far apart the positions are."""
    shares = {name: getattr(found, name) for name in ("frames", "labels", "rooms", "floors", "loops")}
    text = ", ".join(f"{share:.1%} of the {name}" for name, share in shares.items() if share is not None)
    apart = "" if found.position_m is None else f"; positions differ by up to {found.position_m:.2g} m"
    return f"the run on the changed input agrees on {text}{apart}"
