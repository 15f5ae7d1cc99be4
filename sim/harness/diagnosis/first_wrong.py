"""`first_wrong`: the first frame of a run at which the estimate of a SLAM is wrong, with room, time and reason."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from types import MappingProxyType
from typing import Literal, NamedTuple

import numpy as np
from jaxtyping import Bool, Float64, Int

from lexis.evaluation.trajectory import aligned
from lexis.types import Poses
from sim.harness.diagnosis.wrong_motion import first_wrong_motion
from sim.harness.finished_run import Run
from sim.harness.loops import edge_truth
from sim.harness.results import group_of
from sim.report.data import NO_LABEL, ShownFailure
from sim.session import Session

_GRADED = "labels.accuracy_graded"
"""The figure for which near an open boundary between two rooms the labels of both are right."""
_SEEN_M = 0.005
"""Least position error that is reported [m]; a smaller one would be printed as 0.00 m."""
_UPRIGHT = 0.9
"""A position is too high or too low, and not just off, if at least this share of its error is in height."""
_TOP = 3
"""Number of room names that are reported for a wrong frame: those most similar to its image."""


class _Wrong(NamedTuple):
    """A row of the estimate, what is wrong there, and the row at which a wrong motion begins that ends there.

    `in_reference`: see `WrongFrame`.
    """

    row: int
    what: str
    since: int | None = None
    in_reference: bool = False


class Misplaced(NamedTuple):
    """A row of the estimate in no room instance or in a wrong one."""

    row: int
    estimate: int
    """Number of the estimated room; negative for none."""
    how: Literal["nowhere", "merged", "split"]
    other: int
    """If merged, the true room in which most of the estimated room lies. If split, the estimated room that holds most of the
    true room; negative for none. Otherwise, the true room itself."""


@dataclass(frozen=True)
class WrongFrame:
    """A frame at which the SLAM was wrong: the room, the time and the error."""

    frame: int
    """Index of the frame in the tour."""
    room: str
    """Id of the room that truly contains the camera, also with the room's label where the error is about labels."""
    time_s: float
    """Time since the start of the tour [s]."""
    what: str
    """What is wrong: the estimate and the truth, in words."""
    since: int | None = None
    """Index of the frame in the tour at which a wrong motion begins that ends at `frame`; None for other errors."""
    similarities: tuple[tuple[str, float], ...] = ()
    """The room names that the SLAM found most similar to the image, best first; for figures of labels, rooms and plans, and
    for no figure. Empty for other figures."""
    in_reference: bool = False
    """Whether the frame is wrong in the run of the reference, too, as all wrong frames are then."""

    def __str__(self) -> str:
        return f"in {self.room} at {self.time_s:.1f} s: {self.what}"


def first_wrong(run: Run, figure: str | None = None, reference: Run | None = None) -> WrongFrame | None:
    """Return the first frame that is wrong for a figure, such as a frame with a wrong floor for "floors.accuracy".

    With the run of a `reference` on the same scenario, the result is the first frame that is wrong only in `run`, if there
    is one; `WrongFrame.in_reference` tells.

    Without a figure, the result is the first frame with a wrong label or, if no label is wrong, the frame that is wrong for
    the trajectory. The result is None if there is no such frame, or if the SLAM does not estimate what the figure needs. It
    is also None for a figure that describes the run as a whole, such as "coverage.path_covered".
    """
    kind = group_of(figure)
    search = _SEARCHES.get(figure or "", _SEARCHES.get(kind))
    found = _found(search, run, reference) if search is not None else None
    if found is None and figure is None and (found := next(_position(run), None)) is not None:
        found = found._replace(what=f"no label is wrong; {found.what}" if run.estimate.labels is not None else found.what)
    if found is None:
        return None
    row, what, since, in_reference = found
    stamps, frames = run.session.tour.stamps, run.estimate.frames.tolist()
    similar = run.most_similar(row, _TOP) if kind in WITH_LABELS else ()
    begin = None if since is None else frames[since]
    room = _room(run, int(run.true_rooms[row])) if kind in WITH_LABELS else _room_id(run, row)
    return WrongFrame(frames[row], room, float(stamps[frames[row]] - stamps[0]), what, begin, similar, in_reference)


