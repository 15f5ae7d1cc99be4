"""Windows: `sample_windows` draws windows for the rooms of a spec that has none; `hang_windows` turns specs into objects."""

import math
import zlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.random import Generator

from worlds.errors import HouseError
from worlds.furniture.decor import window as window_parts
from worlds.furniture.kinds import Range, Size
from worlds.parts import Part, Vector
from worlds.placed import Placed
from worlds.spec import HouseSpec, RoomSpec, WindowSpec
from worlds.walls import WALL_THICKNESS_M, Boundary, segment_span

WINDOW_DEPTH_M = 0.07
"""Depth of frame, sill and curtains, measured from the wall into the room [m]."""
_CORNER_M = 0.2
"""Least distance of a window from the ends of its wall [m]."""
_APART_M = 0.3
"""Least distance between two windows [m]."""
_UNDER_CEILING_M = 0.12
"""Least distance of a window from the ceiling [m]."""
_TRIES = 4
"""Number of positions that are tried for each window."""
_TOLERANCE_M = 1e-6


@dataclass(frozen=True)
class _WindowStyle:
    """Number and size of the windows in one kind of room."""

    count: Range
    """Range from which the expected number of windows is drawn."""
    width: Range
    """Range from which the width of a window is drawn [m]."""
    sill: Range
    """Range from which the sill's height above the floor is drawn [m]."""
    height: Range
    """Range from which the height of a window, from its sill to its upper edge, is drawn [m]."""


_USUAL = _WindowStyle((1.0, 2.0), (1.1, 1.7), (0.92, 1.02), (1.1, 1.3))
_SELDOM = _WindowStyle((0.4, 0.5), (1.1, 1.5), (0.92, 1.02), (1.1, 1.3))
_LARGE = _WindowStyle((1.0, 2.0), (1.4, 2.0), (0.7, 0.95), (1.3, 1.5))
_ROW = _WindowStyle((2.0, 4.0), (1.4, 2.0), (0.9, 1.0), (1.2, 1.4))
_HIGH = _WindowStyle((0.5, 0.5), (0.6, 0.9), (1.45, 1.55), (0.5, 0.6))
_WINDOW_STYLES: Mapping[str, _WindowStyle] = {
    **dict.fromkeys(("dining room", "bedroom", "children's room", "office", "meeting room", "gym", "print room"), _USUAL),
    **dict.fromkeys(("library", "laboratory", "lobby"), _USUAL),
    "living room": _LARGE,
    **dict.fromkeys(("open-plan office", "classroom"), _ROW),
    "kitchen": _WindowStyle((1.0, 1.0), (1.1, 1.4), (1.05, 1.1), (0.95, 1.1)),
    "bathroom": _HIGH,
    "toilet": _WindowStyle((0.3, 0.3), (0.5, 0.7), (1.5, 1.6), (0.45, 0.55)),
    **dict.fromkeys(("corridor", "entrance hall", "laundry room"), _SELDOM),
}
"""Styles of windows by room label; rooms with other labels have no windows."""


@dataclass(frozen=True, eq=False)
class Window(Placed):
    """A window in its wall. The placed object is the part in front of the wall, in the room: frame, sill and curtains."""

    id: str
    room: str
    storey: int
    wall: Boundary
    """The stretch of outer wall in which the window lies."""
    start: tuple[float, float]
    """One end of the window on the wall's centre line [m]."""
    end: tuple[float, float]
    """Other end of the window on the wall's centre line [m]."""
    position: Vector
    yaw: float
    size: Vector
    seed: int
    """Seed of the window's appearance."""

    @cached_property
    def parts(self) -> tuple[Part, ...]:
        """Frame, panes, sill, and in some windows curtains."""
        return window_parts(Size(*self.size), np.random.default_rng(self.seed))


def sample_windows(room: RoomSpec, outer: Sequence[Boundary], height_m: float, rng: Generator) -> tuple[WindowSpec, ...]:
    """Draw the windows of a room whose ceiling is `height_m` above the floor [m].

    `outer` are the stretches of the room's walls with no indoor room behind them. All windows of a room have the same size.
    Windows keep their distance from corners and from each other; a window for which no free position is found is left out.
    """
    look = _WINDOW_STYLES.get(room.label)
    if look is None or not outer:
        return ()
    low, high = look.count
    share, *sizes = rng.random(4).tolist()
    wanted = math.floor(low + share * (high - low) + rng.random())
    width, sill, height = (a + t * (b - a) for (a, b), t in zip((look.width, look.sill, look.height), sizes, strict=True))
    top = min(sill + height, height_m - _UNDER_CEILING_M)
    placed: list[tuple[Boundary, float, float]] = []
    for place in rng.random((wanted, _TRIES)).tolist():
        found = next((spot for t in place if (spot := _spot(outer, (width, look.width[0]), t, placed)) is not None), None)
        if found is not None:
            placed.append(found)
    return tuple(
        WindowSpec(
            room=room.id,
            start_m=wall.point(round(start, 3)),
            end_m=wall.point(round(stop, 3)),
            sill_m=round(sill, 3),
            height_m=round(top, 3),
        )
        for wall, start, stop in placed
    )


