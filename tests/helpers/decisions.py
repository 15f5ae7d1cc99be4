"""The decisions of a run as plain data, for comparison between two processes or two machines."""

from itertools import permutations

from lexis.errors import PlanError
from lexis.map.folder import load_map, save_map
from lexis.planning import PathPlanner
from sim.harness import try_plans


def decisions(finished, folder):
    """Labels, rooms, floors, candidates, loop edges, plans and drives of a run, and the poses that they depend on.

    The map is saved to `folder` and loaded again, because the loaded map must give the same plans as the live one.
    """
    live = finished.slam.map
    save_map(live, folder)
    return {
        "keyframes": [keyframe.observation_index for keyframe in live.keyframes],
        "baseline_labels": live.baseline_labels.tolist(),
        "labels": live.labels.tolist(),
        "floors": live.floors.tolist(),
        "rooms": [[room.label, list(room.keyframes), room.floor] for room in live.rooms],
        "candidates": [[query, list(matches)] for query, matches in live.candidates],
        "loops": [[loop.query, loop.match, loop.inliers] for loop in live.loops],
        "trusted": (live.loop_weights > 0.5).tolist(),
        "plans": plans(live),
        "plans_from_file": plans(load_map(folder)),
        "drives": [[trial.start, trial.goal, trial.success, list(trial.touched)] for trial in try_plans(finished)],
        "poses": live.T_W_B.tolist(),
    }


def plans(lexis_map):
    """The keyframes of the plan between every two labels of the map, or the error message where there is no plan."""
    planner, labels = PathPlanner(lexis_map), sorted({room.label for room in lexis_map.rooms})
    return {f"{start} -> {goal}": _plan(planner, start, goal) for start, goal in permutations(labels, 2)}


def _plan(planner, start, goal):
    try:
        return list(planner.plan(start, goal).keyframes)
    except PlanError as error:
        return str(error)
