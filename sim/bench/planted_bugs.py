"""Planted bugs: simulated SLAM systems that return the true poses, labels, rooms and floors, except for one kind of mistake.

They test the harness: the reducer has to find the smallest scenario in which a bug shows. Unlike a real SLAM, a planted bug
knows the ground truth. A bug shows only in scenarios with its trigger, such as an open boundary or stairs.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType

import numpy as np
from jaxtyping import Bool, Float64, Int

from lexis.maths.paths import arc_length
from lexis.maths.se3 import between
from lexis.types import Camera, Observation
from sim.harness.crash import Runner
from sim.harness.estimate import Estimate
from sim.harness.finished_run import Run
from sim.harness.last_run import last_run
from sim.harness.runner import Progress, run
from sim.harness.scenario import Scenario
from worlds.truth import boundary_openness, room_graph

Bug = Callable[[Run], Estimate]
"""A function that returns the estimate of a faulty SLAM. Its argument is a finished run, which knows the ground truth; the
run's own estimate contains frames, but nothing about them."""

_OPEN_SHARE = 0.5
_SMALL_M2 = 6.0
_WET = ("bathroom", "toilet")
_CLUTTERED = 5
_LONG_M = 30.0
_JUMP_M = 1.0
_GAP_S = 1.2
_TILT_RAD = 0.01
_OFF_M = 0.005


class _NoEstimates:
    """A SLAM that returns nothing about the frames that it was given."""

    def __init__(self) -> None:
        self._frames: set[int] = set()

    def start(self, camera: Camera, room_names: Sequence[str]) -> None:
        """Begin a run. The camera and the names of rooms are ignored."""

    def process(self, observation: Observation) -> None:
        """Store the index of the frame."""
        self._frames.add(observation.index)

    def finish(self) -> Estimate:
        """Return an estimate that contains the indices of all frames, and nothing about them."""
        return Estimate(np.array(sorted(self._frames), int))


def planted(bug: Bug) -> Runner:
    """Return a function for `FailureTest` that runs a scenario with the planted bug as the SLAM."""

    def runner(scenario: Scenario, progress: Progress | None = None) -> Run:
        finished = run(scenario, _NoEstimates(), progress)
        with last_run().calling_slam():  # the bug counts as the SLAM
            return replace(finished, estimate=bug(finished))

    return runner


def no_bug(run: Run) -> Estimate:
    """Return true poses, labels, rooms and floors."""
    return replace(run.estimate, T_W_B=run.true_poses, labels=run.true_labels, rooms=run.true_rooms, floors=run.true_floors)


def small_errors(run: Run) -> Estimate:
    """Return the truth, but with positions that are 5 mm too high or too low in turn, since no real SLAM is exact."""
    poses = run.true_poses.copy()
    poses[::2, 2, 3] += _OFF_M
    poses[1::2, 2, 3] -= _OFF_M
    return replace(no_bug(run), T_W_B=poses)


def open_plan(run: Run) -> Estimate:
    """Return the truth, but swap the labels of two rooms if more than half of the boundary between them is open."""
    labels, rooms = run.true_labels.copy(), run.true_rooms
    for pair, share in boundary_openness(run.house).items():
        if share > _OPEN_SHARE:
            a, b = map(_indices(run).__getitem__, pair)
            labels[rooms == a], labels[rooms == b] = _label(run, b), _label(run, a)
    return replace(no_bug(run), labels=labels)


def small_rooms(run: Run) -> Estimate:
    """Return the truth, but give every room of less than 6 m² the label of a room from which a passage leads into it."""
    labels, rooms, place = run.true_labels.copy(), run.true_rooms, _indices(run)
    for passage in room_graph(run.house).passages:
        for small, other in (passage.rooms, passage.rooms[::-1]):
            if _area_m2(run, place[small]) < _SMALL_M2:
                labels[rooms == place[small]] = _label(run, place[other])
    return replace(no_bug(run), labels=labels)


def corners(run: Run) -> Estimate:
    """Return the truth, but give every room with more than four corners a wrong label."""
    angular = [len(room.polygon.exterior.coords) > 5 for room in run.house.rooms]  # the list ends with the first corner
    return replace(no_bug(run), labels=_mislabelled(run, np.array(angular)))


def clutter(run: Run) -> Estimate:
    """Return the truth, but give every room with five or more pieces of furniture a wrong label."""
    pieces = [piece.room for piece in run.house.furniture]
    full = [pieces.count(room.id) >= _CLUTTERED for room in run.house.rooms]
    return replace(no_bug(run), labels=_mislabelled(run, np.array(full)))


def floors(run: Run) -> Estimate:
    """Return the truth, but with every frame on the lowest floor."""
    return replace(no_bug(run), floors=np.zeros_like(run.true_floors))


def third_floor(run: Run) -> Estimate:
    """Return the truth, but with every frame above the second floor on the second floor."""
    return replace(no_bug(run), floors=np.minimum(run.true_floors, 1))


def ring(run: Run) -> Estimate:
    """Return the truth, but merge all rooms on loops of connected rooms, and on paths between two loops, into one room."""
    rooms, place = run.true_rooms.copy(), _indices(run)
    beside = {
        room: {o for p in room_graph(run.house).passages if room in p.rooms for o in p.rooms} - {room} for room in place
    }
    while ends := [room for room, others in beside.items() if len(others) < 2]:
        for end in ends:
            for other in beside.pop(end):
                beside[other].discard(end)
    members = [place[room] for room in beside]
    rooms[np.isin(rooms, members)] = min(members, default=-1)
    return replace(no_bug(run), rooms=rooms)