def _spot(
    outer: Sequence[Boundary], widths: tuple[float, float], t: float, placed: Sequence[tuple[Boundary, float, float]]
) -> tuple[Boundary, float, float] | None:
    """Return the wall and both ends of a window, as (wall, lower end, upper end) [m].

    The window lies at the share `t` in [0, 1) of all possible positions along the outer walls. It has the first of `widths`
    that fits into any of the walls. The result is None if no width fits, or if the window would be too near to one of the
    windows in `placed`.
    """
    for width in widths:
        slacks = [max(0.0, wall.length - 2 * _CORNER_M - width) for wall in outer]
        left = t * sum(slacks)
        for wall, slack in zip(outer, slacks, strict=True):
            if slack > 0.0 and left <= slack:
                start = wall.low + _CORNER_M + left
                clear = all(
                    other is not wall or start >= stop + _APART_M or start + width <= begin - _APART_M
                    for other, begin, stop in placed
                )
                return (wall, start, start + width) if clear else None
            left -= slack
    return None


def hang_windows(
    spec: HouseSpec, level: int, windows: Sequence[WindowSpec], outer: Mapping[str, Sequence[Boundary]], floor_m: float
) -> Iterator[Window]:
    """Yield the windows of a storey as placed objects.

    `outer` has the stretches of outer wall of every room, by room id; `floor_m` is the floor's height in W [m]. Raises
    `HouseError` for a window that lies in no outer wall of its room, or whose sill is not below its upper edge.
    """
    rooms = {room.id: room for room in spec.storeys[level].rooms}
    for index, window in enumerate(windows):
        place = f"storeys[{level}].windows[{index}] ({window.room})"
        wall = _wall_of(window, outer.get(window.room, ()))
        if wall is None:
            raise HouseError(
                f"{place}: {window.start_m} - {window.end_m} must lie in a wall of that room with no other indoor room "
                "behind it"
            )
        if window.sill_m >= window.height_m:
            raise HouseError(f"{place}: its sill ({window.sill_m} m) is not below its upper edge ({window.height_m} m)")
        seed = _seed(spec, rooms[window.room])
        yield _hung(f"window/{level}/{index}", level, window, wall, floor_m, seed)


def _seed(spec: HouseSpec, room: RoomSpec) -> int:
    """Return the seed of the appearance of a room's windows, which look alike.

    The seed depends on the seed of the house's appearance, and on the room: on the room's own seed if it has one, and
    otherwise on the house's seed and the room's id. Twin rooms (with equal seeds) thus have windows that look alike, too.
    """
    own = (spec.seed, room.id) if room.seed is None else (room.seed,)
    return zlib.crc32(repr((own, spec.appearance.seed)).encode())


def _wall_of(spec: WindowSpec, outer: Sequence[Boundary]) -> Boundary | None:
    """Return the stretch of outer wall in which the whole window lies; None if no stretch contains it."""
    span = segment_span(spec.start_m, spec.end_m)
    if span is None:
        return None
    axis, at, low, high = span
    for wall in outer:
        inside = wall.low <= low + _TOLERANCE_M and high <= wall.high + _TOLERANCE_M
        if (wall.axis, wall.at) == (axis, at) and inside:
            return wall
    return None


def _hung(name: str, level: int, spec: WindowSpec, wall: Boundary, floor_m: float, seed: int) -> Window:
    inward = 1.0 if wall.rooms[1] == spec.room else -1.0
    off = inward * (WALL_THICKNESS_M + WINDOW_DEPTH_M) / 2
    x, y = (spec.start_m[0] + spec.end_m[0]) / 2, (spec.start_m[1] + spec.end_m[1]) / 2
    if wall.axis == 0:
        position, yaw = (x, y + off, floor_m + spec.sill_m), 0.0 if inward > 0 else math.pi
    else:
        position, yaw = (x + off, y, floor_m + spec.sill_m), math.copysign(math.pi / 2, -inward)
    width = math.dist(spec.start_m, spec.end_m)
    return Window(
        id=name,
        room=spec.room,
        storey=level,
        wall=wall,
        start=spec.start_m,
        end=spec.end_m,
        position=position,
        yaw=yaw,
        size=(width, WINDOW_DEPTH_M, spec.height_m - spec.sill_m),
        seed=seed,
    )