def _found(search: "Callable[[Run], Iterator[_Wrong]]", run: Run, reference: Run | None) -> _Wrong | None:
    """Return the first wrong row whose frame is right in the reference; without such a row, the first wrong row."""
    if reference is not None:
        excused = {int(reference.estimate.frames[found.row]) for found in search(reference)}
        for found in search(run):
            if int(run.estimate.frames[found.row]) not in excused:
                return found
    first = next(search(run), None)
    return first and first._replace(in_reference=reference is not None)


def shown_failure(run: Run, what: str, figure: str | None, reference: Run | None) -> ShownFailure:
    """Return what the report shows of a failed run: `what` has failed, and the first frame that is wrong for the figure."""
    frame = first_wrong(run, figure, reference)
    if frame is None:
        return ShownFailure(what)
    return ShownFailure(what, str(frame), int(np.searchsorted(run.estimate.frames, frame.frame)))


def crash_frame(session: Session, done: float) -> WrongFrame:
    """Return the frame at which a SLAM raised an exception; `done` is the share of frames processed before, in [0, 1]."""
    stamps = session.tour.stamps
    frame = min(round(done * len(stamps)), len(stamps) - 1)
    where = "in start() or at the first frame" if done == 0.0 else "in process()" if done < 1.0 else "after the last frame"
    room = session.house.rooms[session.truths[frame].room].id
    return WrongFrame(frame, room, float(stamps[frame] - stamps[0]), f"the SLAM raised {where}")


def wrong_numbers(run: Run, name: Literal["rooms", "floors"]) -> Bool[np.ndarray, "n"]:
    """Return for every frame whether its room instance or its floor is wrong; for none without such estimates."""
    search = {"rooms": _instance, "floors": _floor}[name]
    wrong = np.zeros(len(run.estimate.frames), bool)
    wrong[[found.row for found in search(run)]] = True
    return wrong


def wrong_labels(run: Run, figure: str | None) -> Bool[np.ndarray, "n"]:
    """Return for every frame whether its label is wrong for a figure; for none without labels.

    For "labels.accuracy_graded", the labels of both rooms are right near an open boundary. For all other figures, and
    without a figure, only the label of the room that contains the camera is right.
    """
    labels = run.estimate.labels
    if labels is None:
        return np.zeros(len(run.estimate.frames), bool)
    if figure != _GRADED:
        return np.asarray(labels != run.true_labels)
    return np.asarray((labels < 0) | ~run.allowed_labels[np.arange(len(labels)), labels])


def _position_errors(estimated: Poses, truth: Poses) -> Float64[np.ndarray, "n 3"]:
    """Return the errors of the estimated positions in W [m], after the alignment for the absolute trajectory error."""
    return np.asarray((aligned(estimated, truth) - truth)[:, :3, 3])


def _room_id(run: Run, row: int) -> str:
    """Return the id of the room that truly contains the camera in a row of the estimate."""
    return run.house.rooms[int(run.true_rooms[row])].id


def _room(run: Run, room: int) -> str:
    """Return the id of a room and, if the SLAM estimates labels, its label unless the id contains it.

    A reduced scenario may have changed the label.
    """
    found = run.house.rooms[room]
    return found.id if run.estimate.labels is None or found.label in found.id else f"{found.id} ({found.label})"


def _label(run: Run, figure: str | None = None) -> Iterator[_Wrong]:
    """Yield the frames whose label is wrong for a figure; see `wrong_labels`."""
    estimates, before, truth = run.estimate.labels, run.estimate.baseline_labels, run.true_labels
    names = [*(f"labelled {name}" for name in run.room_names), NO_LABEL]  # index -1, for no label, is the last entry
    if estimates is not None:
        for k in np.flatnonzero(wrong_labels(run, figure)).tolist():
            changed = before is not None and before[k] != estimates[k]
            refined = f" (before refinement: {names[before[k]]})" if before is not None and changed else ""
            yield _Wrong(k, f"{names[estimates[k]]}, is {run.room_names[truth[k]]}{refined}")


def _floor(run: Run) -> Iterator[_Wrong]:
    estimates, truth = run.estimate.floors, run.true_floors
    if estimates is not None:
        wrong = np.flatnonzero((estimates != truth) & ~run.on_stairs)
        for k in wrong.tolist():
            estimate = "no floor" if estimates[k] < 0 else f"floor {estimates[k]}"
            yield _Wrong(k, f"estimated on {estimate}, is on floor {truth[k]}")


