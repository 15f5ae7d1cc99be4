"""Pairs of keyframes that are close together, between which a robot may be able to travel."""

import numpy as np
from jaxtyping import Bool, Int

from lexis.graph.thinning import STAYS
from lexis.maths.ties import near_pairs, rounded
from lexis.types import LexisMap


def close_pairs(map: LexisMap, among: Bool[np.ndarray, "n"], metres: float) -> Int[np.ndarray, "m 2"]:
    """Return the pairs of some keyframes of a map that are at most `metres` apart, when rounded.

    A keyframe that has retired is paired with its anchor alone. Retired keyframes lie where others lie, and their number
    grows with the time that the robot walks: the number of all close pairs would grow with the square of this time.
    """
    positions = map.T_W_B[:, :3, 3]
    anchors = np.array([STAYS if keyframe.anchor is None else keyframe.anchor for keyframe in map.keyframes])
    active, retired = np.flatnonzero(among & (anchors == STAYS)), np.flatnonzero(among & (anchors != STAYS))
    pairs = active[near_pairs(positions[active], metres)]
    retired = retired[among[anchors[retired]]]
    off_m = np.linalg.norm(positions[retired] - positions[anchors[retired]], axis=1)
    return np.concatenate([pairs, np.stack([anchors[retired], retired], axis=1)[rounded(off_m) <= metres]])
