"""The files of a program's estimate: `trajectory.tum`, and optionally `rooms.json` and `loops.json`."""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from jaxtyping import Float64, Int
from pydantic import BaseModel, ConfigDict, Field

from lexis.files.reading import FileKind, read_bytes, read_model
from lexis.files.tum_trajectory import read_tum
from lexis.types import Pose
from sim.errors import SimError
from sim.harness.estimate import Estimate
from sim.programs.loop_file import LOOPS, read_loops
from worlds.valid_names import did_you_mean, listed

TRAJECTORY = "trajectory.tum"
"""File with the poses of the body. Each line is "stamp tx ty tz qx qy qz qw" in seconds and metres, with a stamp of the
recording."""
ROOMS = "rooms.json"
"""File with labels, room instances and floors; see `RoomFile`."""
AT_REST = -1
"""Value in place of `Observation.index` for frames before the walk, while the body is at rest."""
_KEPT_FILE = FileKind("a file of estimates", 20_000_000, SimError)
"""A file of estimates that is kept although it is not valid: it has at most 20 MB."""
_ROOMS_FILE = FileKind("rooms.json as in sim/pages/your-slam.md", 100_000_000, SimError)


class FrameEntry(BaseModel):
    """What a program estimates for one frame."""

    model_config = ConfigDict(extra="forbid", strict=True, allow_inf_nan=False)

    stamp: float
    """Time stamp of the frame in the recording [s]."""
    label: str | None = None
    """Name of the room, one of the `labels` in the recording's rooms.json."""
    room: Annotated[int, Field(ge=-1, lt=2**31)] | None = None
    """Number of the room instance; -1 for a frame in no room."""
    floor: Annotated[int, Field(ge=-1, lt=2**31)] | None = None
    """Floor number: 0 for the lowest floor, -1 for a frame on stairs."""


class RoomFile(BaseModel):
    """The content of a program's rooms.json. Labels, rooms and floors each have to be given for all frames or for none."""

    model_config = ConfigDict(extra="forbid", strict=True)

    version: Literal[1]
    frames: Annotated[list[FrameEntry], Field(min_length=1)]


@dataclass(frozen=True, eq=False)
class RecordedTimes:
    """The stamps of a recording. They relate each output of a SLAM program, such as a pose, to its observation."""

    stamps: Float64[np.ndarray, "n"]
    """Stamps of all frames as they were recorded [s]."""
    indices: Int[np.ndarray, "n"]
    """`Observation.index` of every frame; `AT_REST` before the walk."""
    period_s: float
    """Time between frames [s]."""

    def nearest(self, stamps: Float64[np.ndarray, "k"]) -> tuple[Int[np.ndarray, "k"], Float64[np.ndarray, "k"]]:
        """Return the entry of `indices` for the frame nearest in time to each stamp, and the time between the two [s]."""
        order = np.argsort(self.stamps, kind="stable")
        ordered = self.stamps[order]
        right = np.searchsorted(ordered, stamps).clip(1, len(ordered) - 1)
        near = np.where(stamps - ordered[right - 1] <= ordered[right] - stamps, right - 1, right)
        return self.indices[order[near]], np.abs(ordered[near] - stamps)

    def span(self) -> str:
        """Return the first and the last stamp as text for messages."""
        return f"{self.stamps.min():.6f} to {self.stamps.max():.6f} s"


def read_estimate(folder: Path, times: RecordedTimes, room_names: Sequence[str]) -> Estimate:
    """Read the estimate that a program has written to a folder.

    The estimate has one row for each stamp of rooms.json or, without this file, of the trajectory. Each row belongs to the
    recorded observation that is nearest in time.

    Raises `SimError` or `LexisError` if a file is not valid, a stamp is near no observation, or a label is unknown.
    """
    poses = _poses(folder / TRAJECTORY, times)
    entries = _entries(folder / ROOMS, times, poses) if (folder / ROOMS).exists() else None
    frames = sorted(poses if entries is None else entries)
    columns = {} if entries is None else _columns([entries[frame] for frame in frames], room_names)
    if (folder / LOOPS).exists():
        columns |= read_loops(folder / LOOPS, lambda stamps: _rows(np.array(stamps, float), times, frames))
    return Estimate(np.array(frames), T_W_B=np.array([poses[frame] for frame in frames]), **columns)


def estimate_files(folder: Path) -> dict[str, bytes]:
    """Return the content of the files that a program has written to a folder, by their names.

    Only the files of the estimate are returned, and of these only regular files of at most 20 MB.
    """
    contents = {}
    for name in (TRAJECTORY, ROOMS, LOOPS):
        with suppress(SimError):
            contents[name] = read_bytes(folder / name, _KEPT_FILE)
    return contents


