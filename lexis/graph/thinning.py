"""Thinning: which keyframes may retire from the optimisation, because earlier keyframes show their places.

A robot that works in one building for days passes the same places again and again. Without thinning, the graph and the time
per keyframe would grow with the hours; with it, they grow with the area, as in the reduced pose graph of Johannsson et al.
("Temporally scalable visual SLAM using a reduced pose graph", ICRA 2013). A keyframe that retires stays in the map, at a
fixed pose relative to one of the keyframes that show its place: its anchor.
"""

from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Bool, Float64, Int
from scipy.spatial import cKDTree

from lexis.maths.se3 import between, rotation_angle
from lexis.maths.ties import reaches, rounded
from lexis.types import Poses

STAYS = -1
"""Value in place of an anchor, for a keyframe that stays in the optimisation."""
PLACE_M = 1.0
"""Largest distance between two keyframes that show the same place [m]."""
PLACE_RAD = 0.5
"""Largest angle between two keyframes that show the same place [rad]."""
VISIT_M = 10.0
"""Least odometry path between two visits of a place [m]. Keyframes that are closer on the path belong to one visit; they are
needed although they show the same place."""

Pairs = Int[np.ndarray, "m 2"]
Ids = Int[np.ndarray, "k"]


@dataclass(frozen=True, eq=False)
class Retired:
    """Keyframes that have retired from the optimisation, and their poses relative to their anchors."""

    ids: Int[np.ndarray, "r"] = field(default_factory=lambda: np.zeros(0, int))
    anchors: Int[np.ndarray, "r"] = field(default_factory=lambda: np.zeros(0, int))
    """Ids of the keyframes to which the retired keyframes are anchored. No anchor has retired itself."""
    T_anchor_B: Poses = field(default_factory=lambda: np.zeros((0, 4, 4)))

    def joined_by(self, ids: Ids, anchors: Ids, T_W_B: Poses) -> "Retired":
        """Return these retired keyframes together with the keyframes `ids`, which retire now, and their `anchors`.

        A keyframe that was anchored to one of `ids` is now anchored to the anchor of the latter. `T_W_B` are the current
        poses of all keyframes.
        """
        successor = dict(zip(ids.tolist(), anchors.tolist(), strict=True))
        kept = np.array([successor.get(anchor, anchor) for anchor in self.anchors.tolist()], int)
        all_ids, all_anchors = np.concatenate([self.ids, ids]), np.concatenate([kept, anchors])
        return Retired(all_ids, all_anchors, between(T_W_B[all_anchors], T_W_B[all_ids]))

    def following(self, first: int, T_W_B: Poses) -> tuple[Ids, Poses]:
        """Return the ids of the retired keyframes whose anchors have ids from `first` on, and their poses.

        The poses follow from the poses `T_W_B` of the anchors.
        """
        moved = self.anchors >= first
        return self.ids[moved], T_W_B[self.anchors[moved]] @ self.T_anchor_B[moved]


def anchors(T_W_B: Poses, path_m: Float64[np.ndarray, "n"], loops: Pairs, copies: int) -> Int[np.ndarray, "n"]:
    """Return for each node of a graph the node that it is anchored to if it retires, or `STAYS` if it does not retire.

    1. A node is redundant if at least `copies` nodes of earlier visits show its place and stay, and a loop edge connects it
       to an earlier node that shows its place. Without a loop, a node may only seem to be at the place, because of drift.
    2. A redundant node retires if its neighbours on the path are redundant, too. The ends of a redundant stretch stay,
       because their loops hold the parts of the walk at its ends.
    3. The anchor of a node is the nearest node that shows the same place and stays.

    Args:
        T_W_B: poses of the nodes, in the order of the walk.
        path_m: length of the odometry path from the first keyframe to each node [m].
        loops: pairs of the later and the earlier node of each loop edge.
        copies: least number of nodes that have to show the place.
    """
    n = len(T_W_B)
    later, earlier, distance = _same_place(T_W_B, path_m)
    linked = np.bincount(later[np.isin(later * n + earlier, loops @ [n, 1])], minlength=n) > 0
    first = np.searchsorted(later, np.arange(n + 1))
    redundant, retires = np.zeros(n, bool), np.zeros(n, bool)
    for node in np.flatnonzero(linked & (np.diff(first) >= copies)).tolist():
        copies_that_stay = ~retires[earlier[first[node] : first[node + 1]]]
        redundant[node] = copies_that_stay.sum() >= copies
        if node >= 2 and redundant[node - 2 : node + 1].all():
            retires[node - 1] = True
    return _nearest_staying(retires, later, earlier, distance)


def _same_place(
    T_W_B: Poses, path_m: Float64[np.ndarray, "n"]
) -> tuple[Int[np.ndarray, "m"], Int[np.ndarray, "m"], Float64[np.ndarray, "m"]]:
    """Return pairs of nodes that show one place on two visits: the later nodes, the earlier nodes, and the distances [m].

    The pairs are sorted by the later node.
    """
    pairs = np.sort(cKDTree(T_W_B[:, :3, 3]).query_pairs(PLACE_M, output_type="ndarray"), axis=1)
    pairs = pairs[np.lexsort(pairs.T)]
    earlier, later = pairs[reaches(path_m[pairs[:, 1]] - path_m[pairs[:, 0]], VISIT_M)].T
    T_earlier_later = between(T_W_B[earlier], T_W_B[later])
    alike = rounded(rotation_angle(T_earlier_later)) <= PLACE_RAD
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
