"""Tests the plans of a SLAM: a simulated robot drives from each estimated room label to every other one."""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import permutations
from typing import Literal

import numpy as np
import shapely
from jaxtyping import Float64, Int

from lexis.errors import PlanError
from lexis.maths.se3 import inverse
from lexis.maths.ties import rounded
from lexis.types import Pose
from sim.errors import EstimateError, SimError
from sim.harness.finished_run import Run
from sim.harness.last_run import last_run
from sim.harness.run_settings import odometry_config
from sim.harness.slam_under_test import PlansPaths
from sim.harness.trial import Trial
from sim.harness.upright import upright
from sim.odometry.config import OdometryConfig
from sim.random_streams import RandomStream, random_generator
from sim.robot import DeadReckoning, Robot
from worlds.labels import STAIRS
from worlds.walkable import UnreachableError, Walkable, polyline_length

Steering = Literal["estimate", "odometry", "truth"]
"""Source of the robot's waypoints and pose. estimate: the waypoints are poses of the SLAM, and the robot's pose comes from
odometry, corrected by the SLAM's last pose. odometry: both come from odometry alone. truth: both are true."""

INSIDE_M = 0.5
"""Distance from the goal room's outline at which the shortest path into the room ends [m]. The figure SPL compares driven
paths with this path."""
_NOWHERE = np.zeros((0, 3))
"""A path without points."""


@dataclass(frozen=True, eq=False)
class _Belief:
    """The robot's estimate of the map and of its own pose."""

    keyframes: Float64[np.ndarray, "n 4 4"]
    """Poses of the map's keyframes, in the frame of the map."""
    T_believed_true: Pose
    """Transform from true poses in W to the poses that the robot believes, as of the last keyframe."""
    drift: OdometryConfig

    @staticmethod
    def of(run: Run, steering: Steering) -> "_Belief":
        truth = run.true_poses
        if steering == "truth":
            return _Belief(truth, np.eye(4), OdometryConfig())
        estimated = run.estimate.T_W_B
        keyframes = run.odometry_poses if steering == "odometry" or estimated is None else upright(run, estimated)
        # The correction T_W_B[-1] @ inverse(T_O_B[-1]) turns the last odometry pose T_O_B[-1] into the estimated T_W_B[-1].
        return _Belief(keyframes, keyframes[-1] @ inverse(truth[-1]), odometry_config(run.scenario))


def try_plans(run: Run, steering: Steering = "estimate", blind: bool = False) -> list[Trial]:
    """Ask the SLAM for a plan from each label of its rooms to every other label, and let a robot drive each plan.

    Stairs are neither start nor goal. The robot starts at the first frame of the plan. Its odometry has the error that it
    had at the end of the run, and drifts on from there. If `blind`, the robot uses no range scan to avoid obstacles. There
    are no trials if no room of the SLAM has a label, or if the SLAM cannot plan paths. A plan that cannot be driven fails:
    its first frame is in a room that has the start's label neither by the SLAM nor in truth, the robot cannot stand there,
    or no way leads from there into a room of the goal's label.

    Raises `EstimateError` for a plan that does not consist of rows of the estimate.
    """
    if not isinstance(run.slam, PlansPaths):
        return []
    return list(_trials(run, run.slam, planned_pairs(run), Robot(run.house, blind), _Belief.of(run, steering)))


def planned_pairs(run: Run) -> list[tuple[str, str]]:
    """Return all pairs of labels (start, goal) between which plans are asked for.

    The labels are those of the SLAM's rooms, except stairs, sorted. There are no pairs if none of the
    SLAM's rooms has a label.
    """
    rooms = run.estimate.named_rooms(run.room_names) or {}
    return list(permutations(sorted(set(rooms.values()) - {STAIRS}), 2))


def ask_plan(run: Run, slam: PlansPaths, start: str, goal: str) -> Int[np.ndarray, "k"] | None:
    """Ask the SLAM for a plan; return the rows of the estimate in driving order, or None if the SLAM finds no plan.

    Raises `EstimateError` unless the plan has one or more rows of the estimate. Other exceptions of the SLAM are passed on.
    """
    try:
        with last_run().calling_slam(PlanError):
            plan = slam.plan(start, goal)
    except PlanError:
        return None
    n = len(run.estimate.frames)
    try:
        rows = np.array(plan)
    except (TypeError, ValueError):  # such as a list of lists of different lengths
        rows = np.zeros(0)
    if rows.ndim != 1 or not rows.size or rows.dtype.kind not in "iu" or not 0 <= rows.min() <= rows.max() < n:
        valid = f"one or more rows of the estimate, 0 to {n - 1}; without a plan, raise PlanError"
        raise EstimateError(f"the plan from {start} to {goal} is {plan!r:.60}; valid: {valid}")
    return rows


