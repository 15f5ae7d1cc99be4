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
from lexis.floors import NO_FLOOR
from lexis.loop_arrays import LoopArrays
from lexis.map.room_names import find_rooms, instance_names
from lexis.maths.ties import settled
from lexis.types import LexisMap, RoomInstance

MAX_STEP_M = 3.0
"""Consecutive keyframes farther apart than this are a break in the record: nobody saw what lies between [m]."""
MIN_LOOP_WEIGHT = 0.5
"""Loop edges that the robust kernel trusts less join nothing."""
DOUBTFUL = 0.55
"""A room is doubtful whose evidence is less than this share of that of the clearest room of its label."""
GRID_M = 2.0**-20
"""Lengths are multiples of this power of two, about a micrometre, so that their sums are exact and equal ways tie [m]."""
LOOK_AHEAD_M = 1.5
"""An image tells of the place that is this far ahead of its camera, rather than of where the camera stands [m]."""
REACH_M = 2.0
"""An image counts for places up to this far from the one that it tells of, the farther the less [m]; it must exceed
`LOOK_AHEAD_M`, so that at least its own image counts for every keyframe."""
WEAK = 0.4
"""Where a room has less than this share of its greatest evidence, it is taken to end."""
MARGIN_M = 1.5
"""A path's end gains by its distance from where the room ends up to this one, which covers the errors of a robot [m]."""


@dataclass(frozen=True)
class Plan:
    """A path over the graph."""

    start: RoomInstance
    goal: RoomInstance
    keyframes: tuple[int, ...]
    """Ids from start to goal, both included. The outer ones may be keyframes of neighbouring rooms; see `innermost`."""
    length_m: float
    """Sum of the straight lines between them [m]."""


class Inside(NamedTuple):
    """The keyframe where a path to a room ends."""

    room: RoomInstance
    keyframe: int
    evidence: float
    """How much more the images that look at the keyframe's place resemble the room than any other."""


def plan(map: LexisMap, start: str, goal: str, config: PlannerConfig | None = None) -> Plan:
    """The shortest path between two rooms, named as instances ("office 2") or by label ("office").

    A label stands for all its instances; of these, the two that are nearest to each other by the length of the way are
    chosen. Doubtful instances stand for their label only where it has no other: most are a few misread keyframes in a room
    of another label. In a room the path begins or ends well inside (`innermost`).

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
    """Where a path to a room ends: in the midst of where images tell the room clearly; at the first of equal keyframes.

    It need not be one of the room's own keyframes, since a small room may be recognised from in front of it alone: those
    that stand where the room's images look count as well.
    """
    candidates = _candidates(map, room)
    evidence = _evidence(map, room, candidates)
    margins = _margins(map, room, candidates, WEAK * float(evidence.max()))
    best = int(np.argmax(settled(np.where(evidence > 0.0, evidence * margins, evidence))))
    return Inside(room, int(candidates[best]), float(evidence[best]))


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
    loops = LoopArrays.of(map.loops)
    return np.column_stack((loops.query, loops.match))[map.loop_weights >= MIN_LOOP_WEIGHT]


def _no_longer(
    pairs: Int[np.ndarray, "m 2"], positions: Float64[np.ndarray, "n 3"], metres: float
) -> Int[np.ndarray, "k 2"]:
    return np.asarray(pairs[_lengths(pairs, positions) <= metres])


def _lengths(pairs: Int[np.ndarray, "m 2"], positions: Float64[np.ndarray, "n 3"]) -> Float64[np.ndarray, "m"]:
    return np.asarray(np.linalg.norm(positions[pairs[:, 0]] - positions[pairs[:, 1]], axis=1))


def _candidates(map: LexisMap, room: RoomInstance) -> Int[np.ndarray, "k"]:
    """Ids of a room's keyframes, and of those that stand where its images look; ascending.

    Keyframes of other rooms of its label are left out: evidence does not tell rooms of one label apart.
    """
    own = list(room.keyframes)
    near = cKDTree(map.T_W_B[:, :3, 3]).query_ball_point(_looked_at(map)[own], REACH_M)
    twins = [k for other in map.rooms if other.label == room.label and other.id != room.id for k in other.keyframes]
    return np.setdiff1d(np.concatenate([own, *near]).astype(int), twins)


def _margins(map: LexisMap, room: RoomInstance, keyframes: Int[np.ndarray, "k"], weak: float) -> Float64[np.ndarray, "k"]:
    """Distances of some keyframes from the nearest one with evidence below `weak`, or on stairs; at most `MARGIN_M` [m].

    Keyframes on stairs are told by the climb, not by their images, which show the rooms at either end.
    """
    positions = map.T_W_B[:, :3, 3]
    near = cKDTree(positions).query_ball_point(positions[keyframes], MARGIN_M)
    around = np.unique(np.concatenate(near).astype(int))
    outside = _evidence(map, room, around) < weak
    if room.floor is not None:
        outside |= map.floors[around] == NO_FLOOR
    distances = cKDTree(positions[around[outside]]).query(positions[keyframes], distance_upper_bound=MARGIN_M)[0]
    return settled(np.minimum(distances, MARGIN_M))


def _evidence(map: LexisMap, room: RoomInstance, keyframes: Int[np.ndarray, "k"]) -> Float64[np.ndarray, "k"]:
    """How much more the places of some keyframes look like a room than like any other, settled: less towards its edge."""
    resemblance = _resemblance(map, map.T_W_B[keyframes, :3, 3])
    label = map.room_names.index(room.label)
    others = np.delete(resemblance, label, axis=1).max(axis=1, initial=-1.0)
    return settled(resemblance[:, label] - others)


def _resemblance(map: LexisMap, places: Float64[np.ndarray, "k 3"]) -> Float64[np.ndarray, "k rooms"]:
    """Similarity of places with every room prompt: the mean over the images that look there.

    Beyond the paper, which has an image tell of the place where it was taken. That is misleading where rooms are open to one
    another: in front of an open boundary the whole image shows the next room.
    """
    looked_at = _looked_at(map)
    seen_by = cKDTree(looked_at).query_ball_point(places, REACH_M, return_sorted=True)
    return np.array([
        np.average(map.similarities[near], axis=0, weights=_nearness(looked_at[near] - place))
        for place, near in zip(places, seen_by, strict=True)
    ])  # fmt: skip


def _looked_at(map: LexisMap) -> Float64[np.ndarray, "n 3"]:
    """The place that every keyframe's image tells of, as high as the keyframe, in W [m]."""
    places = map.T_W_B[:, :3, 3].copy()
    places[:, :2] += LOOK_AHEAD_M * (map.T_W_B[:, :3, :3] @ map.camera.T_B_C[:3, 2])[:, :2]
    return places


def _nearness(offsets: Float64[np.ndarray, "k 3"]) -> Float64[np.ndarray, "k"]:
    """From 1 at a place to 0 at `REACH_M` from it and farther away."""
    return np.asarray(np.maximum(1.0 - (offsets**2).sum(axis=1) / REACH_M**2, 0.0) ** 2)
