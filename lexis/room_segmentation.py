"""Room instances and floors, found by clustering labelled keyframes (paper, Sec. III-C)."""

import math
from collections import defaultdict
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Int
from scipy.spatial import cKDTree

from lexis.config import LabelConfig, SegmentationConfig
from lexis.floors import NO_FLOOR, assign_floors
from lexis.graph.walked_steps import walked_pairs
from lexis.maths.groups import groups_of
from lexis.maths.ties import DECIMALS, near_pairs
from lexis.room_names import same_name
from lexis.types import PerKeyframe, Positions, RoomInstance

Clustering = Callable[[PerKeyframe, PerKeyframe, Positions], tuple[PerKeyframe, PerKeyframe]]
"""A function that groups keyframes, given their labels, floors and positions. It returns the number of every keyframe's
group, and the labels of the keyframes, which it may correct."""


@dataclass(frozen=True, eq=False)
class Segmentation:
    """The partition of the keyframes into rooms and floors."""

    rooms: tuple[RoomInstance, ...]
    """Room instances, ordered by their first keyframe; `rooms[i].id == i`."""
    floors: PerKeyframe
    """Floor number of every keyframe: 0 for the lowest floor, -1 on stairs and in a moving lift."""
    labels: PerKeyframe
    """Label of every keyframe, as an index into the room names; all keyframes of a room have one label."""


def segment(
    labels: PerKeyframe,
    positions: Positions,
    room_names: tuple[str, ...],
    config: SegmentationConfig,
    cluster: Clustering | None = None,
    sessions: PerKeyframe | None = None,
    stairs_name: str = LabelConfig.stairs_name,
) -> Segmentation:
    """Group labelled keyframes into room instances and floors.

    1. Find the floors: stairs, rides in a lift and ramps divide the walk into level stretches.
    2. Cluster the keyframes in order: each joins the nearest cluster of its label and floor whose running mean is within
       `distance_m`, or starts a new cluster.
    3. Merge clusters of one label and floor, because a large room has several clusters. Two clusters merge if they contain
       consecutive keyframes of one session without a gap between them, or keyframes within `adjacency_m` of each other with
       no other room in between.

    Beyond the paper, no room spans several floors; only a staircase is one room over all floors that it joins.

    Args:
        labels: index of every keyframe into `room_names`.
        positions: positions of the keyframes in W, in the order of the walk [m].
        room_names: the vocabulary.
        config: the two distances.
        cluster: how keyframes are grouped, in place of steps 2 and 3; None: as the paper does.
        sessions: the sessions of the keyframes; None: they are all of one.
        stairs_name: the room name of stairs, as in `LabelConfig`.
    """
    sessions = np.zeros(len(labels), int) if sessions is None else sessions
    stairs = np.array([same_name(name, stairs_name) for name in room_names])[labels]
    floors = assign_floors(stairs, positions, sessions)
    if cluster is None:
        groups = _by_distance(labels, floors, stairs, positions, sessions, config)
    else:
        groups, labels = cluster(labels, floors, positions)
    instance_of = _by_first_appearance(groups)
    return Segmentation(_rooms(instance_of, labels, floors, positions, room_names), floors, labels)


def _by_distance(
    labels: PerKeyframe,
    floors: PerKeyframe,
    stairs: Bool[np.ndarray, "n"],
    positions: Positions,
    sessions: PerKeyframe,
    config: SegmentationConfig,
) -> PerKeyframe:
    kinds = np.unique(np.stack([labels, floors], axis=1), axis=0, return_inverse=True)[1].reshape(-1)
    # The flights of a staircase lie above one another. They form one cluster because their heights are left out.
    stairs_flattened = np.where(stairs[:, None], positions * [1.0, 1.0, 0.0], positions)
    clusters = _cluster(kinds, stairs_flattened, config.distance_m)
    return _merge(clusters, kinds, positions, sessions, config.adjacency_m)