def _trials(run: Run, slam: PlansPaths, pairs: list[tuple[str, str]], robot: Robot, belief: _Belief) -> Iterator[Trial]:
    for query, (start, goal) in enumerate(pairs):
        rng = random_generator(run.scenario.seed, RandomStream.DRIVES, query)
        if (keyframes := ask_plan(run, slam, start, goal)) is None:
            yield _failed(start, goal, "no plan was found")
            continue
        yield _try(run, robot, belief, start, goal, keyframes, rng)


def _failed(start: str, goal: str, refusal: str, planned: Float64[np.ndarray, "j 3"] = _NOWHERE) -> Trial:
    """Return the result of a plan that was not driven, for the reason `refusal`."""
    return Trial(start, goal, False, 0.0, 0.0, (), None, _NOWHERE, planned, refusal)


def _try(
    run: Run, robot: Robot, belief: _Belief, start: str, goal: str, keyframes: Int[np.ndarray, "k"], rng: np.random.Generator
) -> Trial:
    planned = run.true_poses[keyframes][:, :3, 3] - [0.0, 0.0, run.session.tour.eye_height_m]
    true, estimated = _labels_of(run, int(keyframes[0]))
    if start not in (true, estimated):
        named = "without a label" if estimated is None else f"labelled {estimated}"
        refusal = f"the plan was not driven: it begins in a {true} {named}, and not in a {start}"
        return _failed(start, goal, refusal, planned)
    T_W_B = run.true_poses[keyframes[0]]
    pose = DeadReckoning(*_seen_from_above(belief.T_believed_true @ T_W_B), belief.drift, rng)
    try:
        shortest = shortest_into(run.walkable, planned[0], goal)
    except UnreachableError as error:
        return _failed(start, goal, f"the plan was not driven: {error}", planned)
    try:
        driven = robot.drive(planned[0], _seen_from_above(T_W_B)[2], pose, belief.keyframes[keyframes][:, :3, 3])
    except SimError as error:  # such as no ground below the first frame, in a moving lift
        return _failed(start, goal, f"the plan was not driven: {error}", planned)
    arrived = driven.room is not None and run.house.room_by_id[driven.room].label == goal
    success = arrived and not driven.touched
    return Trial(start, goal, success, shortest, driven.length_m, driven.touched, driven.room, driven.path, planned)


def _labels_of(run: Run, row: int) -> tuple[str, str | None]:
    """Return the true label of a frame's room, and the label that the SLAM gives to the room in which it puts the frame."""
    rooms, named = run.estimate.rooms, run.estimate.named_rooms(run.room_names) or {}
    estimated = None if rooms is None else named.get(int(rooms[row]))
    return run.room_names[run.true_labels[row]], estimated


def _seen_from_above(T: Pose) -> tuple[float, float, float]:
    """Return position and heading of a pose seen from above: (x [m], y [m], yaw [rad])."""
    return float(T[0, 3]), float(T[1, 3]), float(np.arctan2(T[1, 0], T[0, 0]))


def shortest_into(walkable: Walkable, start: Float64[np.ndarray, "3"], label: str) -> float:
    """Return the length of the shortest walkable path from `start` to a point `INSIDE_M` inside a room with the label [m].

    If no such point can be reached in any room with the label, as in a cupboard, the innermost reachable points count
    instead. Raises `worlds.walkable.UnreachableError` where the start is not walkable or no room with the label can be
    reached.
    """
    distances, depths = walkable.distances_from(start), _depths(walkable, label)
    depths[~np.isfinite(distances)] = 0.0
    deepest = float(depths.max(initial=0.0))
    if deepest == 0.0:
        raise UnreachableError(f"no way into any {label}; valid: a label of a room that can be reached from the start")
    inside = np.flatnonzero(depths >= min(INSIDE_M, deepest))
    nearest = inside[np.argmin(rounded(distances[inside]))]
    # The path over the grid is up to 8 % longer than its straightened form, so with its length the SPL would be too high.
    return polyline_length(walkable.path(start, nearest))


def _depths(walkable: Walkable, label: str) -> Float64[np.ndarray, "nodes"]:
    """Return the distance of every walkable node in a room with the label from the room's outline [m].

    It is 0 for all other nodes.
    """
    depths = np.zeros(len(walkable.nodes))
    for index, room in enumerate(walkable.house.rooms):
        if room.label == label:
            nodes = np.flatnonzero(walkable.node_room == index)
            depths[nodes] = shapely.distance(shapely.points(walkable.nodes[nodes, :2]), room.polygon.boundary)
    # Whether nodes exactly `INSIDE_M` inside count must not depend on the last bit of their coordinates.
    return rounded(depths)
