"""A baseline without language: floors by the height of the odometry's trajectory, rooms as groups of nearby keyframes."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from jaxtyping import Bool, Float64, Int
from scipy.cluster.hierarchy import fcluster, linkage

from lexis.floors import NO_FLOOR
from lexis.types import Camera, Observation
from sim.harness.adapters.odometry_only import OdometryOnly
from sim.harness.estimate import Estimate

ROOM_M = 5.0
"""Largest distance between two keyframes of one room [m]."""
CLIMB_M = 0.25
"""Least difference in height between the keyframe before and the keyframe after a keyframe on stairs [m]. These two
keyframes are 1 m of path apart."""
STOREY_M = 0.6
"""Level stretches of the walk belong to one floor or landing if the difference of their heights is smaller than this [m]."""
LANDING_SHARE = 0.05
"""A group of keyframes at about the same height is a landing of the stairs, not a floor, if it contains less than this share
of all keyframes that are not on steps."""


class GeometricRooms:
    """A baseline that reports the odometry's poses, floors by height and rooms by position, but no labels.

    Poses show no walls or doors, so the rule is simple: on each floor, and on the stairs, keyframes form rooms in which no
    two keyframes are more than `ROOM_M` apart. This rule splits longer rooms, merges small neighbouring rooms, and fails on
    walks so long that the drift of the height hides the storeys.
    """

    def __init__(self) -> None:
        """Create the adapter; a run begins with `start`."""
        self._odometry = OdometryOnly()

    def start(self, camera: Camera, room_names: Sequence[str]) -> None:
        """Begin a run. The camera and the names of rooms are ignored."""
        self._odometry.start(camera, room_names)

    def process(self, observation: Observation) -> None:
        """Take the next odometry pose. Raises `ObservationError` for frames out of order and poses that are not rigid."""
        self._odometry.process(observation)

    def finish(self) -> Estimate:
        """Return the poses, floors and rooms of all keyframes. Raises `SimError` if no observation was usable."""
        poses = self._odometry.finish()
        assert poses.T_W_B is not None  # OdometryOnly returns them
        positions = poses.T_W_B[:, :3, 3]
        floors = floors_by_height(positions[:, 2])
        return replace(poses, rooms=rooms_by_distance(positions, floors), floors=floors)


def floors_by_height(heights: Float64[np.ndarray, "n"]) -> Int[np.ndarray, "n"]:
    """Compute the floor of every keyframe from its height [m]: 0 for the lowest floor, `NO_FLOOR` for steps and landings."""
    floors = np.full(len(heights), NO_FLOOR)
    level = ~_climbs(heights)
    if not level.any():
        return floors
    ordered = np.sort(heights[level])
    groups = np.split(ordered, np.flatnonzero(np.diff(ordered) > STOREY_M) + 1)
    storeys = [group for group in groups if len(group) >= LANDING_SHARE * len(ordered)]
    for floor, group in enumerate(storeys):
        floors[level & (heights >= group[0]) & (heights <= group[-1])] = floor
    return floors


def _climbs(heights: Float64[np.ndarray, "n"]) -> Bool[np.ndarray, "n"]:
    """Return, for every keyframe, whether the heights of its two neighbours differ by at least `CLIMB_M`."""
    padded = np.pad(heights, 1, mode="edge")
    return np.asarray(np.abs(padded[2:] - padded[:-2]) >= CLIMB_M)


def rooms_by_distance(positions: Float64[np.ndarray, "n 3"], floors: Int[np.ndarray, "n"]) -> Int[np.ndarray, "n"]:
    """Compute a room number for every keyframe. Rooms are clusters on one floor, up to `ROOM_M` wide (complete linkage)."""
    rooms = np.zeros(len(floors), int)
    count = 0
    for floor in np.unique(floors):
        members = floors == floor
        if members.sum() > 1:
            rooms[members] = fcluster(linkage(positions[members], "complete"), ROOM_M, "distance") - 1
        rooms[members] += count
        count = int(rooms[members].max()) + 1
    return rooms
