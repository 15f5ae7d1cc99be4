"""The steps between two keyframes that a robot can travel, and their lengths."""

import numpy as np
from jaxtyping import Float64, Int
from scipy.sparse import csr_array

from lexis.config import PlannerConfig
from lexis.graph.trusted_loops import is_trusted
from lexis.maths.ties import rounded
from lexis.planning.close_pairs import close_pairs
from lexis.planning.shortcuts import shortcuts
from lexis.types import LexisMap, LoopArrays, Pairs

GRID_M = 2.0**-20
"""The lengths of connections are rounded to multiples of this, about a micrometre [m]. It is a power of two, so that sums of
lengths are exact."""


def unwalked_steps(map: LexisMap, config: PlannerConfig) -> Pairs:
    """Return the pairs of keyframes that a robot can travel between although the camera need not have walked there.

    As in the paper, keyframes of the same room are connected; in addition, so are the two keyframes of each trusted loop
    edge, and two keyframes between which the images show free space (`lexis.planning.shortcuts`). A connection that the
    robot neither travelled itself nor saw to be free is at most `shortcut_m` long, because a longer one could lead through
    furniture or a wall.
    """
    positions = map.T_W_B[:, :3, 3]
    return np.concatenate([
        _pairs_within(_trusted_loops(map), positions, config.shortcut_m),
        _within_rooms(map, config.shortcut_m),
        shortcuts(map, config),
    ])  # fmt: skip


def as_graph(map: LexisMap, connections: Pairs) -> csr_array:
    """Return the lengths of connections as a symmetric sparse matrix (n, n) [m]; a connection may be given several times."""
    positions = map.T_W_B[:, :3, 3]
    connections = np.unique(np.sort(connections, axis=1), axis=0)
    # A length is at least one unit, because in a sparse graph, a zero means that there is no connection.
    lengths = GRID_M * np.maximum(np.rint(lengths_of(connections, positions) / GRID_M), 1.0)
    both = np.concatenate([connections, connections[:, ::-1]])
    return csr_array((np.tile(lengths, 2), (both[:, 0], both[:, 1])), shape=(len(positions), len(positions)))


def _within_rooms(map: LexisMap, shortcut_m: float) -> Pairs:
    room_of = map.room_of
    pairs = close_pairs(map, room_of >= 0, shortcut_m)
    return np.asarray(pairs[room_of[pairs[:, 0]] == room_of[pairs[:, 1]]])


def _trusted_loops(map: LexisMap) -> Pairs:
    loops = LoopArrays.of(map.loops)
    return np.asarray(np.column_stack((loops.query, loops.match))[is_trusted(map.loop_weights)])


def _pairs_within(pairs: Pairs, positions: Float64[np.ndarray, "n 3"], metres: float) -> Int[np.ndarray, "k 2"]:
    return np.asarray(pairs[rounded(lengths_of(pairs, positions)) <= metres])


def lengths_of(pairs: Pairs, positions: Float64[np.ndarray, "n 3"]) -> Float64[np.ndarray, "m"]:
    """Return the distances between pairs of positions [m]."""
    return np.asarray(np.linalg.norm(positions[pairs[:, 0]] - positions[pairs[:, 1]], axis=1))
