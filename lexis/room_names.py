"""Names of room instances: "office 1" and "office 2" if there are several rooms of a label, "kitchen" if there is one."""

import difflib
from collections import Counter
from collections.abc import Iterator, Sequence, Set
from itertools import count

from lexis.types import RoomInstance


def instance_names(rooms: Sequence[RoomInstance]) -> tuple[str, ...]:
    """Return one unique name per room, in the order of the rooms.

    If several rooms have the same label, they are numbered from 1 in this order.
    """
    return numbered([room.label for room in rooms])


def numbered(labels: Sequence[str]) -> tuple[str, ...]:
    """Return one unique name for each entry of `labels`, in the same order; equal labels are numbered from 1.

    Names that are labels themselves are left out: two offices beside an "office 1" are "office 2" and "office 3".
    """
    total = Counter(labels)
    taken = {label.lower() for label in labels}
    free = {label: _free_names(label, taken) for label in total}
    return tuple(label if total[label] == 1 else next(free[label]) for label in labels)


def _free_names(label: str, taken: Set[str]) -> Iterator[str]:
    """Yield "office 1", "office 2" and so on, without the names that are taken in lower case."""
    return (name for k in count(1) if (name := f"{label} {k}").lower() not in taken)


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


def no_such_room(rooms: Sequence[RoomInstance], name: str) -> str:
    """Return a message about a name that no room has, such as "no room 'kichen' in the map (did you mean 'kitchen'?)".

    It does not say which names are valid.
    """
    names = {own.lower(): own for own in (*(room.label for room in rooms), *instance_names(rooms))}
    guess = difflib.get_close_matches(name.strip().lower(), names, n=1)
    return f"no room {name!r} in the map" + (f" (did you mean {names[guess[0]]!r}?)" if guess else "")
