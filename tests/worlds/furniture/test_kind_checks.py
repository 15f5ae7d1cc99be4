"""Laws of the first house after a declaration: it is refused if a kind names unknown kinds or builds other than declared."""

import math
import re

import pytest

from worlds.errors import WorldsError
from worlds.furniture.kinds import AgainstWall, Around, OnTop, OnWall
from worlds.furniture.palette import OAK
from worlds.furniture.registry import furniture
from worlds.furniture.shapes import box
from worlds.house import build_house
from worlds.parts import Part
from worlds.presets import sample_from_rooms

HOUSE = sample_from_rooms(("kitchen", "office"), seed=1)


def _declare(build, **place):
    ranges = {"width": (0.6, 0.9), "depth": (0.4, 0.4), "height": (0.5, 0.5)}
    return furniture("gong", **ranges, rooms={"library": (1, 1)}, **place)(build)


def _whole(s, rng):
    return (box(s.x, s.y, s.z, OAK),)


@pytest.mark.parametrize(
    "place",
    [OnTop(("stove", "stoove")), Around(("stoove",)), OnWall(above=("stoove",)), AgainstWall(beside=("stove", "stoove"))],
)
def test_unknown_hosts_are_refused_until_they_are_declared(kinds, place):
    _declare(_whole, place=place)
    with pytest.raises(
        WorldsError, match=r"kind 'gong': its place names an unknown kind 'stoove' \(did you mean 'stove'\?\); valid: "
    ):
        build_house(HOUSE)
    furniture("stoove", width=(1.0, 1.0), depth=(1.0, 1.0), height=(1.0, 1.0), rooms={})(_whole)
    assert build_house(HOUSE).furniture


def coloured(colour):
    """A box with a colour that a user's function may have chosen, but which the type checks of tests would refuse."""
    part = box((0.0, 0.1), (0.0, 0.1), (0.0, 0.1), OAK)
    object.__setattr__(part, "colour", colour)
    return part


@pytest.mark.parametrize(
    ("parts", "mistake"),
    [
        (None, "its function returns None; valid: a tuple of at least one part"),
        ((), "its function returns (); valid: a tuple of at least one part"),
        (box((0.0, 0.1), (0.0, 0.1), (0.0, 0.1), OAK), "its function returns Part("),
        ((box((0.0, 0.1), (0.0, 0.1), (0.0, 0.1), OAK, "velvet"),), "a box has the material 'velvet'; valid: bare, plain, "),
        ((box((0.0, 0.1), (0.0, 0.1), (0.0, 0.1), (200.0, 90.0, 0.0)),), "a box has the colour (200.0, 90.0, 0.0); valid: "),
        ((coloured("red"),), "a box has the colour 'red'; valid: three numbers from 0 to 1"),
        ((coloured(7),), "a box has the colour 7; valid: three numbers from 0 to 1"),
        ((box((-5.0, 5.0), (0.0, 0.1), (0.0, 0.1), OAK),), "a box reaches from -5 to 5 m along x; valid: -0.3 ... 0.3 m"),
        ((box((0.0, 0.1), (0.0, 0.3), (0.0, 0.1), OAK),), "a box reaches from 0 to 0.3 m along y; valid: -0.2 ... 0.2 m"),
        ((box((0.0, 0.1), (0.0, 0.1), (-0.1, 0.1), OAK),), "a box reaches from -0.1 to 0.1 m along z; valid: 0 ... 0.5 m"),
        ((box((0.1, 0.0), (0.0, 0.1), (0.0, 0.1), OAK),), "a box reaches from 0.1 to 0 m along x; valid: -0.3 ... 0.3 m"),
        ((box((0.0, math.nan), (0.0, 0.1), (0.0, 0.1), OAK),), "a box reaches from nan to nan m along x; valid: "),
        (
            (Part("box", (0.0, 0.0, 0.1), (0.5, 0.1, 0.1), OAK, yaw=math.pi / 2),),
            "a box reaches from -0.25 to 0.25 m along y; valid: ",
        ),
    ],
)
def test_a_kind_that_builds_other_than_declared_is_refused(kinds, parts, mistake):
    _declare(lambda s, rng: parts)
    for _ in range(2):
        with pytest.raises(WorldsError, match=re.escape("kind 'gong', built at 0.6 x 0.4 x 0.5 m: " + mistake)):
            build_house(HOUSE)


def test_a_turned_part_may_be_longer_than_the_piece_is_wide(kinds):
    _declare(lambda s, rng: (Part("box", (0.0, 0.0, 0.25), (s.depth, s.width, s.height), OAK, yaw=math.pi / 2),))
    assert build_house(HOUSE).furniture
