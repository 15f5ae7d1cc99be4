"""`plan_tour`: a walk through every room of a house, up and down its stairs, and once more through the first storey.

The second lap goes the same way round as the first: a front camera recognises a place only from the direction that it
saw it from.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import cycle, pairwise, permutations

import numpy as np
from jaxtyping import Float64, Int
from scipy.sparse.csgraph import dijkstra

from sim.errors import SimError
from sim.motion import Motion, heading, resample, round_corners, timed
from worlds.house import House
from worlds.labels import STAIRS
from worlds.truth import room_at
from worlds.walkable import Walkable

_COMFORT_M = 0.35
"""A stop keeps this far from obstacles where the room allows, and twice this is as good as it gets."""
_AREA_PER_STOP_M2 = 7.0
_MAX_STOPS = 3
_STOP_SPACING_M = 1.2
_SCATTER_M = 0.25
"""The second lap passes its stops this near to those of the first, not through them."""
_GLANCE_EVERY_M = 4.0
_ROUNDED = 0.92
"""Share of a way's length that is left when its corners are cut."""


@dataclass(frozen=True)
class TourConfig:
    """How the tour is walked. Raises `SimError` for values that no walk can have."""

    frame_rate_hz: float = 10.0
    speed_m_s: float = 0.7
    turn_rate_rad_s: float = 1.2
    """Largest."""
    eye_height_m: float = 1.4
    """Of the body frame above the walked surface."""
    glance_rad: float = 0.3
    """How far the view turns to either side of the way, about once in 4 m, in rooms."""
    prefer_clearance_m: float = 0.6
    """Kept from obstacles where there is room."""
    length_m: float | None = None
    """Wished length [m]: the second lap is cut short or repeated to meet it, the first is always whole. None: two laps."""

    def __post_init__(self) -> None:
        for name in ("frame_rate_hz", "speed_m_s", "turn_rate_rad_s", "eye_height_m"):
            if not 0.0 < (value := getattr(self, name)) < np.inf:
                raise SimError(f"tour: {name} is {value}; valid: positive and finite")
        if self.length_m is not None and not 0.0 < self.length_m < np.inf:
            raise SimError(f"tour: length_m is {self.length_m}; valid: positive and finite, or None")


@dataclass(frozen=True, eq=False)
class Tour:
    """A walk: the motion, and its poses at frame rate."""

    stamps: Float64[np.ndarray, "n"]
    """[s]"""
    T_W_B: Float64[np.ndarray, "n 4 4"]
    """Body frame: x forward, z up, level, at eye height."""
    motion: Motion
    eye_height_m: float

    @property
    def length_m(self) -> float:
        """Length of the walked path [m]."""
        return float(np.linalg.norm(np.diff(self.motion.positions, axis=0), axis=1).sum())

    def pose_at(self, t: float) -> Float64[np.ndarray, "4 4"]:
        """The body's pose `T_W_B` at any time of the tour, exact; the ends' poses before and after [s]."""
        return np.squeeze(self.motion.poses_at(np.array([float(t)]), self.eye_height_m), axis=0)


def plan_tour(house: House, walkable: Walkable, rng: np.random.Generator, config: TourConfig | None = None) -> Tour:
    """Plan a collision-free tour that ends where it began. Raises `SimError` where there is no room for it."""
    config = config or TourConfig()
    stops = _Stops.of(house, walkable)
    first_lap, base = _first_lap(house, stops, rng)
    again = _second_lap(stops, first_lap, base, config.length_m)
    nodes = [*stops.nodes[first_lap].tolist(), *(_scatter(walkable, int(stops.nodes[stop]), rng) for stop in again)]
    points = resample(round_corners(_way(walkable, [*nodes, nodes[0]], config.prefer_clearance_m), walkable))
    yaw = heading(points) + _glances(house, points, config.glance_rad)
    motion = timed(points, yaw, config.speed_m_s, config.turn_rate_rad_s)
    stamps = np.arange(0.0, motion.duration_s, 1.0 / config.frame_rate_hz)
    return Tour(stamps, motion.poses_at(stamps, config.eye_height_m), motion, config.eye_height_m)


@dataclass(frozen=True, eq=False)
class _Stops:
    """Places to visit, numbered from 0."""

    nodes: Int[np.ndarray, "m"]
    """Of the walkable graph."""
    between: Float64[np.ndarray, "m m"]
    """Walking distances [m]."""
    of_room: dict[str, list[int]]
    """Stops of each room, the most central first."""

    @staticmethod
    def of(house: House, walkable: Walkable) -> "_Stops":
        reachable = set(walkable.reachable_rooms())
        nodes: list[int] = []
        of_room = {}
        for room in house.rooms:
            if room.label != STAIRS and room.id in reachable:
                own = _stops_in(walkable, room.id)
                of_room[room.id] = list(range(len(nodes), len(nodes) + len(own)))
                nodes += own
        if len(nodes) < 2:
            raise SimError(
                f"house {house.spec.name!r}: a body of radius {walkable.radius_m:g} m can stop at {len(nodes)} places "
                "in it; a tour needs two at least"
            )
        return _Stops(np.array(nodes), dijkstra(walkable.graph, indices=nodes)[:, nodes], of_room)