def twins(run: Run) -> Estimate:
    """Return the truth, but merge all rooms of one label into one room."""
    return replace(no_bug(run), rooms=run.true_labels)


def revisits(run: Run) -> Estimate:
    """Return the truth, but start a new room whenever a room is entered again."""
    return replace(no_bug(run), rooms=np.cumsum(np.diff(run.true_rooms, prepend=-1) != 0))


def drift(run: Run) -> Estimate:
    """Return the truth, but with the poses of the odometry."""
    return replace(no_bug(run), T_W_B=run.odometry_poses)


def wrong_side(run: Run) -> Estimate:
    """Return the truth, but add up the steps of the odometry in the frame of the world instead of that of the body."""
    poses = run.odometry_poses.copy()
    for k, step in enumerate(between(poses[:-1], poses[1:])):
        poses[k + 1] = step @ poses[k]
    return replace(no_bug(run), T_W_B=poses)


def kidnap(run: Run) -> Estimate:
    """Return the truth, but miss every step of more than a metre that the odometry does not report."""
    jumps = (_steps_m(run.true_poses) > _JUMP_M) & (_steps_m(run.odometry_poses) < _JUMP_M)
    return replace(no_bug(run), T_W_B=_without_steps(run.true_poses, jumps))


def gaps(run: Run) -> Estimate:
    """Return the truth, but miss the motion wherever no observation arrives for more than 1.2 s."""
    return replace(no_bug(run), T_W_B=_without_steps(run.true_poses, np.diff(run.stamps) > _GAP_S))


def long_walks(run: Run) -> Estimate:
    """Return the truth, but notice no motion after the first 30 m of the path."""
    travelled_m = arc_length(run.true_poses[:, :3, 3])
    return replace(no_bug(run), T_W_B=_without_steps(run.true_poses, travelled_m[1:] > _LONG_M))


def gait(run: Run) -> Estimate:
    """Return the truth, but shift the position by a metre along x for each 0.1 rad that the body rolls."""
    poses = run.true_poses.copy()
    roll_rad = np.arcsin(np.clip(poses[:, 2, 1], -1.0, 1.0))
    poses[:, 0, 3] += np.where(np.abs(roll_rad) > _TILT_RAD, 10.0 * roll_rad, 0.0)
    return replace(no_bug(run), T_W_B=poses)


def wet_rooms(run: Run) -> Estimate:
    """Return the truth, but raise ZeroDivisionError if a frame is in a bathroom or a toilet."""
    if any(run.room_names[label] in _WET for label in run.true_labels):
        raise ZeroDivisionError("the area of a wet room")
    return no_bug(run)


def nan_poses(run: Run) -> Estimate:
    """Return the truth, but raise FloatingPointError if a pose of the odometry is not finite."""
    if not all(np.isfinite(given.T_O_B).all() for given in run.given.values()):
        raise FloatingPointError("the odometry is not finite")
    return no_bug(run)


BUGS: Mapping[str, Bug] = MappingProxyType(
    {
        bug.__name__.replace("_", " "): bug
        for bug in (
            *(no_bug, small_errors),
            *(open_plan, small_rooms, corners, clutter),
            *(floors, third_floor),
            *(ring, twins, revisits),
            *(drift, wrong_side, kidnap, gaps, long_walks, gait),
            *(wet_rooms, nan_poses),
        )
    }
)
"""All planted bugs by name: no bug, bugs of labels, floors, room instances and poses, and bugs that raise an exception."""
MENDED = "small errors"
"""The bug of a SLAM that counts as mended, a key of `BUGS`."""


def _indices(run: Run) -> dict[str, int]:
    """Return the index of every room in `house.rooms`, by the id of the room."""
    return {room.id: k for k, room in enumerate(run.house.rooms)}


def _label(run: Run, room: int) -> int:
    """Return the label of a room, as an index into `room_names`."""
    return run.room_names.index(run.house.rooms[room].label)


def _area_m2(run: Run, room: int) -> float:
    return float(run.house.rooms[room].polygon.area)


def _mislabelled(run: Run, wrong: Bool[np.ndarray, "rooms"]) -> Int[np.ndarray, "n"]:
    """Return the true label of every frame, but for frames in rooms that are `wrong`, the next label in `room_names`."""
    shift = wrong[run.true_rooms] if len(run.room_names) > 1 else np.zeros(len(run.true_rooms), bool)
    return np.asarray((run.true_labels + shift) % len(run.room_names))


def _steps_m(poses: Float64[np.ndarray, "n 4 4"]) -> Float64[np.ndarray, "m"]:
    """Return the distances between the positions of successive poses [m]."""
    return np.asarray(np.linalg.norm(np.diff(poses[:, :3, 3], axis=0), axis=1))


def _without_steps(poses: Float64[np.ndarray, "n 4 4"], missed: Bool[np.ndarray, "m"]) -> Float64[np.ndarray, "n 4 4"]:
    """Return the poses without the motion of the steps that are `missed`, but with all orientations unchanged.

    Step k leads from pose k to pose k + 1.
    """
    lost = np.zeros((len(poses), 3))
    lost[1:] = np.cumsum(np.diff(poses[:, :3, 3], axis=0) * missed[:, None], axis=0)
    moved = poses.copy()
    moved[:, :3, 3] -= lost
    return moved