def _position(run: Run) -> Iterator[_Wrong]:
    """Yield the end of the first wrong motion and then, if positions are wrong at all, the frame with the largest error."""
    if run.estimate.T_W_B is not None:
        if (motion := first_wrong_motion(run)) is not None:
            yield _Wrong(motion.end, motion.what, motion.start)
        errors = _position_errors(run.estimate.T_W_B, run.true_poses)
        errors_m = np.linalg.norm(errors, axis=1)
        row = int(np.argmax(errors_m))
        if errors_m[row] >= _SEEN_M:
            up_m = float(errors[row, 2])
            how = "off" if abs(up_m) < _UPRIGHT * errors_m[row] else "too high" if up_m > 0.0 else "too low"
            off = f"the position is {errors_m[row]:.2f} m {how} after alignment of the whole path"
            yield _Wrong(row, f"{off}, more than anywhere else")


def _loop(run: Run) -> Iterator[_Wrong]:
    """Yield the later frames of loop edges whose relative pose is wrong, in the order of time."""
    loops, stamps = run.estimate.loops, run.true_stamps - run.session.tour.stamps[0]
    if loops is not None:
        for k in sorted(np.flatnonzero(~edge_truth(run)), key=lambda k: int(loops.query[k])):
            query, match = int(loops.query[k]), int(loops.match[k])
            place = f"the frame at {stamps[match]:.1f} s in {_room_id(run, match)}"
            yield _Wrong(query, f"a false loop closure with {place}")


def _instance_or_label(run: Run) -> Iterator[_Wrong]:
    """Yield the frames in a wrong room instance, with their label if it is wrong, too, then those with a wrong label."""
    labels = {found.row: found.what for found in _label(run)}
    for found in _instance(run):
        yield found._replace(what=f"{found.what}; {labels[found.row]}") if found.row in labels else found
    yield from _label(run)


def _instance(run: Run) -> Iterator[_Wrong]:
    """Yield the frames in no room instance or in a wrong one; see `misplaced`."""
    names = run.estimated_rooms
    for row, estimate, how, other in misplaced(run):
        match how:
            case "nowhere":
                yield _Wrong(row, "in no estimated room")
            case "merged":
                yield _Wrong(row, f"in the estimated {names[estimate]}, which lies mostly in {_room(run, other)}")
            case "split":
                mostly = "in no estimated room" if other < 0 else f"the estimated {names[other]}"
                yield _Wrong(row, f"in the estimated {names[estimate]}, though most of this room is {mostly}")


def misplaced(run: Run) -> Iterator[Misplaced]:
    """Yield the frames in no room instance or in a wrong one; none if the SLAM estimates no rooms.

    The room instance of a frame is wrong in two cases: most of the instance lies in another true room than the frame, or
    most frames of the frame's true room belong to another instance.
    """
    estimates, truth = run.estimate.rooms, run.true_rooms
    if estimates is None:
        return
    main_room, main_estimate = _most_frequent(estimates, truth), _most_frequent(truth, estimates)
    for row, (estimate, room) in enumerate(zip(estimates.tolist(), truth.tolist(), strict=True)):
        if estimate < 0:
            yield Misplaced(row, estimate, "nowhere", room)
        elif main_room[estimate] != room:
            yield Misplaced(row, estimate, "merged", main_room[estimate])
        elif main_estimate[room] != estimate:
            yield Misplaced(row, estimate, "split", main_estimate[room])


def _most_frequent(groups: Int[np.ndarray, "n"], values: Int[np.ndarray, "n"]) -> dict[int, int]:
    """Return the most frequent value of every group; on a tie, the smallest one."""
    chosen = {}
    for group in np.unique(groups):
        found, counts = np.unique(values[groups == group], return_counts=True)
        chosen[int(group)] = int(found[np.argmax(counts)])
    return chosen


WITH_LABELS = ("", "labels", "rooms", "planning")
"""First parts of the names of figures that labels affect; "" stands for no figure."""
_SEARCHES: Mapping[str, Callable[[Run], Iterator[_Wrong]]] = MappingProxyType(
    {
        "": _label,
        "labels": _label,
        _GRADED: partial(_label, figure=_GRADED),
        "planning": _label,
        "rooms": _instance_or_label,
        "floors": _floor,
        "trajectory": _position,
        "loops": _loop,
    }
)
"""Searches for wrong rows of the estimate, by a figure's name or its first part; "" stands for no figure. There is no search
for other figures, because they describe the run as a whole."""
