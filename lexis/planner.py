"""Paths from room to room over the graph (paper, Sec. IV, planning application)."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from jaxtyping import Float64, Int
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import cKDTree

from lexis.config import PlannerConfig
from lexis.errors import PlanError
from lexis.room_names import find_rooms, instance_names
from lexis.ties import nearest_points, settled
from lexis.types import LexisMap, RoomInstance

MAX_STEP_M = 3.0
"""Consecutive keyframes farther apart than this are a break in the record: nobody saw what lies between [m]."""
MIN_LOOP_WEIGHT = 0.5
"""Loop edges that the robust kernel trusts less join nothing."""
DOUBTFUL = 0.5
"""A room is doubtful whose evidence is less than this share of that of the clearest room of its label."""
GRID_M = 2.0**-20
"""Lengths are multiples of this power of two, about a micrometre, so that their sums are exact and equal ways tie [m]."""
EVIDENCE_NEIGHBOURS = (5, 9)
"""Keyframes whose images tell together how deep inside its room a keyframe is: least, and most in rooms of as many."""


@dataclass(frozen=True)
class Plan:
    """A path over the graph."""

    start: RoomInstance
    goal: RoomInstance
    keyframes: tuple[int, ...]
    """Ids from start to goal, both included."""
    length_m: float
    """Sum of the straight lines between them [m]."""


class Inside(NamedTuple):
    """The keyframe that is most certainly inside a room."""

    room: RoomInstance
    keyframe: int
    evidence: float
    """How much more its images look like the room than like any other."""


def plan(map: LexisMap, start: str, goal: str, config: PlannerConfig | None = None) -> Plan:
    """The shortest path between two rooms, named as instances ("office 2") or by label ("office").

    A label stands for all its instances; of these, the two that are nearest to each other by the length of the way are
    chosen. Doubtful instances stand for their label only where it has no other: most are a few misread keyframes in a room
    of another label. In a room the path begins or ends where it is most certainly inside.

    Raises:
        PlanError: there is no such room in the map, or no way between the two.
    """
    starts, goals = _ends(map, start), _ends(map, goal)
    graph = adjacency(map, config or PlannerConfig())
    lengths = dijkstra(graph, indices=[end.keyframe for end in starts])[:, [end.keyframe for end in goals]]
    s, g = (int(i) for i in np.unravel_index(lengths.argmin(), lengths.shape))
    if not np.isfinite(lengths[s, g]):
        raise PlanError(f"no way from {start} to {goal}: the walk was interrupted between them; valid: rooms of one walk")
    keyframes = _path(graph, starts[s].keyframe, goals[g].keyframe)
    return Plan(starts[s].room, goals[g].room, keyframes, float(lengths[s, g]))


def innermost(map: LexisMap, room: RoomInstance) -> Inside:
    """Where in a room the images around a keyframe tell it from the others most clearly."""
    evidence = _evidence(map, room)
    keyframe = room.keyframes[int(evidence[list(room.keyframes)].argmax())]
    return Inside(room, keyframe, float(evidence[keyframe]))


def adjacency(map: LexisMap, config: PlannerConfig) -> csr_array:
    """Lengths [m] of the ways between keyframes that a robot may take.

    These are the paper's: consecutive keyframes, and keyframes of one room; and trusted loop edges. Where nobody walked, a
    way is no longer than `shortcut_m`, lest it cut through furniture or a wall.
    """
    positions = map.T_W_B[:, :3, 3]
    walked = np.stack([np.arange(len(positions) - 1), np.arange(1, len(positions))], axis=1)
    ways = np.concatenate([
        _no_longer(walked, positions, MAX_STEP_M),
        _no_longer(_trusted_loops(map), positions, config.shortcut_m),
        _within_rooms(map, positions, config.shortcut_m),
    ])  # fmt: skip
    ways = np.unique(np.sort(ways, axis=1), axis=0)
    # At least one step of the grid, since a sparse graph takes a zero for no way at all.
    lengths = GRID_M * np.maximum(np.rint(_lengths(ways, positions) / GRID_M), 1.0)
    both = np.concatenate([ways, ways[:, ::-1]])
    return csr_array((np.tile(lengths, 2), (both[:, 0], both[:, 1])), shape=(len(positions), len(positions)))


def _path(graph: csr_array, start: int, goal: int) -> tuple[int, ...]:
    """Keyframes of a shortest way; of several that are equally short, the same one there and back."""
    first, last = sorted((start, goal))
    before = dijkstra(graph, indices=[first], return_predecessors=True)[1][0]
    path = [last]
    while path[-1] != first:
        path.append(int(before[path[-1]]))
    return tuple(path if start == last else reversed(path))


def _ends(map: LexisMap, name: str) -> list[Inside]:
    """Where a path to or from the rooms of that name may end. Raises PlanError for an unknown one."""
    ends = [innermost(map, room) for room in find_rooms(map.rooms, name)]
    if not ends:
        raise PlanError(f"no room {name!r} in the map; valid: {', '.join(instance_names(map.rooms))}, or a label alone")
    clear = DOUBTFUL * max(end.evidence for end in ends)
    return [end for end in ends if end.evidence > 0.0 and end.evidence >= clear] or ends


def _within_rooms(map: LexisMap, positions: Float64[np.ndarray, "n 3"], shortcut_m: float) -> Int[np.ndarray, "m 2"]:
    room_of = map.room_of
    pairs = cKDTree(positions).query_pairs(shortcut_m, output_type="ndarray")
    return np.asarray(pairs[room_of[pairs[:, 0]] == room_of[pairs[:, 1]]])


def _trusted_loops(map: LexisMap) -> Int[np.ndarray, "m 2"]:
    pairs = np.array([(loop.query, loop.match) for loop in map.loops], int).reshape(-1, 2)
    return np.asarray(pairs[map.loop_weights >= MIN_LOOP_WEIGHT])


def _no_longer(
    pairs: Int[np.ndarray, "m 2"], positions: Float64[np.ndarray, "n 3"], metres: float
) -> Int[np.ndarray, "k 2"]:
    return np.asarray(pairs[_lengths(pairs, positions) <= metres])


def _lengths(pairs: Int[np.ndarray, "m 2"], positions: Float64[np.ndarray, "n 3"]) -> Float64[np.ndarray, "m"]:
    return np.asarray(np.linalg.norm(positions[pairs[:, 0]] - positions[pairs[:, 1]], axis=1))


def _evidence(map: LexisMap, room: RoomInstance) -> Float64[np.ndarray, "n"]:
    """How clearly the images around every keyframe tell the room from the others, settled: it fades towards the room's edge.

    The margin of the room's similarity over the best other one, averaged over the nearest keyframes, of any room; those of
    other rooms may speak against this one, not for it.
    """
    label = map.room_names.index(room.label)
    others = np.delete(map.similarities, label, axis=1).max(axis=1, initial=-1.0)
    margin = map.similarities[:, label] - others
    outside = map.room_of != room.id
    margin[outside] = np.minimum(margin[outside], 0.0)
    positions = map.T_W_B[:, :3, 3]
    count = min(int(np.clip(len(room.keyframes), *EVIDENCE_NEIGHBOURS)), len(positions))
    return settled(margin[nearest_points(positions, count)].mean(axis=1))
