"""Paths between rooms over the pose graph (paper, Sec. IV, planning application).

1. Choose the keyframe of each room where a path may begin or end (`path_end`), well away from the room's boundary.
2. Connect keyframes that a robot can travel between (`adjacency`): consecutive keyframes, keyframes of the same room, and
   the two keyframes of a loop edge.
3. Find the shortest path over this graph by Dijkstra's algorithm (`plan`).
"""

from collections.abc import Sequence
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
from lexis.maths.ties import rounded
from lexis.room_names import find_rooms, instance_names
from lexis.types import LexisMap, LoopArrays, RoomInstance

MAX_STEP_M = 3.0
"""Largest distance between consecutive keyframes that are connected [m]. A larger distance is a gap in the recording."""
MIN_LOOP_WEIGHT = 0.5
"""Smallest weight, by the robust kernel of the optimisation, of a loop edge that a path may follow."""
DOUBTFUL = 0.55
"""A room is doubtful if its evidence (see `path_end`) is not positive, or is less than this share of the largest evidence of
any room with the same label."""
GRID_M = 2.0**-20
"""The lengths of connections are rounded to multiples of this, about a micrometre [m]. It is a power of two, so that sums of
lengths are exact."""
LOOK_AHEAD_M = 1.5
"""Assumed distance from a camera to the place that its image shows [m]. The image describes that place, which is ahead of
the camera, rather than the camera's own place."""
REACH_M = 2.0
"""An image counts as evidence for a place if what the image shows is within this distance of the place [m]. The distance
must exceed `LOOK_AHEAD_M`, so that at the position of every keyframe at least the keyframe's own image counts."""
WEAK = 0.4
"""A place counts as outside a room if its evidence (see `path_end`) is less than this share of the largest evidence in the
room."""
MARGIN_M = 1.5
"""Sufficient distance between the end of a path and the boundary of the room [m]. A larger distance counts as no better."""


@dataclass(frozen=True)
class Plan:
    """A path over the pose graph."""

    start: RoomInstance
    goal: RoomInstance
    keyframes: tuple[int, ...]
    """Ids of the keyframes from start to goal. The first and the last may belong to neighbouring rooms; see `path_end`."""
    length_m: float
    """Sum of the straight-line distances between consecutive keyframes of the path [m]."""


class PathEnd(NamedTuple):
    """The keyframe where a path to a room ends."""

    room: RoomInstance
    keyframe: int
    evidence: float
    """Similarity of the keyframe's place to the room's name, minus the largest similarity to another room name. The
    similarity of a place is the weighted mean over the images that show the place."""


def plan(map: LexisMap, start: str, goal: str, config: PlannerConfig | None = None, avoid: Sequence[str] = ()) -> Plan:
    """Return the shortest path between two rooms, named as instances ("office 2") or by label ("office").

    A label stands for all its instances; of these, the start and the goal with the shortest path are chosen. Instances with
    little evidence (`DOUBTFUL`) are ignored unless the label has no other: most of them are a few mislabelled keyframes in a
    room of another label. The path begins and ends well inside the rooms (`path_end`).

    Args:
        map: the map.
        start: the room where the path begins.
        goal: the room where the path ends.
        config: the settings of the planner.
        avoid: rooms, named like start and goal, whose keyframes the path may not contain. A label stands for all its rooms.

    Raises:
        PlanError: the map lacks one of the rooms, the start or the goal is to be avoided, or no path connects them.
    """
    closed = _closed_keyframes(map, avoid)
    starts, goals = _open_ends(map, start, closed), _open_ends(map, goal, closed)
    graph = _without(adjacency(map, config or PlannerConfig()), closed)
    lengths = dijkstra(graph, indices=[end.keyframe for end in starts])[:, [end.keyframe for end in goals]]
    s, g = (int(i) for i in np.unravel_index(lengths.argmin(), lengths.shape))
    if not np.isfinite(lengths[s, g]):
        if len(closed):
            raise PlanError(f"no path from {start} to {goal} without {', '.join(avoid)}; valid: fewer rooms to avoid")
        raise PlanError(f"no path from {start} to {goal}: the walk was interrupted between them; valid: rooms of one walk")
    keyframes = _path(graph, starts[s].keyframe, goals[g].keyframe)
    return Plan(starts[s].room, goals[g].room, keyframes, float(lengths[s, g]))


