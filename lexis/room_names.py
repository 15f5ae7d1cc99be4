"""Names of room instances: "office 1" and "office 2" if there are several rooms of a label, "kitchen" if there is one."""

from collections import Counter
from collections.abc import Sequence

from lexis.types import RoomInstance


def instance_names(rooms: Sequence[RoomInstance]) -> tuple[str, ...]:
    """Return one unique name per room, in the order of the rooms.

    If several rooms have the same label, they are numbered from 1 in this order.
    """
    return numbered([room.label for room in rooms])


def numbered(labels: Sequence[str]) -> tuple[str, ...]:
    """Return one unique name for each entry of `labels`, in the same order; equal labels are numbered from 1."""
    total = Counter(labels)
    seen: Counter[str] = Counter()
    names = []
    for label in labels:
        seen[label] += 1
        names.append(label if total[label] == 1 else f"{label} {seen[label]}")
    return tuple(names)


def unused_names(names: Sequence[str], rooms: Sequence[RoomInstance]) -> tuple[str, ...]:
    """Return the entries of `names` that no room has as its label, in the same order."""
    used = {room.label for room in rooms}
    return tuple(name for name in names if name not in used)


def same_name(one: str, other: str) -> bool:
    """Whether two names are equal up to case, and to blanks at their ends."""
    return one.strip().lower() == other.strip().lower()


def find_rooms(rooms: Sequence[RoomInstance], name: str) -> tuple[RoomInstance, ...]:
    """Return the room with this name ("office 2"), or if no room has it, all rooms with this label ("office").

    There may be none. Case, and blanks around `name`, are ignored.
    """
    exact = tuple(room for room, own in zip(rooms, instance_names(rooms), strict=True) if same_name(own, name))
    return exact or tuple(room for room in rooms if same_name(room.label, name))
