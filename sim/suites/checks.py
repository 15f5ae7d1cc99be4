"""What a suite checks in each scenario: claims about figures, and laws, most of which relate two runs.

A law needs no threshold for how good a SLAM is. The laws in this module compare a run with a second run whose input was
changed. The change must matter little, or should do no harm (metamorphic testing; Chen et al., "Metamorphic testing: a
review of challenges and opportunities", ACM Computing Surveys 51, 2018). Each law states its tolerance and the reason for
this tolerance.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Literal, NamedTuple, Protocol, runtime_checkable

from lexis.errors import one_line
from lexis.evaluation.trajectory import LEAST_POSES
from lexis.types import Percept
from sim.errors import EstimateError, ProgramError, SimError
from sim.harness.claims import Claim
from sim.harness.crash import Crash, attempt, attempt_plans
from sim.harness.diagnosis.usual_mistakes import usual_mistakes
from sim.harness.estimate import Estimate, EstimatedLoops
from sim.harness.figures import EvaluatedRun, evaluate
from sim.harness.finished_run import Run
from sim.harness.results import group_of
from sim.harness.runner import Progress, run
from sim.harness.scenario import Scenario
from sim.harness.slam_under_test import CommandSlam, SlamUnderTest, made_slam
from sim.harness.walk import walk
from sim.number_checks import check_between
from sim.programs.program import Program
from sim.suites.agreement import EstimateAgreement, agreement
from sim.suites.changed_stream import changed
from sim.suites.stream_changes import StreamChange
from sim.wording import percent
from worlds.errors import WorldsError

NewSlam = Callable[[], SlamUnderTest] | Program
"""A function that makes a SLAM that has not run yet; or a program under test, which reads recordings of the scenarios."""
_QUANTITIES = ("labels", "rooms", "floors", "loops", "T_W_B")
_NEEDED_BY: Mapping[str, str] = MappingProxyType(
    {name: name for name in ("labels", "rooms", "floors", "loops")}
    | {"trajectory": "T_W_B", "place_recognition": "candidates"}
)
"""Field of `Estimate` that figures need, by the first part of their names. A figure that is null although the field is
estimated does not apply to the scenario, such as the recall of loops on a walk without revisits."""
_SHARES = ("frames", "labels", "rooms", "floors", "loops")
"""The figures of `EstimateAgreement` that are not distances or angles."""


class CheckFinding(NamedTuple):
    """What a check found in one scenario."""

    holds: bool | None
    """Whether the check holds in this scenario. None: it cannot be decided, for example because the SLAM does not report the
    figure."""
    measured: str
    """The measured values, for the report."""
    is_crash: bool = False
    """Whether the SLAM raised an exception, or a program failed, so that there is nothing to check."""
    is_withheld: bool = False
    """Whether the check cannot be decided because the SLAM does not estimate what it is about. If the SLAM estimates this in
    another scenario of the part, the check counts as failed here."""


@runtime_checkable
class Check(Protocol):
    """Interface of what a suite checks in each scenario."""

    @property
    def name(self) -> str:
        """Name of the check, unique in its part. Checks of one name in several parts are the same law."""

    @property
    def says(self) -> str:
        """What the check demands and, for a law, the reason for its tolerance, in one or two sentences."""

    @property
    def rate(self) -> float | None:
        """Share of scenarios in which the check has to hold, in (0, 1); None: in all of them, and one failure decides."""

    def examine(self, base: EvaluatedRun, new_slam: NewSlam) -> CheckFinding:
        """Examine one scenario; `base` is the unchanged run of this scenario. Most laws run the SLAM a second time."""


@dataclass(frozen=True)
class ClaimCheck:
    """A claim about figures of a run, such as "rooms.pq >= 0.5", which has to hold in a share of the scenarios.

    Raises `SimError` unless the share is above 0 and below 1: no number of scenarios shows that a claim always holds.
    """

    claim: Claim
    rate: float

    def __post_init__(self) -> None:
        check_between(f"claim {self.claim}: rate", self.rate, 0.0, 1.0, 0.99)

    @property
    def name(self) -> str:
        """The claim as text."""
        return str(self.claim)

    @property
    def says(self) -> str:
        """The claim and the share of the scenarios in which it has to hold."""
        return f"{self.claim} in {percent(self.rate)} of the scenarios"

    def examine(self, base: EvaluatedRun, new_slam: NewSlam) -> CheckFinding:
        """Compare the figure of the unchanged run with the limit; if it fails, also tell mistakes that may explain it."""
        outcome, measured = self.claim.outcome(base.result), self.claim.described(base.result)
        if outcome == "fails":
            return CheckFinding(False, "; ".join([measured, *usual_mistakes(base.run)]))
        if outcome == "unknown":
            lacks = any(_withholds(base.run.estimate, figure) for figure in self.claim.figures)
            return CheckFinding(None, measured, is_withheld=lacks)
        return CheckFinding(True, measured)


@dataclass(frozen=True)
class SameEstimates:
    """A law about the input: after a change that should hardly matter, the SLAM estimates nearly the same.

    The estimated quantities are the frames that the SLAM used, their poses, labels, rooms and floors, and the loop closures.
    """

    name: str
    says: str
    change: StreamChange
    least: float = 1.0
    """Least agreement of each quantity in `compares`, in [0, 1]; see `EstimateAgreement`."""
    position_m: float = 1e-4
    """Largest allowed distance between the positions that the two runs report for the same frame [m]."""
    rotation_rad: float = 1e-4
    """Largest allowed angle between the orientations that the two runs report for the same frame [rad]."""
    rate: float | None = None
    compares: tuple[str, ...] = _SHARES
    """The quantities that have to agree besides the poses, by their names in `EstimateAgreement`."""
    compares_poses: bool = True
    """Whether the poses have to agree."""
    needs: tuple[Literal["labels", "loops"], ...] = ()
    """Quantities that the SLAM has to estimate, otherwise the law says nothing. "loops": it has to close at least one."""
    needs_poses: bool = False
    """Whether the law is only for runs whose poses agree, so that it is about the other quantities alone."""

    def examine(self, base: EvaluatedRun, new_slam: NewSlam) -> CheckFinding:
        """Run the SLAM on the changed input, and compare the estimates of both runs."""
        if lacking := [name for name in self.needs if not _has_any(base.run.estimate, name)]:
            return CheckFinding(None, f"the SLAM estimates no {' and no '.join(lacking)}")
        second = run_on_change(self.change, base.run, new_slam)
        if isinstance(second, CheckFinding):
            return second
        lost = [name for name in _QUANTITIES if _has(base.run.estimate, name) != _has(second.estimate, name)]
        if lost:
            return CheckFinding(False, f"only one of the two runs estimates {', '.join(lost)}")
        found = agreement(base.run.estimate, second.estimate)
        if found.frames == 0.0:
            return CheckFinding(False, "the estimates of the two runs cover different frames")
        compared = (*self.compares, "position_m") if self.compares_poses else self.compares
        if all(getattr(found, name) is None for name in compared):
            return CheckFinding(None, "the SLAM estimates nothing that the law compares")
        poses_agree = self._poses_agree(found)
        if self.needs_poses and not poses_agree:
            return CheckFinding(None, f"the law is about runs whose poses agree; {_written(found)}")
        shares = (getattr(found, name) for name in self.compares)
        agree = all(share is None or share >= self.least - 1e-9 for share in shares)
        return CheckFinding(poses_agree and agree, _written(found))

    def _poses_agree(self, found: EstimateAgreement) -> bool:
        if not self.compares_poses:
            return True
        near = found.position_m is None or found.position_m <= self.position_m
        return near and (found.rotation_rad is None or found.rotation_rad <= self.rotation_rad)


@dataclass(frozen=True)
class NotWorse:
    """A law about the scenario: after a change that should do no harm, figures are hardly worse than before the change."""

    name: str
    says: str
    change: Callable[[Scenario], Scenario]
    """A function that returns the changed scenario. Raises `SimError` or `WorldsError` where the change is impossible."""
    tolerances: tuple[tuple[str, float], ...]
    """Pairs of a figure, of which larger values are better, and the amount by which it may be smaller after the change."""
    rate: float | None = 0.7

    def examine(self, base: EvaluatedRun, new_slam: NewSlam) -> CheckFinding:
        """Run the SLAM on the changed scenario, and compare the figures. Larger figures are better."""
        try:
            scenario = self.change(base.run.scenario)
            walk(scenario)
        except (WorldsError, SimError) as error:
            return CheckFinding(None, one_line(f"the change is impossible: {error}", 160))
        if scenario == base.run.scenario:
            return CheckFinding(None, "the change changes nothing in this scenario")
        second = attempted(scenario, new_slam)
        if isinstance(second, CheckFinding):
            return second
        figures = evaluate(second)
        pairs = {name: (base.result[name], figures[name]) for name, _ in self.tolerances if base.result[name] is not None}
        if lost := [name for name, (_, after) in pairs.items() if after is None]:
            return CheckFinding(False, f"only the unchanged run has {', '.join(lost)}")
        if not pairs:
            return CheckFinding(None, "the run has none of the figures")
        allowed = dict(self.tolerances)
        holds = all(before - after <= allowed[name] for name, (before, after) in pairs.items())
        return CheckFinding(holds, ", ".join(f"{name} {a:.3g} -> {b:.3g}" for name, (a, b) in pairs.items()))


@dataclass(frozen=True)
class AfterChange:
    """A law about the run on a changed input alone, in which the estimate of the SLAM must not contradict itself."""

    name: str
    says: str
    change: StreamChange
    find: Callable[[Run], CheckFinding]
    """A function that examines the run on the changed input."""
    rate: float | None = None

    def examine(self, base: EvaluatedRun, new_slam: NewSlam) -> CheckFinding:
        """Run the SLAM on the changed input, and examine this run."""
        second = run_on_change(self.change, base.run, new_slam)
        return second if isinstance(second, CheckFinding) else self.find(second)


def run_on_change(change: StreamChange, base: Run, new_slam: NewSlam) -> Run | CheckFinding:
    """Run the SLAM once more on the scenario of a run, with a changed input.

    Returns a finding that says nothing if the change does not reach the SLAM. Programs are never reached, because they read
    recordings. Returns a finding that fails like `attempted`.
    """
    if isinstance(base.slam, CommandSlam) or not change.matters(base.scenario, base.slam):
        return CheckFinding(None, "the change does not reach this SLAM")
    return attempted(base.scenario, new_slam, change)


def attempted(scenario: Scenario, new_slam: NewSlam, change: StreamChange | None = None) -> Run | CheckFinding:
    """Run a SLAM; return a finding that fails if the SLAM raised an exception or returned an estimate that is not valid.

    With a `change`, the SLAM gets the changed input. Raises `SimError` if the scenario is impossible, if the machine cannot
    run it, or if a `change` is given for a program.
    """

    def runner(same: Scenario, progress: Progress | None) -> Run:
        if isinstance(new_slam, Program):
            if change is not None:
                raise SimError("program: it reads whole recordings, which cannot be changed; valid: a SLAM in Python")
            return new_slam(same, progress)
        slam = made_slam(new_slam)
        return run(same, slam if change is None else changed(slam, change), progress)

    try:
        finished = attempt(runner, scenario)
    except EstimateError as error:
        return CheckFinding(False, one_line(str(error), 160))
    if not isinstance(finished, Crash):
        return finished
    return CheckFinding(False, _described(finished), is_crash=True)


def evaluated_run(scenario: Scenario, new_slam: NewSlam) -> EvaluatedRun | CheckFinding:
    """Run a SLAM on an unchanged scenario, like `attempted`. If the SLAM sees images, a robot also drives its plans."""
    finished = attempted(scenario, new_slam)
    if isinstance(finished, CheckFinding):
        return finished
    try:
        trials = attempt_plans(finished) if scenario.fidelity == "render" else ()
    except EstimateError as error:
        return CheckFinding(False, one_line(str(error), 160))
    if isinstance(trials, Crash):
        return CheckFinding(False, f"plan() of {_described(trials)}", is_crash=True)
    return EvaluatedRun(finished, evaluate(finished, trials), trials)


def _described(crash: Crash) -> str:
    """Return in one line what the SLAM did and where."""
    text = f"the SLAM {crash.what}" if isinstance(crash.error, ProgramError) else one_line(crash.sentence, 160)
    expects_images = crash.scenario.fidelity == "features" and Percept.__name__ in crash.sentence
    hint = " (observations hold percepts here; --images or Suite.with_images() renders images)" if expects_images else ""
    return f"{text}{hint}{crash.place}"


def _withholds(estimate: Estimate, figure: str) -> bool:
    """Return whether a SLAM does not estimate what a figure needs, or estimates too few frames for it."""
    group = group_of(figure)
    field = "baseline_labels" if figure == "labels.accuracy_baseline" else _NEEDED_BY.get(group)
    if field is None:
        return False
    return not _has(estimate, field) or (group == "trajectory" and len(estimate.frames) < LEAST_POSES)


def _has(estimate: Estimate, name: str) -> bool:
    return getattr(estimate, name) is not None


def _has_any(estimate: Estimate, name: str) -> bool:
    """Return whether an estimate has a quantity; for loop closures, whether it has at least one."""
    estimated = getattr(estimate, name)
    return estimated is not None and (not isinstance(estimated, EstimatedLoops) or len(estimated.query) > 0)


def _written(found: EstimateAgreement) -> str:
    """Return an agreement in one line: how much of each quantity agrees, and how far the poses differ."""
    shares = {name: getattr(found, name) for name in _SHARES}
    text = ", ".join(f"{share:.1%} of the {name}" for name, share in shares.items() if share is not None)
    apart = "" if found.position_m is None else f"; poses differ by up to {found.position_m:.2g} m"
    turned = "" if found.rotation_rad is None else f" and {found.rotation_rad:.2g} rad"
    return f"the run on the changed input agrees on {text}{apart}{turned}"
