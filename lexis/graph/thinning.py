"""Thinning: which keyframes may retire from the optimisation, because earlier keyframes show their places.

A robot that works in one building for days passes the same places again and again. Without thinning, the graph and the time
per keyframe would grow with the hours; with it, they grow with the area, as in the reduced pose graph of Johannsson et al.
("Temporally scalable visual SLAM using a reduced pose graph", ICRA 2013). A keyframe that retires stays in the map, at a
fixed pose relative to one of the keyframes that show its place: its anchor.

Memory grows with the area, too, because a keyframe that retires gives up what is large:

- its features and landmarks, because it is no loop candidate any more. It takes the embeddings of its anchor;
- the loop edges, loop candidates and decisions that it got as a new keyframe. The first loop edge between two sessions
  stays, however, because it tells that both sessions share a frame. The graph remembers which steps the trusted ones
  bridged (`PoseGraph.bridged`).

It keeps its odometry, its pose and its stamp. Its label follows from the images of the keyframes that see its place, and
from those of its anchor.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from jaxtyping import Bool, Float64, Int

from lexis.maths.growing_array import GrowingArray
from lexis.maths.se3 import between, rotation_angle
from lexis.maths.ties import near_pairs, reaches, rounded
from lexis.types import NO_FEATURES, NO_LANDMARKS, CameraView, Keyframe, LoopEdge, Pose, Poses

STAYS = -1
"""Value in place of an anchor, for a keyframe that stays in the optimisation."""
SHOWN_M = 1.0
"""Largest distance between two keyframes that show the same place [m]."""
SHOWN_RAD = 0.5
"""Largest angle between two keyframes that show the same place [rad]."""
VISIT_M = 10.0
"""Least odometry path between two visits of a place [m]. Keyframes that are closer on the path belong to one visit; they are
needed although they show the same place."""
HELD_M = 5.0
"""Largest odometry path between two linked nodes over which the drift of the odometry is neglected [m]."""
FIT_M, FIT_RAD = 0.3, 0.1
"""An edge fits if its measured relative pose differs from that of the current poses by at most this [m, rad]."""

Ids = Int[np.ndarray, "k"]


class Retired:
    """Keyframes that have retired from the optimisation, and their poses relative to their anchors."""

    def __init__(self) -> None:
        """Begin without retired keyframes."""
        self._ids, self._anchors = GrowingArray((), np.int64), GrowingArray((), np.int64)
        self._T_anchor_B = GrowingArray((4, 4))

    @property
    def ids(self) -> Ids:
        """Ids of the retired keyframes, in the order in which they retired."""
        return self._ids.rows

    @property
    def anchors(self) -> Ids:
        """Ids of the keyframes to which the retired keyframes are anchored. No anchor has retired itself."""
        return self._anchors.rows

    @property
    def T_anchor_B(self) -> Poses:
        """Poses of the retired keyframes relative to their anchors."""
        return self._T_anchor_B.rows

    def add(self, id: int, anchor: int, T_anchor_B: Pose) -> None:
        """Add a keyframe that retires, at a pose relative to its anchor."""
        self._ids.append(id)
        self._anchors.append(anchor)
        self._T_anchor_B.append(T_anchor_B)

    def add_all(self, ids: Ids, anchors: Ids, T_W_B: Poses) -> dict[int, int]:
        """Add the keyframes `ids`, which retire now, and their `anchors`.

        If an anchor of other keyframes retires, these are anchored to its own anchor. Returns the new anchors by the ids of
        their keyframes. `T_W_B` are the current poses of all keyframes.
        """
        successor = dict(zip(ids.tolist(), anchors.tolist(), strict=True))
        rows = np.flatnonzero(np.isin(self.anchors, ids))
        if len(rows):
            followed = np.array([successor[anchor] for anchor in self.anchors[rows].tolist()], int)
            self._anchors.replace(rows, followed)
            self._T_anchor_B.replace(rows, between(T_W_B[followed], T_W_B[self.ids[rows]]))
        moved = dict(zip(self.ids[rows].tolist(), self.anchors[rows].tolist(), strict=True))
        for id, anchor in successor.items():
            self.add(id, anchor, between(T_W_B[anchor], T_W_B[id]))
        return moved | successor

    def follow(self, T_W_B: Poses) -> None:
        """Take the poses relative to the anchors from the poses `T_W_B` of all keyframes."""
        self._T_anchor_B.replace(np.arange(len(self.ids)), between(T_W_B[self.anchors], T_W_B[self.ids]))

    def following(self, first: int, T_W_B: Poses) -> tuple[Ids, Float64[np.ndarray, "k 4 4"]]:
        """Return the ids of the retired keyframes whose anchors have ids from `first` on, and their poses.

        The poses follow from the poses `T_W_B` of the anchors.
        """
        moved = self.anchors >= first
        return self.ids[moved], T_W_B[self.anchors[moved]] @ self.T_anchor_B[moved]


def as_retired(keyframe: Keyframe, anchor: Keyframe) -> Keyframe:
    """Return a keyframe as it is once it has retired: without features and landmarks, and with its anchor's embeddings."""
    return replace(
        keyframe,
        anchor=anchor.id,
        embedding=anchor.embedding,
        features=NO_FEATURES,
        landmarks=NO_LANDMARKS,
        others=tuple(CameraView(view.embedding, NO_FEATURES, NO_LANDMARKS) for view in anchor.others),
    )


