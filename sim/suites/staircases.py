"""Laws about stairs: frames on a climb are labelled as stairs, and the frames on one staircase are one room."""

import numpy as np
from jaxtyping import Float64
from scipy.spatial import cKDTree

from lexis.maths.paths import arc_length
from sim.harness.finished_run import Run
from sim.harness.upright import upright
from sim.suites.checks import CheckFinding
from worlds.labels import STAIRS

ALONG_M = 1.25
"""Length of the path before and after a frame that tells whether the frame is on stairs [m]."""
_STEEP = 0.45
"""A frame is certainly on stairs if the path is at least as steep as this before and after the frame [m/m]. The stairs of
houses are steeper."""
_LANDING_M = 3.0
"""Length of the path before and after a frame that tells whether the frame is on a half landing [m]. A frame where the path
is level is on a half landing if the path rises over this length before the frame and again over this length after it, or if
it falls both times."""
_LEVEL_M = 0.2
"""A frame is certainly not on stairs if the heights `ALONG_M` before and after it differ by at most this from its own
height [m]."""
NEAR_M = 1.0
"""Two frames on stairs are certainly on one staircase if their horizontal distance is at most this [m]."""


def stairs_are_climbed(run: Run) -> CheckFinding:
    """Compare the frames that are labelled as stairs with where the odometry climbs."""
    labels = run.estimate.labels
    if labels is None or STAIRS not in run.room_names or len(labels) < 2:
        return CheckFinding(None, "the SLAM estimates no labels, or stairs are no room name")
    labelled = labels == run.room_names.index(STAIRS)
    positions = run.odometry_poses[:, :3, 3]
    path = arc_length(positions)
    rise, further = (_rises(path, positions[:, 2], length_m) for length_m in (ALONG_M, _LANDING_M))
    climbs = (rise.prod(axis=0) > 0) & (np.abs(rise) >= _STEEP * ALONG_M).all(axis=0)
    landing = (further.prod(axis=0) > 0) & (np.abs(further) > _LEVEL_M).all(axis=0)
    level = (np.abs(rise) <= _LEVEL_M).all(axis=0) & ~landing
    missed, wrong = int((climbs & ~labelled).sum()), int((level & labelled).sum())
    return CheckFinding(
        missed == wrong == 0, f"{missed} frames climb and have another label; {wrong} are level and labelled so"
    )


def staircases_are_rooms(run: Run) -> CheckFinding:
    """Look for frames on one staircase that belong to different rooms.

    Stairs of several storeys lie above one another, and a walk upwards and one downwards lead over the same stairs.
    """
    poses, labels, rooms = run.estimate.T_W_B, run.estimate.labels, run.estimate.rooms
    if poses is None or labels is None or rooms is None or STAIRS not in run.room_names:
        return CheckFinding(None, "the SLAM does not estimate poses, labels and rooms, or stairs are no room name")
    on_stairs = np.flatnonzero((labels == run.room_names.index(STAIRS)) & (rooms >= 0))
    if not len(on_stairs):
        return CheckFinding(None, "no frame on stairs belongs to a room")
    first, second = on_stairs[cKDTree(upright(run, poses)[on_stairs, :2, 3]).query_pairs(NEAR_M, output_type="ndarray")].T
    if not len(first):
        return CheckFinding(None, "no two frames on stairs are near each other")
    apart = int((rooms[first] != rooms[second]).sum())
    return CheckFinding(apart == 0, f"{apart} of {len(first)} pairs of near frames on stairs belong to different rooms")


def _rises(path: Float64[np.ndarray, "n"], height: Float64[np.ndarray, "n"], length_m: float) -> Float64[np.ndarray, "2 n"]:
    """Return the change of height over the path of `length_m` before each frame (row 0) and after it (row 1) [m]."""
    before, after = (np.interp(path + offset, path, height) for offset in (-length_m, length_m))
    return np.stack([height - before, after - height])
