"""Splits a room if its parts hardly see each other, for example two offices with a wall between them.

How well a keyframe sees another one is the share of its visible space that lies within `near_m` of the other one, even if a
wall is between them. Keyframes close to a wall therefore connect two rooms of one label. Inside a room, each part has sight
of the next one.

1. Find the bipartition of the room with the smallest normalised cut: the sight between the two parts, relative to all sight
   of either part (Shi and Malik, "Normalized Cuts and Image Segmentation", 2000).
2. Multiply the cut by the length of the room. In a corridor, sight reaches a few metres, whatever the length, so that the
   cut falls with the inverse of the length, and the product stays.
3. If the product is below `split_m`, the room is split. Go on with both parts.

Two rooms with a doorway between them, such as two corridors, see more of each other. Sight through a narrow passage
(`lexis.sight.passages`) therefore counts less in these steps. A passage may also be a narrow place between the furniture of
one room, whose parts then share their space. A room is thus split only if the cut of all sight between its parts, through
passages and elsewhere, is below `merge_cut`.
"""

import numpy as np
from jaxtyping import Bool, Float64
from scipy.sparse import csc_array, csr_array, diags_array, eye_array
from scipy.sparse.linalg import eigsh

from lexis.config import SightConfig
from lexis.graph.walked_steps import walked_pairs
from lexis.maths.ties import reaches, rounded
from lexis.types import PerKeyframe, Positions

_STEP = 0.2
"""Sight that two consecutive keyframes of a session have of each other in addition, because the robot went from one to the
other. There is none across a gap in the recording."""
_LEAST = 4
"""Least number of keyframes of a room that is split."""
_NONE = 1e-9
"""Sight that counts as none."""
_SHIFT = -1e-3
"""Eigenvalues are sought near this value, which is just below the smallest one, 0."""


def sight_between(seen_by: csr_array, positions: Positions, sessions: PerKeyframe) -> csr_array:
    """Return how strongly each pair of keyframes is tied by sight, as a symmetric matrix with an empty diagonal.

    Args:
        seen_by: the matrix that `lexis.sight.visible_space.sight` returns.
        positions: positions of the keyframes in W [m].
        sessions: session of every keyframe.
    """
    n, steps = seen_by.shape[0], walked_pairs(positions, sessions)
    both = seen_by + seen_by.T
    forward = csr_array((np.full(len(steps), _STEP), (steps[:, 0], steps[:, 1])), shape=(n, n))
    return csr_array(both - diags_array(both.diagonal()) + forward + forward.T)


def split_divided(
    rooms: PerKeyframe,
    divisible: Bool[np.ndarray, "n"],
    positions: Positions,
    tied: csr_array,
    past_passages: csr_array,
    config: SightConfig,
) -> PerKeyframe:
    """Split the rooms between whose parts there is hardly any sight; return the new number of the room of every keyframe.

    Args:
        rooms: number of the room of every keyframe.
        divisible: whether the room of each keyframe may be split.
        positions: positions of the keyframes in W [m].
        tied: the matrix that `sight_between` returns.
        past_passages: the same matrix, in which sight through narrow passages counts less.
        config: the limits `split_m` and `merge_cut`.
    """
    rooms = rooms.copy()
    waiting = np.unique(rooms[divisible]).tolist()
    while waiting:
        members = np.flatnonzero(rooms == waiting.pop())
        if len(members) < _LEAST:
            continue
        cut, part = _smallest_cut(csr_array(past_passages[members][:, members]))
        narrow = not reaches(cut * _length(positions[members]), config.split_m)
        if narrow and not reaches(_cut_between(csr_array(tied[members][:, members]), part), config.merge_cut):
            rooms[members[part]] = rooms.max() + 1
            waiting += np.unique(rooms[members]).tolist()
    return rooms


def _length(positions: Float64[np.ndarray, "k 3"]) -> float:
    """Return the length of a room [m].

    One end is the keyframe farthest from the first keyframe; the length is the distance from there to the farthest keyframe.
    """
    end = positions[rounded(np.linalg.norm(positions - positions[0], axis=1)).argmax()]
    return float(np.linalg.norm(positions - end, axis=1).max())


def normalised_cuts(sight: Float64[np.ndarray, "rooms rooms"]) -> Float64[np.ndarray, "rooms rooms"]:
    """Return the normalised cut of each pair of rooms, or of parts of a room.

    It is the sight between them divided by all sight of the first room, plus the same quotient for the second room. `sight`
    holds the sum of the ties between each two rooms, and inside each room on the diagonal.
    """
    share = sight / np.maximum(sight.sum(axis=1, keepdims=True), _NONE)
    return np.asarray(share + share.T)


def _cut_between(tied: csr_array, part: Bool[np.ndarray, "k"]) -> float:
    """Return the normalised cut between some nodes of a graph and the others."""
    sides = csr_array(np.stack([part, ~part]).astype(float))
    return float(normalised_cuts((sides @ tied @ sides.T).toarray())[0, 1])


def _smallest_cut(tied: csr_array) -> tuple[float, Bool[np.ndarray, "k"]]:
    """Return the smallest normalised cut of a graph that was found, and which nodes are in one of the two parts.

    The nodes are sorted by their entries in the second eigenvector of the normalised Laplacian, and all divisions of this
    order into two are compared.
    """
    scale = np.sqrt(np.maximum(tied.sum(axis=0), _NONE))
    laplacian = eye_array(len(scale)) - diags_array(1.0 / scale) @ tied @ diags_array(1.0 / scale)
    start = np.cos(np.arange(len(scale)))  # some vector, but always the same
    values, vectors = eigsh(csc_array(laplacian), k=2, sigma=_SHIFT, v0=start)
    vector = vectors[:, values.argmax()] / scale
    rank = np.argsort(np.argsort(rounded(vector), kind="stable"))
    edges = tied.tocoo()
    first, second = rank[edges.coords[0]], rank[edges.coords[1]]
    n, forward = len(rank), first < second
    ends = [np.bincount(nodes[forward], edges.data[forward], n) for nodes in (first, second)]
    cut, volume = np.cumsum(ends[0] - ends[1])[:-1], np.cumsum(np.bincount(rank, scale**2))
    normalised = cut / volume[:-1] + cut / (volume[-1] - volume[:-1])
    best = int(rounded(normalised).argmin())
    return float(normalised[best]), rank <= best