def are_active(keyframes: Sequence[Keyframe]) -> Bool[np.ndarray, "n"]:
    """Return which keyframes have not retired."""
    return np.array([keyframe.anchor is None for keyframe in keyframes], bool)


def thinned_loops(loops: Sequence[LoopEdge], keyframes: Sequence[Keyframe]) -> list[LoopEdge]:
    """Return the loop edges without those from retired keyframes; the first edge between two sessions stays."""
    first: dict[tuple[int, int], LoopEdge] = {}
    for loop in loops:
        first.setdefault((keyframes[loop.query].session, keyframes[loop.match].session), loop)
    joining = {id(loop) for (query, match), loop in first.items() if query != match}
    return [loop for loop in loops if keyframes[loop.query].anchor is None or id(loop) in joining]


def anchors(
    T_W_B: Poses, path_m: Float64[np.ndarray, "n"], linked: Bool[np.ndarray, "n"], copies: int
) -> Int[np.ndarray, "n"]:
    """Return for each node of a graph the node that it is anchored to if it retires, or `STAYS` if it does not retire.

    1. A node is redundant if at least `copies` nodes of earlier visits show its place and stay.
    2. The part of the walk between two linked nodes is redundant if all nodes in it are, and if it is at most `HELD_M` long
       or has no nodes. Without loops nearby, nodes may only seem to be at these places, because of drift.
    3. All nodes in a redundant part retire, and a linked node retires if it is redundant and lies between two redundant
       parts. The linked nodes at the ends of other parts stay, because their loops hold these parts.
    4. The anchor of a node is the nearest node that shows the same place and stays.

    Args:
        T_W_B: poses of the nodes, in the order of the walk.
        path_m: length of the odometry path from the first keyframe to each node [m].
        linked: whether a loop edge that fits the poses connects the node to an earlier keyframe.
        copies: least number of nodes that have to show the place.
    """
    n = len(T_W_B)
    later, earlier, distance = _same_place(T_W_B, path_m)
    first = np.searchsorted(later, np.arange(n + 1))
    redundant, retires = np.zeros(n, bool), np.zeros(n, bool)
    end: int | None = None  # the linked node at which the current part begins
    inside = False  # whether the part before this node is redundant
    for node in range(n):
        redundant[node] = (~retires[earlier[first[node] : first[node + 1]]]).sum() >= copies
        if linked[node]:
            joined = end is not None and (end == node - 1 or path_m[node] - path_m[end] <= HELD_M)
            if end is not None and joined:
                retires[end + 1 : node] = True
                retires[end] = inside and redundant[end]
            end, inside = node, joined
        elif not redundant[node]:
            end = None
    return _nearest_staying(retires, later, earlier, distance)


def fits(T_match_query: Poses, measured: Poses, path_m: Float64[np.ndarray, "n"]) -> Bool[np.ndarray, "n"]:
    """Return which loop edges connect two visits and fit the current poses.

    Args:
        T_match_query: current relative poses of the keyframes that the edges connect.
        measured: relative poses that the edges measured.
        path_m: length of the odometry path between the two keyframes of each edge [m].
    """
    error = between(T_match_query, measured)
    near = rounded(np.linalg.norm(error[:, :3, 3], axis=1)) <= FIT_M
    return np.asarray(near & (rounded(rotation_angle(error)) <= FIT_RAD) & reaches(path_m, VISIT_M))


def _same_place(
    T_W_B: Poses, path_m: Float64[np.ndarray, "n"]
) -> tuple[Int[np.ndarray, "m"], Int[np.ndarray, "m"], Float64[np.ndarray, "m"]]:
    """Return pairs of nodes that show one place on two visits: the later nodes, the earlier nodes, and the distances [m].

    The pairs are sorted by the later node.
    """
    pairs = near_pairs(T_W_B[:, :3, 3], SHOWN_M)
    pairs = pairs[np.lexsort(pairs.T)]
    earlier, later = pairs[reaches(path_m[pairs[:, 1]] - path_m[pairs[:, 0]], VISIT_M)].T
    T_earlier_later = between(T_W_B[earlier], T_W_B[later])
    alike = rounded(rotation_angle(T_earlier_later)) <= SHOWN_RAD
    return later[alike], earlier[alike], np.linalg.norm(T_earlier_later[alike, :3, 3], axis=1)


def _nearest_staying(
    retires: Bool[np.ndarray, "n"],
    later: Int[np.ndarray, "m"],
    earlier: Int[np.ndarray, "m"],
    distance: Float64[np.ndarray, "m"],
) -> Int[np.ndarray, "n"]:
    """Return for each node that retires the nearest node at its place that stays; `STAYS` for all other nodes."""
    usable = retires[later] & ~retires[earlier]
    later, earlier, distance = later[usable], earlier[usable], distance[usable]
    order = np.lexsort((earlier, rounded(distance), later))
    nodes, nearest = np.unique(later[order], return_index=True)
    found = np.full(len(retires), STAYS)
    found[nodes] = earlier[order][nearest]
    return found
