"""Laws about a single run: a SLAM must not contradict itself or the odometry. All but those about plans need no truth."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64, Int

from lexis.evaluation.loops import REVISIT_S
from lexis.evaluation.relative import separation
from lexis.graph.trusted_loops import is_trusted
from lexis.maths.paths import arc_length
from lexis.maths.se3 import between
from lexis.maths.ties import reaches
from lexis.types import Poses
from sim.harness.estimate import EstimatedLoops
from sim.harness.figures import EvaluatedRun
from sim.harness.finished_run import Run
from sim.harness.upright import upright
from sim.suites.checks import CheckFinding, NewSlam
from sim.suites.staircases import ALONG_M, NEAR_M, staircases_are_rooms, stairs_are_climbed
from sim.wording import counted

_STEP_M, _STEP_RAD = 0.25, 0.1
"""Largest allowed difference between the estimated motion and the odometry's motion from one frame of the estimate to the
next [m, rad]. A SLAM distributes a correction over the loop; corrections of LEXIS reach 0.12 m and 0.03 rad, on odometry
that drifts much."""
_STEP_SHARE, _STEP_RAD_M = 0.05, 0.01
"""Additions to `_STEP_M` and `_STEP_RAD` per metre between successive frames, for SLAMs with sparse frames [m/m, rad/m]."""
_LOOP_M, _LOOP_RAD = 0.5, 0.25
"""Largest difference between a trusted loop closure and the poses that it joins [m, rad]. LEXIS reaches 0.21 m, and 0.17 rad
on images."""
_FITS_M, _FITS_RAD = 0.06, 0.02
"""Largest difference between a loop closure and the poses that it joins, for which the loop certainly fits [m, rad]."""
_FITTING_SHARE, _FITTING_LOOPS = 0.5, 5
"""Least share of the fitting loops that has to be trusted, and least number of fitting loops for a judgement. LEXIS trusts
all fitting loops."""
_REVISITING_SHARE = 0.99
"""Least share of the loop closures, and of the proposed revisits, whose two frames are at least `REVISIT_S` apart. In LEXIS,
all are."""
_FLOOR_M = 1.0
"""Largest difference in height between two frames on one floor [m]. It leaves room for drift; LEXIS reaches 0.4 m."""


@dataclass(frozen=True)
class Consistent:
    """A law about the estimate of one run, which needs no second run."""

    name: str
    says: str
    find: Callable[[Run], CheckFinding]
    """A function that examines a run."""
    rate: float | None = None

    def examine(self, base: EvaluatedRun, new_slam: NewSlam) -> CheckFinding:
        """Examine the unchanged run. A run with faults is not judged, because its odometry may jump."""
        return CheckFinding(None, "the run has faults") if base.run.scenario.faults else self.find(base.run)


def steps_follow_odometry(run: Run) -> CheckFinding:
    """Compare the motion between successive frames of the estimate with the motion of the odometry."""
    poses = run.estimate.T_W_B
    if poses is None or len(poses) < 2:
        return CheckFinding(None, "the SLAM estimates no motion")
    odometry = run.odometry_poses
    steps = between(odometry[:-1], odometry[1:])
    length_m = np.linalg.norm(steps[:, :3, 3], axis=1)
    moved, turned = separation(steps, between(poses[:-1], poses[1:]))
    near = (moved <= _STEP_M + _STEP_SHARE * length_m) & (turned <= _STEP_RAD + _STEP_RAD_M * length_m)
    return CheckFinding(
        bool(near.all()),
        f"one step differs from the odometry's by {moved.max():.2g} m, one by {turned.max():.2g} rad",
    )


def trusted_loops_fit(run: Run) -> CheckFinding:
    """Compare the relative poses of trusted loop closures with the relative poses in the trajectory."""
    if (estimates := _weighted_loops(run)) is None:
        return _NO_WEIGHTS
    poses, loops, weights = estimates
    if not (trusted := is_trusted(weights)).any():
        return CheckFinding(None, "the SLAM trusts no loop closure")
    moved, turned = (errors[trusted] for errors in _loop_errors(loops, poses))
    return CheckFinding(
        bool(moved.max() <= _LOOP_M and turned.max() <= _LOOP_RAD),
        f"of {trusted.sum()} trusted loop closures, one contradicts the trajectory by {moved.max():.2g} m, one by "
        f"{turned.max():.2g} rad",
    )


def loops_join_visits(run: Run) -> CheckFinding:
    """Look for loop closures and proposed revisits within one visit, where the odometry is more accurate than they are."""
    loops, proposed = run.estimate.loops, run.estimate.candidates
    pairs = {
        "loop closures": [] if loops is None else np.stack([loops.query, loops.match], axis=1),
        "proposed revisits": [(query, match) for query, matches in proposed or () for match in matches],
    }
    shares = {what: _of_two_visits(run.stamps[np.array(rows)]) for what, rows in pairs.items() if len(rows)}
    if not shares:
        return CheckFinding(None, "the SLAM estimates no loop closure and proposes no revisit")
    found = " and ".join(f"{share:.1%} of the {what}" for what, share in shares.items())
    return CheckFinding(
        min(shares.values()) >= _REVISITING_SHARE, f"{found} join frames that are at least {REVISIT_S:g} s apart"
    )


def _of_two_visits(stamps: Float64[np.ndarray, "n 2"]) -> float:
    """Return the share of the pairs of stamps [s] that belong to separate visits."""
    return float(reaches(np.abs(stamps[:, 0] - stamps[:, 1]), REVISIT_S).mean())


@dataclass(frozen=True)
class LastLoopsFit:
    """Compares the trusted loop closures at the end of the walk with the trajectory.

    They do not fit if a SLAM optimises its trajectory now and then, and forgets to do so at the end, or stops too early. The
    typical difference between a loop closure and the poses that it joins is the median. An end of the walk with one or two
    trusted loop closures is not judged, because these have no typical difference: of LEXIS's trusted loop closures, each
    seventh differs by more than 0.07 m.
    """

    end_m: float
    """Length of the end of the walk [m]."""
    most_m: float
    """Largest typical difference at the end of the walk [m]."""
    ratio: float
    """Largest ratio of the typical difference at the end of the walk to that of the other trusted loop closures. It counts
    if it allows more than `most_m`, for SLAMs whose loop closures are less accurate."""

    def __call__(self, run: Run) -> CheckFinding:
        """Examine a run."""
        if (estimates := _weighted_loops(run)) is None:
            return _NO_WEIGHTS
        poses, loops, weights = estimates
        path = arc_length(run.odometry_poses[:, :3, 3])
        trusted = is_trusted(weights)
        last = trusted & (path[loops.query] >= path[-1] - self.end_m)
        others = trusted & ~last
        if last.sum() < _FEWEST_LAST_LOOPS or not others.any():
            few = counted(int(last.sum()), "loop closure")
            return CheckFinding(None, f"the SLAM trusts {few} at the end of the walk and {others.sum()} before, too few")
        moved = _loop_errors(loops, poses)[0]
        at_end, before = float(np.median(moved[last])), float(np.median(moved[others]))
        return CheckFinding(
            at_end <= max(self.most_m, self.ratio * before),
            f"trusted loops at the end of the walk contradict the trajectory by {at_end:.2g} m, others by {before:.2g} m",
        )


_FEWEST_LAST_LOOPS = 3
"""Least number of trusted loop closures at the end of the walk for a judgement."""
_LAST_LOOPS = LastLoopsFit(end_m=1.0, most_m=0.07, ratio=2.0)
"""For LEXIS, the typical difference is at most 0.066 m in 98 % of the runs."""


def fitting_loops_are_trusted(run: Run) -> CheckFinding:
    """Look for loop closures that the trajectory satisfies although the SLAM does not trust them."""
    if (estimates := _weighted_loops(run)) is None:
        return _NO_WEIGHTS
    poses, loops, weights = estimates
    moved, turned = _loop_errors(loops, poses)
    fits = (moved <= _FITS_M) & (turned <= _FITS_RAD)
    if fits.sum() < _FITTING_LOOPS:
        return CheckFinding(None, f"the trajectory satisfies {fits.sum()} loop closures, too few to judge")
    trusted = is_trusted(weights[fits]).mean()
    found = f"of {fits.sum()} loop closures that the trajectory satisfies, {trusted:.0%} are trusted"
    return CheckFinding(bool(trusted >= _FITTING_SHARE), found)


_NO_WEIGHTS = CheckFinding(None, "the SLAM does not say which loop closures it trusts")


def _weighted_loops(run: Run) -> tuple[Poses, EstimatedLoops, Float64[np.ndarray, "loops"]] | None:
    """Return the estimated poses, loop closures and their weights; None if one of these is not estimated."""
    poses, loops = run.estimate.T_W_B, run.estimate.loops
    if poses is None or loops is None or loops.weights is None:
        return None
    return poses, loops, np.asarray(loops.weights, float)


def _loop_errors(loops: EstimatedLoops, poses: Poses) -> tuple[Float64[np.ndarray, "loops"], Float64[np.ndarray, "loops"]]:
    """Return the distances [m] and angles [rad] between loop closures and the relative poses in the trajectory."""
    return separation(np.asarray(loops.T_match_query, float), between(poses[loops.match], poses[loops.query]))


def rooms_are_uniform(run: Run) -> CheckFinding:
    """Look for rooms with frames of different labels, or on different floors."""
    rooms, labels, floors = run.estimate.rooms, run.estimate.labels, run.estimate.floors
    if rooms is None or (labels is None and floors is None):
        return CheckFinding(None, "the SLAM estimates no rooms, or neither labels nor floors")
    if not any(((rooms >= 0) & (kinds >= 0)).any() for kinds in (labels, floors) if kinds is not None):
        return CheckFinding(None, "no frame in a room has a label or a floor")
    mixed = [0 if kinds is None else _mixed(rooms, kinds) for kinds in (labels, floors)]
    return CheckFinding(sum(mixed) == 0, f"{mixed[0]} rooms have frames of several labels, {mixed[1]} of several floors")


def floors_are_level(run: Run) -> CheckFinding:
    """Compare the heights of the frames on each floor, and check that floors with higher numbers are higher."""
    poses, floors = run.estimate.T_W_B, run.estimate.floors
    if poses is None or floors is None or not (floors >= 0).any():
        return CheckFinding(None, "the SLAM does not estimate both poses and floors")
    height = upright(run, poses)[:, 2, 3]
    heights = [height[floors == floor] for floor in np.unique(floors[floors >= 0])]
    span = max(float(np.ptp(own)) for own in heights)
    ascend = bool((np.diff([own.mean() for own in heights]) > 0.0).all())
    text = f"heights on one floor differ by {span:.2g} m" + ("" if ascend else "; floors with higher numbers are not higher")
    return CheckFinding(span <= _FLOOR_M and ascend, text)


def _mixed(rooms: Int[np.ndarray, "n"], kinds: Int[np.ndarray, "n"]) -> int:
    """Return the number of rooms with frames of several kinds, such as labels.

    Frames without a room or a kind (-1) do not count.
    """
    pairs = np.unique(np.stack([rooms, kinds], axis=1)[(rooms >= 0) & (kinds >= 0)], axis=0)
    return int((np.unique(pairs[:, 0], return_counts=True)[1] > 1).sum())


LEVEL_FLOORS = Consistent(
    "floors are level",
    f"Frames on one floor have heights within {_FLOOR_M} m, and higher floors have higher numbers.",
    floors_are_level,
)
"""The law about the heights of floors. It is too strict for odometry that drifts much, as long as no loop is closed."""
CONSISTENCY = (
    Consistent(
        "steps follow the odometry",
        f"Between successive frames, the trajectory moves as the odometry does, within about {_STEP_M} m and {_STEP_RAD} "
        "rad. A SLAM distributes corrections over the loop.",
        steps_follow_odometry,
    ),
    Consistent(
        "trusted loops fit the trajectory",
        f"The trajectory satisfies every trusted loop closure within {_LOOP_M} m and {_LOOP_RAD} rad.",
        trusted_loops_fit,
    ),
    Consistent(
        "loops join separate visits",
        f"At least {_REVISITING_SHARE:.0%} of the loop closures, and of the proposed revisits, join frames that are "
        f"{REVISIT_S:g} s apart or more. A SLAM that also counts frames of one visit as revisits breaks this law on "
        "purpose.",
        loops_join_visits,
    ),
    Consistent(
        "the last loops fit the trajectory",
        f"The trajectory satisfies the trusted loop closures of the last {_LAST_LOOPS.end_m:g} m of the walk within "
        f"{_LAST_LOOPS.most_m} m, or within {_LAST_LOOPS.ratio} times the difference of the others; these are medians.",
        _LAST_LOOPS,
        rate=0.95,
    ),
    Consistent(
        "fitting loops are trusted",
        f"At least {_FITTING_SHARE:.0%} of the loop closures that the trajectory satisfies within {_FITS_M} m and "
        f"{_FITS_RAD} rad are trusted.",
        fitting_loops_are_trusted,
        rate=0.9,
    ),
    Consistent(
        "rooms are uniform",
        "All frames of a room have one label and one floor; frames on stairs may have no floor.",
        rooms_are_uniform,
    ),
    LEVEL_FLOORS,
    Consistent(
        "labels on stairs",
        "Frames in the middle of a climb are labelled as stairs. Frames whose path is level before and after them, for "
        f"{ALONG_M} m each, are not, except on half landings.",
        stairs_are_climbed,
    ),
    Consistent(
        "a staircase is one room",
        f"Frames on stairs that are within {NEAR_M} m of each other on a plan belong to one room, because stairs are one "
        "room through all storeys that they join.",
        staircases_are_rooms,
    ),
)
"""All laws about a single run."""
