"""`error_kinds`: what the wrong frames of a run have in common, such as a floor that is too high, to tell failures apart."""

from collections import Counter
from collections.abc import Iterator, Mapping

from lexis.evaluation.rooms import SHARE
from sim.harness.diagnosis.first_wrong import misplaced
from sim.harness.finished_run import Run
from sim.harness.results import group_of

ON_NO_FLOOR, TOO_HIGH, TOO_LOW = "placed on no floor", "placed on a floor too high", "placed on a floor too low"
IN_NO_ROOM, SPLIT = "in no estimated room", "split from the rest of their room"
TWINS, STRANGERS = "merged with a room of the same label", "merged with a room of another label"
STRAY = "on the wrong side of a border between rooms"
"""Kind of frames that belong to another room's instance while their own room is not merged: mostly frames near doorways."""


def error_kinds(run: Run, figure: str | None, labels: Mapping[str, str]) -> "Counter[str]":
    """Count the frames with each kind of error, for figures of rooms and floors; for other figures, the result is empty.

    Args:
        run: a run that fails.
        figure: the figure of the failure, such as "rooms.pq"; None if it is not known.
        labels: the label of every room in the original scenario, by the room's id. A smaller scenario may have changed it.
    """
    match group_of(figure):
        case "floors":
            return Counter(_of_floors(run))
        case "rooms":
            return Counter(_of_rooms(run, labels))
    return Counter()


def most_frequent(kinds: "Counter[str]") -> str:
    """Return the most frequent kind, which must exist; of equally frequent ones, the first of the alphabet."""
    return min(kinds, key=lambda kind: (-kinds[kind], kind))


def are_alike(kinds: "Counter[str]", original: "Counter[str]") -> bool:
    """Whether the most frequent kind of error is that of the original. Without any kinds, nothing can be said: True."""
    return not kinds or not original or most_frequent(kinds) == most_frequent(original)


def _of_floors(run: Run) -> Iterator[str]:
    estimates, truth = run.estimate.floors, run.true_floors
    if estimates is not None:
        for estimate, floor in zip(estimates[~run.on_stairs].tolist(), truth[~run.on_stairs].tolist(), strict=True):
            if estimate != floor:
                yield ON_NO_FLOOR if estimate < 0 else TOO_HIGH if estimate > floor else TOO_LOW


def _of_rooms(run: Run, labels: Mapping[str, str]) -> Iterator[str]:
    named, truth = [labels.get(room.id, room.label) for room in run.house.rooms], run.true_rooms
    for row, estimate, how, other in misplaced(run):
        room = int(truth[row])
        match how:
            case "nowhere":
                yield IN_NO_ROOM
            case "merged" if not _lies_mostly_in(run, room, estimate):
                yield STRAY
            case "merged":
                yield TWINS if named[other] == named[room] else STRANGERS
            case "split":
                yield SPLIT


def _lies_mostly_in(run: Run, room: int, estimate: int) -> bool:
    """Whether most frames of a true room are in an estimated room, as in the figure `rooms.merges`."""
    assert run.estimate.rooms is not None
    return bool((run.estimate.rooms[run.true_rooms == room] == estimate).mean() > SHARE)
