"""Laws of declarations: a declaration with which no piece can be placed is refused, with the field and the valid values."""

import math
import re

import pytest
from helpers.unchecked import unchecked

from worlds.errors import WorldsError
from worlds.furniture.kinds import AgainstWall, Around, Kind, OnFloor, OnTop, OnWall, PerClutter

RANGE = (0.4, 0.5)
GOOD = {"name": "rack", "width": RANGE, "depth": RANGE, "height": RANGE, "rooms": {"kitchen": 1}, "build": lambda s, rng: ()}


def _place(cls, **values):
    return {"place": unchecked(cls, **values)}


@pytest.mark.parametrize("axis", ["width", "depth", "height"])
@pytest.mark.parametrize(
    "size",
    [
        0.5,
        (0.5,),
        (0.5, 0.6, 0.7),
        "ab",
        ("1", "2"),
        (0, 1),
        (-1, 1),
        (3, 1),
        (30, 40),
        (0.5, math.inf),
        (math.nan, 1),
        None,
    ],
)
def test_a_size_that_is_not_a_range_of_metres_is_refused(axis, size):
    expected = f"kind 'rack': {axis} is {size!r}; valid: a range (low, high) with 0 < low <= high <= 20 m"
    with pytest.raises(WorldsError, match=re.escape(expected)):
        unchecked(Kind, **GOOD | {axis: size})


@pytest.mark.parametrize(
    "count",
    [
        0,
        -1,
        0.0,
        math.inf,
        math.nan,
        "2",
        None,
        [1, 2],
        (1,),
        (0, 0),
        (2, 1),
        (-1, 2),
        (0.5, 1.5),
        PerClutter(0.0),
        PerClutter(-1.0),
    ],
)
def test_a_count_of_no_piece_is_refused(count):
    with pytest.raises(WorldsError, match=r"kind 'rack': the count in 'kitchen' is .*; valid: a number above 0, "):
        unchecked(Kind, **GOOD | {"rooms": {"kitchen": count}})


@pytest.mark.parametrize("rooms", ["kitchen", {"kitchen"}, ("kitchen", 1), None])
def test_rooms_without_counts_are_refused(rooms):
    with pytest.raises(WorldsError, match=r"kind 'rack': rooms is .*; valid: a dictionary"):
        unchecked(Kind, **GOOD | {"rooms": rooms})


@pytest.mark.parametrize(
    ("room", "guess"), [("dungeon", ""), ("Kitchen", r" \(did you mean 'kitchen'\?\)"), (3, ""), (None, "")]
)
def test_an_unknown_room_is_refused(room, guess):
    says = f"kind 'rack' names an unknown room {room!r}{guess}; valid: kitchen, dining room, "
    with pytest.raises(WorldsError, match=says):
        unchecked(Kind, **GOOD | {"rooms": {"kitchen": 1, room: 1}})


@pytest.mark.parametrize(
    ("field", "bad"),
    [
        ("place", {"place": AgainstWall}),
        ("place", {"place": "wall"}),
        ("clearance", {"clearance": -1}),
        ("clearance", {"clearance": math.inf}),
        ("clearance", {"clearance": "0.5"}),
        ("hosts", _place(OnTop, hosts="stove")),
        ("hosts", _place(OnTop, hosts=())),
        ("hosts", _place(Around, hosts=("sofa", 3))),
        ("above", _place(OnWall, above="stove")),
        ("beside", _place(AgainstWall, beside="sofa")),
        ("gap_m", _place(Around, hosts=("sofa",), gap_m=-0.1)),
        ("height_m", _place(OnWall, height_m=1.5)),
        ("height_m", _place(OnWall, height_m=(160, 170))),
        ("height_m", _place(OnWall, height_m=(1.7, 1.6))),
        ("spot", _place(OnFloor, spot="center")),
        ("side", _place(Around, hosts=("sofa",), side="back")),
        ("at", _place(OnTop, hosts=("stove",), at="centre")),
    ],
)
def test_a_place_that_no_piece_can_have_is_refused(field, bad):
    with pytest.raises(WorldsError, match=rf"kind 'rack': {field} is .*; valid: \w+"):
        unchecked(Kind, **GOOD | bad)


@pytest.mark.parametrize(
    "good",
    [
        {"width": (1, 20)},
        {"width": (0.5, 0.5)},
        {"rooms": {}},
        {"rooms": {"kitchen": 0.001, "garden": (0, 1), "garage": (2, 2), "office": PerClutter(0.5)}},
        {"clearance": 0},
        {"place": OnWall((0.0, 0.0))},
        {"place": OnTop(("stove", "desk"), "back")},
    ],
)
def test_the_limits_are_valid(good):
    assert unchecked(Kind, **GOOD | good)


def test_a_range_that_begins_at_none_requires_no_piece():
    kind = Kind(**GOOD | {"rooms": {"kitchen": (0, 1), "office": (1, 1), "bedroom": 0.5}})
    assert [kind.is_required_in(label) for label in ("kitchen", "office", "bedroom", "gym")] == [False, True, False, False]