def path_end(map: LexisMap, room: RoomInstance) -> PathEnd:
    """Choose the keyframe where a path to a room ends: with clear evidence of the room, and far from the room's boundary.

    1. Take as candidates the room's own keyframes and the keyframes near the places that the room's images show. The latter
       are needed because a small room may only be recognised by keyframes in front of it.
    2. Compute the evidence at each candidate: how much more the images of its place resemble this room than any other.
    3. Choose the candidate with the largest product of evidence and distance from the room's boundary; of equal products,
       the first. If no candidate has positive evidence, choose the candidate with the most evidence.
    """
    candidates = _candidates(map, room)
    evidence = _evidence(map, room, candidates)
    margins = _margins(map, room, candidates, WEAK * float(evidence.max()))
    best = int(np.argmax(rounded(np.where(evidence > 0.0, evidence * margins, evidence))))
    return PathEnd(room, int(candidates[best]), float(evidence[best]))


def adjacency(map: LexisMap, config: PlannerConfig) -> csr_array:
    """Return the lengths of direct connections between keyframes that a robot can travel [m], as a symmetric sparse matrix.

    As in the paper, consecutive keyframes and keyframes of the same room are connected; in addition, so are the two
    keyframes of each trusted loop edge. A connection that the robot did not travel itself is at most `shortcut_m` long,
    because a longer one could lead through furniture or a wall.
    """
    positions = map.T_W_B[:, :3, 3]
    sessions = np.array([keyframe.session for keyframe in map.keyframes])
    last = np.flatnonzero(sessions[:-1] == sessions[1:])
    walked = np.stack([last, last + 1], axis=1)
    connections = np.concatenate([
        _pairs_within(walked, positions, MAX_STEP_M),
        _pairs_within(_trusted_loops(map), positions, config.shortcut_m),
        _within_rooms(map, positions, config.shortcut_m),
    ])  # fmt: skip
    connections = np.unique(np.sort(connections, axis=1), axis=0)
    # A length is at least one unit, because in a sparse graph, a zero means that there is no connection.
    lengths = GRID_M * np.maximum(np.rint(_lengths(connections, positions) / GRID_M), 1.0)
    both = np.concatenate([connections, connections[:, ::-1]])
    return csr_array((np.tile(lengths, 2), (both[:, 0], both[:, 1])), shape=(len(positions), len(positions)))


def _path(graph: csr_array, start: int, goal: int) -> tuple[int, ...]:
    """Return the keyframes of a shortest path. Of several shortest paths, the choice is the same in both directions."""
    first, last = sorted((start, goal))
    before = dijkstra(graph, indices=[first], return_predecessors=True)[1][0]
    path = [last]
    while path[-1] != first:
        path.append(int(before[path[-1]]))
    return tuple(path if start == last else reversed(path))


def _ends(map: LexisMap, name: str) -> list[PathEnd]:
    """Return the path ends of all rooms named `name` that are not doubtful. Raises PlanError for an unknown name."""
    ends = [path_end(map, room) for room in _known_rooms(map, name)]
    clear = DOUBTFUL * max(end.evidence for end in ends)
    return [end for end in ends if end.evidence > 0.0 and end.evidence >= clear] or ends


def _open_ends(map: LexisMap, name: str, closed: Int[np.ndarray, "k"]) -> list[PathEnd]:
    """Return the path ends of `_ends` that are not among the closed keyframes.

    Raises PlanError if no path end is left, or for an unknown name.
    """
    ends = [end for end in _ends(map, name) if end.keyframe not in closed]
    if not ends:
        raise PlanError(
            f"the path would begin or end in {name!r}, where a room is to be avoided; valid: other rooms to avoid"
        )
    return ends


def _closed_keyframes(map: LexisMap, avoid: Sequence[str]) -> Int[np.ndarray, "k"]:
    """Return the ids of all keyframes of the rooms to avoid, ascending. Raises PlanError for an unknown name."""
    rooms = [room for name in avoid for room in _known_rooms(map, name)]
    return np.unique(np.array([keyframe for room in rooms for keyframe in room.keyframes], int))


def _without(graph: csr_array, closed: Int[np.ndarray, "k"]) -> csr_array:
    """Return the graph without the connections of the closed keyframes."""
    edges = graph.tocoo()
    kept = ~(np.isin(edges.row, closed) | np.isin(edges.col, closed))
    return csr_array((edges.data[kept], (edges.row[kept], edges.col[kept])), shape=graph.shape)


def _known_rooms(map: LexisMap, name: str) -> tuple[RoomInstance, ...]:
    """Return the rooms named `name`. Raises PlanError for an unknown name."""
    rooms = find_rooms(map.rooms, name)
    if not rooms:
        raise PlanError(f"no room {name!r} in the map; valid: {', '.join(instance_names(map.rooms))}, or a label alone")
    return rooms


def _within_rooms(map: LexisMap, positions: Float64[np.ndarray, "n 3"], shortcut_m: float) -> Int[np.ndarray, "m 2"]:
    room_of = map.room_of
    pairs = cKDTree(positions).query_pairs(shortcut_m, output_type="ndarray")
    return np.asarray(pairs[room_of[pairs[:, 0]] == room_of[pairs[:, 1]]])


