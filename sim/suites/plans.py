"""The law that the plans of a SLAM can be walked. Geometry decides, so that no robot has to drive the plans."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Int

from lexis.errors import one_line
from sim.errors import USER_ERRORS, EstimateError
from sim.harness.finished_run import Run
from sim.harness.planning import ask_plan, planned_pairs
from sim.harness.slam_under_test import PlansPaths
from sim.suites.checks import CheckFinding
from sim.wording import error_text

_MOST_PLANS = 12
"""Largest number of plans that are asked for in one run."""
_THIN_M = 0.02
"""Radius of the body for which each step of a plan has to be free [m]. It is small, because the robot itself avoids
obstacles that are near its path."""
_LEVEL_M = 0.05
"""Largest difference in height between the ends of a step that is judged [m]. Steps with a larger difference lead over
stairs."""
_RIGHT_ENDS = 0.5
"""Least share of the plans that begin in a room of the wanted label, and of those that end in one. It is below 1, because a
plan may go beyond the frames of a room."""


def plans_can_be_walked(run: Run) -> CheckFinding:
    """Ask the SLAM for plans between its labels; look for steps through walls or furniture, and for wrong ends.

    Whether an end has the wanted label is judged by the SLAM's own labels, and whether a step is blocked by the true walls.
    """
    pairs, labels, slam = _spread(planned_pairs(run)), run.estimate.labels, run.slam
    if not pairs or labels is None or not isinstance(slam, PlansPaths):
        return CheckFinding(None, "the SLAM estimates no rooms of two labels, or makes no plans")
    blocked, begins, ends = 0, 0, 0
    for start, goal in pairs:
        try:
            plan = ask_plan(run, slam, start, goal)
        except EstimateError as error:
            return CheckFinding(False, one_line(str(error), 160))
        except USER_ERRORS as error:
            said = one_line(f"plan() of the SLAM raises {error_text(error)}", 160)
            return CheckFinding(False, said, is_crash=True)
        if plan is None:
            return CheckFinding(False, f"there is no plan from {start} to {goal}")
        blocked += _blocked_steps(run, plan)
        begins += int(labels[plan[0]] == run.room_names.index(start))
        ends += int(labels[plan[-1]] == run.room_names.index(goal))
    right = f"{begins / len(pairs):.0%} begin and {ends / len(pairs):.0%} end in a room of the wanted label"
    text = f"of {len(pairs)} plans, {right}; {blocked} steps are blocked"
    return CheckFinding(bool(blocked == 0 and min(begins, ends) >= _RIGHT_ENDS * len(pairs)), text)


def _spread(pairs: Sequence[tuple[str, str]]) -> list[tuple[str, str]]:
    """Return at most `_MOST_PLANS` of the pairs, evenly spread, so that plans begin in all labels."""
    chosen = np.linspace(0, len(pairs) - 1, min(len(pairs), _MOST_PLANS)).round().astype(int)
    return [pairs[i] for i in chosen]


def _blocked_steps(run: Run, plan: Int[np.ndarray, "k"]) -> int:
    """Return the number of level steps of a plan that are blocked between the true positions of the plan's frames.

    Steps between successive frames of the estimate are not judged: there the robot walked, though perhaps not straight.
    """
    places = run.true_poses[plan][:, :3, 3] - [0.0, 0.0, run.session.tour.eye_height_m]
    judged = (np.abs(np.diff(places[:, 2])) <= _LEVEL_M) & (np.abs(np.diff(plan)) > 1)
    return int((~run.walkable.barriers.clear(places[:-1][judged], places[1:][judged], _THIN_M)).sum())