def _rows(stamps: Float64[np.ndarray, "k"], times: RecordedTimes, frames: Sequence[int]) -> Int[np.ndarray, "k"]:
    """Return the rows of the estimate for stamps in loops.json; -1 for stamps before the walk, when the body is at rest.

    Raises `SimError` for a stamp that belongs to none of the `frames` of the estimate.
    """
    if not len(stamps):
        return np.zeros(0, int)
    found, away_s = times.nearest(stamps)
    rows = np.searchsorted(frames, found).clip(max=len(frames) - 1)
    rest = found == AT_REST
    unknown = (~rest & (np.array(frames)[rows] != found)) | (away_s > times.period_s / 2)
    if unknown.any():
        stamp = stamps[np.argmax(unknown)]
        raise SimError(
            f"{LOOPS}: stamp {stamp:.6f} is none of the estimated frames; valid: frames of {ROOMS}, or of {TRAJECTORY}"
        )
    return np.where(rest, -1, rows)


def _poses(path: Path, times: RecordedTimes) -> dict[int, Pose]:
    """Return the estimated pose of each frame, by the index of the frame.

    It is the estimated pose that is nearest in time, and at most half a frame period away.
    """
    if not path.exists():
        raise SimError(f"command: the program wrote no {{out}}/{TRAJECTORY}; valid: poses at stamps of frames")
    stamps, poses = read_tum(path)
    half = times.period_s / 2
    outside = (stamps < times.stamps.min() - half) | (stamps > times.stamps.max() + half)
    if outside.any():
        hint = _other_clock(stamps, times)
        raise SimError(f"{TRAJECTORY}: stamp {stamps[outside][0]:.6f} matches no frame{hint}; valid: {times.span()}")
    frames, away_s = times.nearest(stamps)
    found: dict[int, Pose] = {}
    for k in np.argsort(-away_s, kind="stable").tolist():
        if frames[k] != AT_REST and away_s[k] <= half:
            found[int(frames[k])] = poses[k]
    if not found:
        raise SimError(f"{TRAJECTORY}: no stamp is within {half:g} s of a frame of the walk; valid: stamps of frames")
    return found


def _other_clock(stamps: Float64[np.ndarray, "n"], times: RecordedTimes) -> str:
    """Return a question about the clock of the stamps, such as " (in nanoseconds?)", if another clock fits; else ""."""
    first, last = times.stamps.min() - times.period_s, times.stamps.max() + times.period_s
    for clock, seconds in {
        "in nanoseconds": 1e-9 * stamps,
        "counted from the first frame": stamps + times.stamps[0],
    }.items():
        if first <= seconds.min() and seconds.max() <= last:
            return f" ({clock}?)"
    return ""


def _entries(path: Path, times: RecordedTimes, poses: dict[int, Pose]) -> dict[int, FrameEntry]:
    """Return the entries of rooms.json, by the index of the frame. Entries from before the walk are left out.

    Raises `SimError` if a stamp matches no frame, or if a frame has two entries or no pose.
    """
    listed_frames = read_model(path, _ROOMS_FILE, RoomFile).frames
    frames, away_s = times.nearest(np.array([entry.stamp for entry in listed_frames], float))
    entries: dict[int, FrameEntry] = {}
    for entry, frame, away in zip(listed_frames, frames.tolist(), away_s.tolist(), strict=True):
        if away > times.period_s / 2:
            raise SimError(f"{ROOMS}: stamp {entry.stamp:.6f} matches no frame; valid: {times.span()}")
        if frame in entries:
            raise SimError(f"{ROOMS}: stamp {entry.stamp:.6f} belongs to a frame with another entry; valid: one for each")
        if frame == AT_REST:
            continue
        if frame not in poses:
            raise SimError(f"{ROOMS}: stamp {entry.stamp:.6f} has no pose; valid: frames that {TRAJECTORY} holds")
        entries[frame] = entry
    if not entries:
        raise SimError(f"{ROOMS}: every stamp is before the walk, when the body is at rest; valid: also frames of the walk")
    return entries


def _columns(entries: Sequence[FrameEntry], room_names: Sequence[str]) -> dict[str, Any]:
    """Convert what is listed about frames to fields of `Estimate`. Raises `SimError` if only some frames have a field."""
    columns = {}
    for name, field in (("label", "labels"), ("room", "rooms"), ("floor", "floors")):
        values = [getattr(entry, name) for entry in entries]
        missing = values.count(None)
        if 0 < missing < len(values):
            stamp = entries[values.index(None)].stamp
            raise SimError(f"{ROOMS}: the frame at {stamp:.6f} s has no {name}, others have; valid: all frames or none")
        if not missing:
            columns[field] = np.array([_number(value, room_names) for value in values], int)
    return columns


def _number(value: int | str, room_names: Sequence[str]) -> int:
    if isinstance(value, int):
        return value
    if value not in room_names:
        guess = did_you_mean(value, room_names)
        raise SimError(f"{ROOMS}: unknown label {value!r:.60}{guess}; valid: {listed(room_names)}")
    return room_names.index(value)
