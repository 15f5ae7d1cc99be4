"""Hypothesis strategies that draw houses for property-based tests.

A strategy draws the rooms of a house rather than a seed, so that Hypothesis can shrink a failing house to a small one.
Every drawn house is valid: `build_house` and `validate` accept it. Houses are unfurnished by default. Rooms shrink to
rectangles of 2 x 2 m; labels and kinds of openings shrink to the first entries of the caller's lists. With the package
installed, `st.from_type(HouseSpec)` draws `houses()`. Invalid arguments raise `hypothesis.errors.InvalidArgument`.
"""

from collections.abc import Sequence
from typing import TypeVar, get_args

from hypothesis import strategies as st
from hypothesis.errors import InvalidArgument
from hypothesis.strategies import SearchStrategy

from worlds.floor_plans.grown_plan import (
    MIN_SIZE_DM,
    MIN_WIDTH_DM,
    DoorState,
    OpeningRequest,
    RoomRequest,
    Shape,
    Start,
    grow,
)
from worlds.labels import OUTDOOR_LABELS, ROOM_LABELS, STAIRS
from worlds.openings.openness import nearly_opened, openness_of
from worlds.spec import HouseSpec, OpeningKind

MAX_DRAWN_ROOMS, MAX_DRAWN_STOREYS = 40, 4
DRAWABLE = tuple(label for label in ROOM_LABELS if label != STAIRS)
"""Labels that callers can request; stairs are added to houses of several storeys."""
INDOOR = tuple(label for label in DRAWABLE if label not in OUTDOOR_LABELS)
OPENING_KINDS: tuple[OpeningKind, ...] = ("door", "open", "cased", "arch", "half wall", "counter")
_MAX_SIZE_DM, _MAX_WIDTH_DM = 60, 40
_HEIGHTS_M = (2.6, 2.4, 3.0)
_CLUTTER = (1.0, 0.5, 2.0)
_T = TypeVar("_T", bound=str)


def houses(
    *,
    min_rooms: int = 2,
    max_rooms: int = 8,
    max_storeys: int = 2,
    furnished: bool = False,
    labels: Sequence[str] = INDOOR,
    distinct_labels: bool = False,
    kinds: Sequence[str] = OPENING_KINDS,
    doors: Sequence[str] = ("no leaf", "open"),
    openness: tuple[float, float] | None = None,
) -> SearchStrategy[HouseSpec]:
    """Draw houses of `min_rooms` to `max_rooms` rooms (stairs are not counted) on 1 to `max_storeys` storeys.

    Args:
        min_rooms: at least 1.
        max_rooms: at most 40.
        max_storeys: at most 4; houses of several storeys have one staircase, which joins all storeys.
        furnished: whether `build_house` fills in furniture; the amount of furniture is drawn, too.
        labels: labels that rooms can have, the simplest first; gardens and balconies are valid in one-storey houses only.
        distinct_labels: whether all rooms have different labels. Otherwise, houses shrink to rooms of one label, which a
            SLAM that tells rooms apart by their labels takes for one room where no wall is between them.
        kinds: kinds of openings, the simplest first. Half walls and counters, which cannot be walked through, get a door
            beside them where the room has no other entrance.
        doors: states of doors ("no leaf", "open", "ajar", "closed"), the simplest first; a "closed" door stops a body that
            cannot open doors. A leaf without room to swing is left out, and so are those of doors beside half walls and
            counters.
        openness: range from which the house's openness is drawn; inner walls are opened, or closed with doors, until the
            openness is within 0.05 of the value drawn (see `worlds.openings.openness`). None: openings stay as drawn.
    """
    _check_rooms(min_rooms, max_rooms)
    _check_int("max_storeys", max_storeys, 1, MAX_DRAWN_STOREYS)
    starts: tuple[Start, ...] = ("beside", "row", "storey") if max_storeys > 1 else ("beside", "row")
    room = _rooms(_choices("labels", labels, DRAWABLE), kinds, doors, starts)
    outdoor = [label for label in labels if label in OUTDOOR_LABELS]
    if outdoor and max_storeys > 1:
        raise InvalidArgument(f"labels has {outdoor[0]!r}, which bears no storey; valid with max_storeys=1 only")
    rooms = _lists(room, min_rooms, max_rooms, labels, distinct_labels)
    drawn = st.builds(grow, rooms, max_storeys=st.just(max_storeys), **_clutter(furnished))
    return drawn if openness is None else _opened(drawn, *_range("openness", openness))


