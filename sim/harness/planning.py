"""Plans put to the test: from every room that the map names to every other, driven by a simulated robot."""

from dataclasses import dataclass
from itertools import permutations

import numpy as np
from jaxtyping import Float64

from lexis.errors import PlanError
from lexis.planner import plan
from lexis.se3 import inverse
from sim.harness.run import Run
from sim.robot import drive
from worlds.labels import STAIRS
from worlds.walkable import polyline_length


@dataclass(frozen=True, eq=False)
class Trial:
    """One query, and how the robot fared."""

    start: str
    goal: str
    success: bool
    """It stands in a room of the goal's label and has touched nothing."""
    shortest_m: float
    """Shortest walkable way from the start into a room of the goal's label [m]."""
    travelled_m: float
    collisions: int
    path: Float64[np.ndarray, "k 3"]
    """Of the robot, in W [m]."""


def try_plans(run: Run) -> list[Trial]:
    """Ask for a plan between every two room labels of the map, stairs left out, and drive it."""
    labels = sorted({room.label for room in run.map.rooms} - {STAIRS})
    return [_try(run, start, goal) for start, goal in permutations(labels, 2)]


def _try(run: Run, start: str, goal: str) -> Trial:
    try:
        keyframes = np.array(plan(run.map, start, goal, run.config.lexis.planner).keyframes)
    except PlanError:
        return Trial(start, goal, False, 0.0, 0.0, 0, np.zeros((0, 3)))
    # The robot starts where the first keyframe truly is; from there on it believes the map.
    T_W_map = run.true_poses[keyframes[0]] @ inverse(run.map.T_W_B[keyframes[0]])
    waypoints = (T_W_map @ run.map.T_W_B[keyframes])[:, :3, 3] - [0.0, 0.0, run.session.tour.eye_height_m]
    driven = drive(run.house, run.walkable, waypoints)
    arrived = driven.room is not None and run.house.room_by_id[driven.room].label == goal
    shortest = _shortest(run, waypoints[0], goal)
    return Trial(start, goal, arrived and not driven.collisions, shortest, driven.length_m, driven.collisions, driven.path)


def _shortest(run: Run, start: Float64[np.ndarray, "3"], goal: str) -> float:
    walkable, labels = run.walkable, np.array([room.label for room in run.house.rooms])
    inside = np.flatnonzero(labels[walkable.node_room] == goal)
    nearest = inside[np.argmin(walkable.distances_from(start)[inside])]
    # The way over the grid is up to 8 % longer than the one that it shortens to: it would flatter the SPL.
    return polyline_length(walkable.path(start, int(nearest)))