def _stops_in(walkable: Walkable, room: str) -> list[int]:
    """Free places of a room that together show it: the most central first, then each far from those before it."""
    inside = walkable.nodes_in(room)
    inside = inside[walkable.connected[inside]]
    count = min(_MAX_STOPS, 2 + round(len(inside) * walkable.resolution_m**2 / _AREA_PER_STOP_M2))
    clearance = walkable.clearance[inside]
    inside = inside[roomy := clearance >= min(_COMFORT_M, 0.8 * clearance.max())]
    points, comfort = walkable.nodes[inside, :2], np.minimum(clearance[roomy], 2 * _COMFORT_M)
    chosen = [int(np.argmax(comfort - np.linalg.norm(points - points.mean(axis=0), axis=1)))]
    nearest = np.linalg.norm(points - points[chosen[0]], axis=1)
    while len(chosen) < count and nearest.max() > _STOP_SPACING_M:
        chosen.append(int(np.argmax(nearest + comfort)))
        nearest = np.minimum(nearest, np.linalg.norm(points - points[chosen[-1]], axis=1))
    return [int(inside[k]) for k in chosen]


def _first_lap(house: House, stops: _Stops, rng: np.random.Generator) -> tuple[list[int], list[int]]:
    """Stops through all storeys from the lowest up, and those of them that are on the lowest."""
    rooms_on: dict[int, list[str]] = {}
    for room in house.rooms:
        if room.id in stops.of_room:
            rooms_on.setdefault(room.storey, []).append(room.id)
    lap: list[int] = []
    base = 0
    for level in sorted(rooms_on):
        rooms = rooms_on[level]
        if not lap:
            rooms = list(np.roll(rooms, -int(rng.integers(len(rooms)))))
        lap += _around(stops, rooms, lap[-1] if lap else None)
        base = base or len(lap)
    return lap, lap[:base]


def _around(stops: _Stops, rooms: Sequence[str], here: int | None) -> list[int]:
    """All stops of some rooms in a short order, from `here` or else from the first room's first stop, towards the start."""
    room_of = {stops.of_room[room][0]: room for room in rooms}
    start = next(iter(room_of)) if here is None else here
    centres = _short_cycle(stops.between, start, [c for c in room_of if c != start])
    route: list[int] = []
    if here is None:
        centres = [start, *centres]
    for centre, towards in pairwise([*centres, start]):
        route += _through(stops.between, stops.of_room[room_of[centre]], route[-1] if route else start, towards)
    return route


def _through(between: Float64[np.ndarray, "m m"], own: Sequence[int], entry: int, towards: int) -> list[int]:
    """The order of a room's few stops that makes the way from `entry` through it shortest."""
    orders = [list(order) for order in permutations(own) if entry not in own or order[0] == entry]
    length = [float(between[[entry, *order], [*order, towards]].sum()) for order in orders]
    return orders[int(np.argmin(length))]


def _short_cycle(between: Float64[np.ndarray, "m m"], start: int, others: Sequence[int]) -> list[int]:
    """A short order of `others` on a round trip from `start`: nearest neighbour, then 2-opt."""
    left, order = list(others), [start]
    while left:
        order.append(min(left, key=lambda stop: between[order[-1], stop]))
        left.remove(order[-1])
    improved = True
    while improved:
        improved = False
        for i in range(1, len(order) - 1):
            for j in range(i + 1, len(order)):
                a, b, c, d = order[i - 1], order[i], order[j], order[(j + 1) % len(order)]
                if between[a, c] + between[b, d] < between[a, b] + between[c, d] - 1e-9:
                    order[i : j + 1] = order[i : j + 1][::-1]
                    improved = True
    return order[1:]


def _second_lap(stops: _Stops, first_lap: Sequence[int], base: Sequence[int], length_m: float | None) -> list[int]:
    """The stops to visit again, in the same order: all of the lowest storey, or as many as the wished length allows."""
    if length_m is None or len(base) == 1:
        return list(base)
    again: list[int] = []
    left = length_m / _ROUNDED - float(stops.between[first_lap[:-1], first_lap[1:]].sum())
    here = first_lap[-1]
    for stop in cycle(base):
        left -= float(stops.between[here, stop])
        if left < stops.between[stop, base[0]]:
            break
        again.append(stop)
        here = stop
    return again


def _scatter(walkable: Walkable, node: int, rng: np.random.Generator) -> int:
    """A place near a node from which the body can go straight to it."""
    near = walkable.nodes_near(walkable.nodes[node], _SCATTER_M)
    centre = np.broadcast_to(walkable.nodes[node], (len(near), 3))
    return int(rng.choice(near[walkable.solids.clear(centre, walkable.nodes[near], walkable.radius_m)]))


def _way(walkable: Walkable, nodes: Sequence[int], prefer_clearance_m: float) -> Float64[np.ndarray, "k 3"]:
    return np.concatenate([walkable.path(a, b, prefer_clearance_m) for a, b in pairwise(nodes) if a != b])


def _glances(house: House, points: Float64[np.ndarray, "k 3"], amplitude_rad: float) -> Float64[np.ndarray, "k"]:
    """Look to one side and the other on the way through each room, ahead where it is entered and left."""
    room = room_at(house, points)
    s = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1)))
    bounds = [0, *(np.flatnonzero(np.diff(room)) + 1), len(room) - 1]
    offset = np.zeros(len(points))
    for i, j in pairwise(bounds):
        times = round((s[j] - s[i]) / _GLANCE_EVERY_M)
        if times > 0 and room[i] >= 0 and house.rooms[room[i]].label != STAIRS:
            offset[i:j] = amplitude_rad * np.sin(2 * np.pi * times * (s[i:j] - s[i]) / (s[j] - s[i]))
    return offset