def open_plans(
    *,
    min_openness: float = 0.5,
    min_rooms: int = 2,
    max_rooms: int = 6,
    furnished: bool = False,
    labels: Sequence[str] = INDOOR,
    distinct_labels: bool = False,
) -> SearchStrategy[HouseSpec]:
    """Draw one-storey houses whose openness is at least `min_openness`; the simplest have no inner walls.

    Openness is the share of the area of all boundaries between indoor rooms that is permanently open; doors count as closed.
    At least 2 rooms are drawn, and none is outdoors. See `houses` for the other arguments.
    """
    _check_rooms(min_rooms, max_rooms, least=2)
    if isinstance(min_openness, bool) or not isinstance(min_openness, int | float) or not 0.0 <= min_openness <= 1.0:
        raise InvalidArgument(f"min_openness={min_openness!r} is not in 0 ... 1")
    kinds = ("open", "cased", "half wall", "counter", "arch", "door")
    room = _rooms(_choices("labels", labels, INDOOR), kinds, ("no leaf",), ("beside", "row"))
    rooms = _lists(room, min_rooms, max_rooms, labels, distinct_labels)
    return st.builds(grow, rooms, min_openness=st.just(min_openness), **_clutter(furnished))


def room_pairs(
    *,
    furnished: bool = False,
    labels: Sequence[str] = INDOOR,
    kinds: Sequence[str] = OPENING_KINDS,
    doors: Sequence[str] = ("no leaf", "open"),
) -> SearchStrategy[HouseSpec]:
    """Draw houses of exactly two neighbouring rooms; see `houses` for the arguments."""
    room = _rooms(_choices("labels", labels, DRAWABLE), kinds, doors, ("beside", "row"))
    return st.builds(grow, st.lists(room, min_size=2, max_size=2), **_clutter(furnished))


def _clutter(furnished: bool) -> dict[str, SearchStrategy[float]]:
    """Return the argument of `grow` with which `build_house` fills in furniture; none for unfurnished houses."""
    _check_bool("furnished", furnished)
    return {"clutter": st.sampled_from(_CLUTTER)} if furnished else {}


def _opened(drawn: SearchStrategy[HouseSpec], low: float, high: float) -> SearchStrategy[HouseSpec]:
    target = st.integers(0, 100).map(lambda percent: low + (high - low) * percent / 100)
    # The openness of a house without boundaries between rooms, or with short ones, cannot change, so it may miss the range.
    return st.builds(nearly_opened, drawn, target).filter(lambda spec: low - 0.05 <= openness_of(spec) <= high + 0.05)


def _lists(
    room: SearchStrategy[RoomRequest], min_rooms: int, max_rooms: int, labels: Sequence[str], distinct_labels: bool
) -> SearchStrategy[list[RoomRequest]]:
    """Draw lists of rooms. Raises `InvalidArgument` if there are too few labels for rooms with different ones."""
    _check_bool("distinct_labels", distinct_labels)
    if not distinct_labels:
        return st.lists(room, min_size=min_rooms, max_size=max_rooms)
    if max_rooms > len(set(labels)):
        raise InvalidArgument(
            f"max_rooms is {max_rooms}; valid with distinct_labels: up to {len(set(labels))}, one per label"
        )
    return st.lists(room, min_size=min_rooms, max_size=max_rooms, unique_by=lambda room: room.label)