@dataclass
class _Cluster:
    """A cluster while keyframes are added to it: its id, its running mean [m], and the number of its keyframes."""

    id: int
    mean: tuple[float, ...]
    count: int = 1

    def add(self, position: tuple[float, ...]) -> None:
        """Add a keyframe to the cluster and update the mean position."""
        self.count += 1
        self.mean = tuple(mean + (value - mean) / self.count for mean, value in zip(self.mean, position, strict=True))


def _cluster(kinds: PerKeyframe, positions: Positions, distance_m: float) -> PerKeyframe:
    """Return the id of the cluster of every keyframe, found in one pass over the walk. A kind is a pair of label and floor.

    Each kind has few clusters; therefore, the distances are computed with Python floats, which is several times faster than
    with arrays.
    """
    growing: defaultdict[int, list[_Cluster]] = defaultdict(list)
    ids = []
    for i, (kind, position) in enumerate(zip(kinds.tolist(), map(tuple, positions.tolist()), strict=True)):
        distances = [round(math.dist(cluster.mean, position), DECIMALS) for cluster in growing[kind]]
        nearest = min(distances, default=math.inf)
        if nearest <= distance_m:
            joined = growing[kind][distances.index(nearest)]
            joined.add(position)
        else:
            joined = _Cluster(i, position)
            growing[kind].append(joined)
        ids.append(joined.id)
    return np.array(ids, int)


def _merge(
    clusters: PerKeyframe, kinds: PerKeyframe, positions: Positions, sessions: PerKeyframe, adjacency_m: float
) -> PerKeyframe:
    """Merge adjacent clusters of one kind (label and floor); return the id of the merged cluster of every keyframe.

    No room lies between consecutive keyframes of one session, because the robot went from one to the other, unless there is
    a gap in the recording (`walked_pairs`).
    """
    n = len(clusters)
    if n == 0:
        return clusters
    walked = walked_pairs(positions, sessions)
    walked = walked[kinds[walked[:, 0]] == kinds[walked[:, 1]]]
    pairs = np.concatenate([walked, _adjacent(clusters, kinds, positions, adjacency_m)])
    own = np.stack([np.arange(n), clusters], axis=1)
    return groups_of(np.concatenate([pairs, own]), n)


def _adjacent(clusters: PerKeyframe, kinds: PerKeyframe, positions: Positions, adjacency_m: float) -> Int[np.ndarray, "m 2"]:
    """Return pairs of keyframes of one kind but two clusters, within `adjacency_m`, if no other kind lies between them.

    A kind lies between two keyframes if one of its keyframes is inside the ball that has the two as a diameter.
    """
    tree, pairs = cKDTree(positions), near_pairs(positions, adjacency_m)
    first, second = pairs.T
    pairs = pairs[(kinds[first] == kinds[second]) & (clusters[first] != clusters[second])]
    ends = positions[pairs]
    radii = np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1) / 2
    between = tree.query_ball_point(ends.mean(axis=1), radii * (1 - 1e-9))
    free = [bool((kinds[inside] == kinds[i]).all()) for inside, i in zip(between, pairs[:, 0], strict=True)]
    return np.asarray(pairs[np.array(free, bool)])


def _by_first_appearance(ids: PerKeyframe) -> PerKeyframe:
    """Return the same partition, with ids from 0 in the order of their first members."""
    _, first, inverse = np.unique(ids, return_index=True, return_inverse=True)
    return np.asarray(np.argsort(np.argsort(first))[inverse])


def _rooms(
    instance_of: PerKeyframe, labels: PerKeyframe, floors: PerKeyframe, positions: Positions, room_names: tuple[str, ...]
) -> tuple[RoomInstance, ...]:
    rooms = []
    for room in range(int(instance_of.max(initial=-1)) + 1):
        members = np.flatnonzero(instance_of == room)
        label, floor = room_names[labels[members[0]]], int(floors[members[0]])
        mean = positions[members].mean(axis=0)
        rooms.append(RoomInstance(room, label, tuple(members.tolist()), mean, None if floor == NO_FLOOR else floor))
    return tuple(rooms)
