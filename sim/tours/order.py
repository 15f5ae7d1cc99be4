"""Orders the stops of a tour so that a lap is short. If the lap has to be shorter, stops are left out or moved."""

from collections import Counter
from collections.abc import Mapping, Sequence
from itertools import pairwise, permutations

import numpy as np
from jaxtyping import Float64
from scipy.sparse.csgraph import dijkstra

from sim.tours.stops import Stops, comfortable
from worlds.house import House
from worlds.walkable import Walkable


def first_lap(house: House, stops: Stops, rng: np.random.Generator) -> tuple[list[int], list[int]]:
    """Order all stops for a short lap, storey by storey, from the lowest storey to the highest.

    Returns the numbers of all stops in this order, and the numbers of the stops on the lowest storey.
    """
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


def thinned(stops: Stops, lap: Sequence[int], most_m: float, there_and_back: bool = False) -> list[int]:
    """Drop the stops that cost most length, until the lap with the path back to its start is no longer than `most_m` [m].

    Each room keeps at least one stop, so the result may be longer than `most_m`.
    """
    room_of = {stop: room for room, own in stops.of_room.items() for stop in own}
    left, per_room = list(lap), Counter(room_of[stop] for stop in lap)
    while walked(stops, left, there_and_back) > most_m:
        spare = {k: _saving(stops.between, left, k) for k, stop in enumerate(left) if per_room[room_of[stop]] > 1 and k > 0}
        if not spare:
            break
        dropped = left.pop(max(spare, key=lambda k: spare[k]))
        per_room[room_of[dropped]] -= 1
    return left


def walked(stops: Stops, lap: Sequence[int], there_and_back: bool) -> float:
    """Return the total length of a lap with the way back to its start [m].

    The way back is the same path if `there_and_back`, and else the direct path from the last stop.
    """
    return 2 * stops.length(lap) if there_and_back else stops.length([*lap, lap[0]])


def shortened_by_moving_stops(house: House, walkable: Walkable, stops: Stops, lap: Sequence[int]) -> tuple[Stops, list[int]]:
    """Keep one stop per room, and move each stop to the place in its room at which the lap becomes shortest.

    The best place of a stop depends on the stops before and after it. Therefore, only every second stop moves while the
    others stay, then the others move, and then the first half moves again. If the number of stops is odd, the first and the
    last one are neighbours on the lap, and move at the same time. Returns the moved stops and the lap through them.
    """
    lap = thinned(stops, lap, 0.0)
    room_of = {stop: room for room, own in stops.of_room.items() for stop in own}
    places = [comfortable(walkable, house.room_by_id[room_of[stop]]) for stop in lap]
    nodes = stops.nodes[lap]
    for turn in (0, 1, 0):
        away = dijkstra(walkable.graph, indices=nodes)
        for k in range(turn, len(lap), 2):
            detour = away[k - 1, places[k]] + away[(k + 1) % len(lap), places[k]]
            nodes[k] = places[k][np.argmin(detour)]
    of_room = {room_of[stop]: [k] for k, stop in enumerate(lap)}
    return Stops(nodes, dijkstra(walkable.graph, indices=nodes)[:, nodes], of_room), list(range(len(lap)))


def _saving(between: Float64[np.ndarray, "m m"], lap: Sequence[int], k: int) -> float:
    before, here, after = lap[k - 1], lap[k], lap[(k + 1) % len(lap)]
    return float(between[before, here] + between[here, after] - between[before, after])


def short_cycle(between: Float64[np.ndarray, "m m"], start: int, others: Sequence[int]) -> list[int]:
    """Return `others` in the order of a short round trip from `start`, by nearest neighbours and 2-opt improvement."""
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


def _around(stops: Stops, rooms: Sequence[str], here: int | None) -> list[int]:
    """Order all stops of rooms for a short round trip from the stop `here`.

    If `here` is None, the trip starts at the first stop of the first room.
    """
    room_of: Mapping[int, str] = {stops.of_room[room][0]: room for room in rooms}
    start = next(iter(room_of)) if here is None else here
    centres = short_cycle(stops.between, start, [c for c in room_of if c != start])
    route: list[int] = []
    if here is None:
        centres = [start, *centres]
    for centre, towards in pairwise([*centres, start]):
        route += _through(stops.between, stops.of_room[room_of[centre]], route[-1] if route else start, towards)
    return route


def _through(between: Float64[np.ndarray, "m m"], own: Sequence[int], entry: int, towards: int) -> list[int]:
    """Order the stops `own` of a room so that the path from the stop `entry` through all stops to `towards` is shortest.

    All orders are tried, because a room has only a few stops. If `entry` is one of these stops, it comes first.
    """
    orders = [list(order) for order in permutations(own) if entry not in own or order[0] == entry]
    length = [float(between[[entry, *order], [*order, towards]].sum()) for order in orders]
    return orders[int(np.argmin(length))]