def _rooms(
    label: SearchStrategy[str], kinds: Sequence[str], doors: Sequence[str], starts: Sequence[Start]
) -> SearchStrategy[RoomRequest]:
    """Draw requests for rooms, either plain or with all options.

    Plain rooms help Hypothesis to shrink a house: Hypothesis deletes at most five consecutive draws at once, and a plain
    room in a list takes exactly five draws. Plain rooms are entered through the simplest opening.
    """
    valid_kinds, states = _valid("kinds", kinds, OPENING_KINDS), _valid("doors", doors, get_args(DoorState))
    simplest = OpeningRequest(valid_kinds[0], leaf=states[0])
    way = _ways(valid_kinds, states)
    size = st.integers(MIN_SIZE_DM, _MAX_SIZE_DM)
    plain = st.builds(RoomRequest, label, size, size, way_in=st.just(simplest))
    elaborate = st.builds(
        RoomRequest,
        label,
        size,
        size,
        start=st.sampled_from(starts),
        shape=st.sampled_from(get_args(Shape)),
        height_m=st.sampled_from(_HEIGHTS_M),
        way_in=way,
        other=st.one_of(st.just(OpeningRequest(None)), way),
        from_south=st.booleans(),
    )
    return st.one_of(plain, elaborate, elaborate, elaborate)


def _ways(kinds: Sequence[OpeningKind], states: Sequence[DoorState]) -> SearchStrategy[OpeningRequest]:
    return st.builds(
        OpeningRequest,
        kind=st.sampled_from(kinds),
        width_dm=st.integers(MIN_WIDTH_DM, _MAX_WIDTH_DM),
        offset_dm=st.integers(0, _MAX_SIZE_DM),
        leaf=st.sampled_from(states),
        hinge=st.sampled_from(("start", "end")),
        into_first=st.booleans(),
    )


def _choices(name: str, given: Sequence[str], valid: Sequence[_T]) -> SearchStrategy[_T]:
    return st.sampled_from(_valid(name, given, valid))


def _valid(name: str, given: Sequence[str], valid: Sequence[_T]) -> list[_T]:
    """Return the values in an argument. Raises `InvalidArgument` unless they are one or more of the valid values."""
    if isinstance(given, str) or not isinstance(given, Sequence) or not given:
        raise InvalidArgument(f"{name}={given!r} is not a list of at least one of {', '.join(valid)}")
    by_name = {str(value): value for value in valid}
    for value in given:
        if value not in by_name:
            raise InvalidArgument(f"{name} has {value!r}; valid: {', '.join(valid)}")
    return [by_name[value] for value in given]


def _check_rooms(min_rooms: int, max_rooms: int, least: int = 1) -> None:
    _check_int("min_rooms", min_rooms, least, MAX_DRAWN_ROOMS)
    _check_int("max_rooms", max_rooms, least, MAX_DRAWN_ROOMS)
    if min_rooms > max_rooms:
        raise InvalidArgument(f"min_rooms={min_rooms} exceeds max_rooms={max_rooms}")


def _check_int(name: str, value: int, low: int, high: int) -> None:
    if isinstance(value, bool) or not isinstance(value, int) or not low <= value <= high:
        raise InvalidArgument(f"{name}={value!r} is not a whole number in {low} ... {high}")


def _range(name: str, given: tuple[float, float]) -> tuple[float, float]:
    try:
        low, high = (float(value) for value in given)
    except (TypeError, ValueError):
        low, high = 1.0, 0.0
    if not 0.0 <= low <= high <= 1.0:
        raise InvalidArgument(f"{name}={given!r} is not a range within 0 ... 1, the lower end first")
    return low, high


def _check_bool(name: str, value: bool) -> None:
    if not isinstance(value, bool):
        raise InvalidArgument(f"{name}={value!r} is not True or False")
