"""Where in a run a SLAM first went wrong: the room and the time."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from lexis.evaluation.trajectory import aligned
from lexis.types import Poses
from sim.harness.runner import Run
from sim.harness.scenario import Scenario
from sim.harness.walk import walk
from worlds.truth import NOWHERE, room_at


@dataclass(frozen=True)
class WrongPlace:
    """A frame at which something is wrong."""

    room: str
    """Id of the room that holds the camera."""
    time_s: float
    """Time since the start of the tour [s]."""
    what: str
    """What is wrong there."""

    def __str__(self) -> str:
        return f"in {self.room} at {self.time_s:.1f} s: {self.what}"


def first_wrong(run: Run) -> WrongPlace | None:
    """The first frame with a wrong label; if no label is wrong, the frame with the largest pose error.

    None if the SLAM claims neither labels nor poses.
    """
    claims, names = run.estimate, run.room_names
    if claims.labels is not None and (wrong := np.flatnonzero(claims.labels != run.true_labels)).size:
        row = int(wrong[0])
        return _at(run, row, f"labelled {names[claims.labels[row]]}, is {names[run.true_labels[row]]}")
    if claims.T_W_B is None:
        return None
    errors_m = position_errors(claims.T_W_B, run.true_poses)
    row = int(np.argmax(errors_m))
    return _at(run, row, f"no label is wrong, the largest position error is {errors_m[row]:.2f} m")


def raised_at(scenario: Scenario, done: float) -> WrongPlace:
    """The frame at which a SLAM raised an exception, after it had taken the share `done` in [0, 1] of the frames."""
    walked = walk(scenario)
    stamps = walked.tour.stamps
    frame = min(round(done * len(stamps)), len(stamps) - 1)
    room = int(room_at(walked.house, walked.tour.T_W_B[frame : frame + 1, :3, 3])[0])
    what = "the SLAM raised in process()" if done < 1.0 else "the SLAM raised after the last frame"
    return WrongPlace("no room" if room == NOWHERE else walked.house.rooms[room].id, float(stamps[frame] - stamps[0]), what)


def _at(run: Run, row: int, what: str) -> WrongPlace:
    stamps, frame = run.session.tour.stamps, int(run.estimate.frames[row])
    return WrongPlace(run.house.rooms[int(run.true_rooms[row])].id, float(stamps[frame] - stamps[0]), what)


def position_errors(claimed: Poses, truth: Poses) -> Float64[np.ndarray, "n"]:
    """Distance of every claimed position from the true one [m], aligned as for the ATE."""
    return np.asarray(np.linalg.norm((aligned(claimed, truth) - truth)[:, :3, 3], axis=1))