def _trusted_loops(map: LexisMap) -> Int[np.ndarray, "m 2"]:
    loops = LoopArrays.of(map.loops)
    return np.column_stack((loops.query, loops.match))[map.loop_weights >= MIN_LOOP_WEIGHT]


def _pairs_within(
    pairs: Int[np.ndarray, "m 2"], positions: Float64[np.ndarray, "n 3"], metres: float
) -> Int[np.ndarray, "k 2"]:
    return np.asarray(pairs[_lengths(pairs, positions) <= metres])


def _lengths(pairs: Int[np.ndarray, "m 2"], positions: Float64[np.ndarray, "n 3"]) -> Float64[np.ndarray, "m"]:
    return np.asarray(np.linalg.norm(positions[pairs[:, 0]] - positions[pairs[:, 1]], axis=1))


def _candidates(map: LexisMap, room: RoomInstance) -> Int[np.ndarray, "k"]:
    """Return the ids of a room's keyframes, and of the keyframes near the places that the room's images show; ascending.

    Keyframes of other rooms with the same label are left out, because evidence cannot tell rooms of one label apart.
    """
    own = list(room.keyframes)
    near = cKDTree(map.T_W_B[:, :3, 3]).query_ball_point(_shown_places(map)[own], REACH_M)
    twins = [k for other in map.rooms if other.label == room.label and other.id != room.id for k in other.keyframes]
    return np.setdiff1d(np.concatenate([own, *near]).astype(int), twins)


def _margins(map: LexisMap, room: RoomInstance, keyframes: Int[np.ndarray, "k"], weak: float) -> Float64[np.ndarray, "k"]:
    """Return the distances of keyframes from the boundary of the room, at most `MARGIN_M` [m].

    The boundary is the nearest keyframe with evidence below `weak` or, for a room that is not stairs, the nearest keyframe
    on stairs. Keyframes on stairs count whatever their evidence, because their images show the rooms at either end.
    """
    positions = map.T_W_B[:, :3, 3]
    near = cKDTree(positions).query_ball_point(positions[keyframes], MARGIN_M)
    around = np.unique(np.concatenate(near).astype(int))
    outside = _evidence(map, room, around) < weak
    if room.floor is not None:
        outside |= map.floors[around] == NO_FLOOR
    distances = cKDTree(positions[around[outside]]).query(positions[keyframes], distance_upper_bound=MARGIN_M)[0]
    return rounded(np.minimum(distances, MARGIN_M))


def _evidence(map: LexisMap, room: RoomInstance, keyframes: Int[np.ndarray, "k"]) -> Float64[np.ndarray, "k"]:
    """Return the evidence that keyframes stand in a room, rounded. It decreases towards the room's boundary.

    Evidence is the similarity of the keyframe's place to the room's name, minus the largest similarity to another room name.
    """
    similarities = _similarities_at(map, map.T_W_B[keyframes, :3, 3])
    label = map.room_names.index(room.label)
    others = np.delete(similarities, label, axis=1).max(axis=1, initial=-1.0)
    return rounded(similarities[:, label] - others)


def _similarities_at(map: LexisMap, places: Float64[np.ndarray, "k 3"]) -> Float64[np.ndarray, "k rooms"]:
    """Return the similarity of places to every room name: the weighted mean over the images that show the place.

    In the paper, an image describes the place where it was taken. This is misleading where rooms are open to one another: in
    front of an open boundary, the whole image shows the next room.
    """
    shown = _shown_places(map)
    near_images = cKDTree(shown).query_ball_point(places, REACH_M, return_sorted=True)
    return np.array([
        np.average(map.similarities[near], axis=0, weights=_distance_weights(shown[near] - place))
        for place, near in zip(places, near_images, strict=True)
    ])  # fmt: skip


def _shown_places(map: LexisMap) -> Float64[np.ndarray, "n 3"]:
    """Return the place that every keyframe's image shows: ahead of the camera, at the keyframe's height, in W [m]."""
    places = map.T_W_B[:, :3, 3].copy()
    places[:, :2] += LOOK_AHEAD_M * (map.T_W_B[:, :3, :3] @ map.camera.T_B_C[:3, 2])[:, :2]
    return places


def _distance_weights(offsets: Float64[np.ndarray, "k 3"]) -> Float64[np.ndarray, "k"]:
    """Return weights of images by the distance of the place they show: 1 at distance 0, and 0 from `REACH_M` on."""
    return np.asarray(np.maximum(1.0 - (offsets**2).sum(axis=1) / REACH_M**2, 0.0) ** 2)
