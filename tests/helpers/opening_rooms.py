"""A house with an opening of every kind: a kitchen and a living room side by side, and a garden in front of both."""

import math

from worlds.spec import HouseSpec, LeafSpec, OpeningSpec, RoomSpec, StoreySpec

WALL_X = 5.0
LENGTH_M = 14.0
ROOMS = ("kitchen", "living room")
_SPANS = {
    "door": (1.0, 1.9),
    "cased": (2.6, 3.9),
    "arch": (4.5, 5.9),
    "half wall": (6.5, 8.0),
    "counter": (8.6, 10.2),
    "open": (10.8, 13.0),
}


def opening(kind: str, **more) -> OpeningSpec:
    """The opening of a kind in the wall between the kitchen and the living room."""
    low, high = _SPANS[kind]
    return OpeningSpec(rooms=ROOMS, kind=kind, start_m=(WALL_X, low), end_m=(WALL_X, high), **more)


def every_kind() -> HouseSpec:
    """The specification of the house, without furniture."""
    rooms = (
        RoomSpec(id="kitchen", label="kitchen", polygon_m=((0.0, 0.0), (WALL_X, 0.0), (WALL_X, LENGTH_M), (0.0, LENGTH_M))),
        RoomSpec(
            id="living room",
            label="living room",
            # L-shaped, with a reflex corner that juts into the room.
            polygon_m=((WALL_X, 0.0), (10.0, 0.0), (10.0, 9.0), (8.0, 9.0), (8.0, LENGTH_M), (WALL_X, LENGTH_M)),
        ),
        RoomSpec(id="garden", label="garden", polygon_m=((0.0, -4.0), (10.0, -4.0), (10.0, 0.0), (0.0, 0.0))),
    )
    openings = (
        opening("door", leaf=LeafSpec(hinge="end", into="living room", angle_rad=math.radians(70.0))),
        opening("cased", height_m=2.1),
        opening("arch", height_m=2.3),
        opening("half wall"),
        opening("counter"),
        opening("open"),
        OpeningSpec(
            rooms=("living room", "garden"),
            kind="door",
            start_m=(7.0, 0.0),
            end_m=(7.9, 0.0),
            leaf=LeafSpec(into="living room", angle_rad=math.pi / 2),
        ),
    )
    return HouseSpec(name="every-kind", clutter=0.0, storeys=(StoreySpec(rooms=rooms, openings=openings),))
