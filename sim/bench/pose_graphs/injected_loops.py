"""False loop edges that a benchmark adds to a finished map: random, local, and grouped in consistent clusters.

The kinds follow Sünderhauf and Protzel (2012). Each false loop states that two keyframes are at the same place, as if a SLAM
had confused two places that look alike. Its covariance is copied from a confirmed loop.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from types import MappingProxyType

import numpy as np
from jaxtyping import Int

from lexis.maths.se3 import between, exp, inverse
from lexis.types import Covariance, LoopEdge, Poses

LOCAL_M = (1.0, 3.0)
"""Range of the true distances between the two keyframes of a local false loop [m]."""
GROUP = 6
"""Largest number of false loops in a cluster. They connect consecutive keyframes of one place to consecutive keyframes of
another place."""
_GAP = 20
"""Least difference between the numbers of the two keyframes of a false loop."""
_OFFSET = np.repeat([0.1, 0.3], 3) * [0.1, 0.1, 1, 1, 1, 0.1]
"""Standard deviations of the relative pose that a false loop states: three rotations [rad], then three translations [m].
Tilt deviates less than yaw, and height less than x and y, because the camera stays upright."""
_FURTHEST_M = 3.0
"""Keyframes farther apart than this are at different places [m]."""

Pairs = Int[np.ndarray, "k 2"]


def injected(kind: str, count: int, true: Poses, like: Sequence[LoopEdge], rng: np.random.Generator) -> list[LoopEdge]:
    """Return `count` false loops of one of `KINDS`, or none if no pair of keyframes fits or there are no confirmed loops.

    Args:
        kind: the name of the kind.
        count: number of false loops.
        true: true poses of the keyframes.
        like: confirmed loops, whose covariances the false loops state.
        rng: the random generator.
    """
    pairs = _distant(true) if kind != "local" else _near(true)
    if not len(pairs) or not like:
        return []
    found: list[LoopEdge] = []
    while len(found) < count:
        match, query = pairs[rng.integers(len(pairs))].tolist()
        covariance = like[int(rng.integers(len(like)))].covariance
        found += KINDS[kind](match, query, true, covariance, rng)
    return found[:count]


def _distant(true: Poses) -> Pairs:
    return _pairs(true, _FURTHEST_M, np.inf)


def _near(true: Poses) -> Pairs:
    return _pairs(true, *LOCAL_M)


def _pairs(true: Poses, nearest_m: float, furthest_m: float) -> Pairs:
    """Return pairs (match, query) of keyframes whose true distance is within a range [m]; the query is much later."""
    match, query = np.triu_indices(len(true), _GAP)
    distances = np.linalg.norm(true[match, :3, 3] - true[query, :3, 3], axis=1)
    fits = (distances >= nearest_m) & (distances < furthest_m)
    return np.column_stack([match[fits], query[fits]])


def _single(match: int, query: int, true: Poses, covariance: Covariance, rng: np.random.Generator) -> Iterator[LoopEdge]:
    """Yield one loop, which states a small random relative pose."""
    yield LoopEdge(query, match, exp(rng.normal(size=6) * _OFFSET), covariance, 0)


def _cluster(match: int, query: int, true: Poses, covariance: Covariance, rng: np.random.Generator) -> Iterator[LoopEdge]:
    """Yield loops of consecutive keyframes that agree with each other, as if the robot confused two rooms."""
    moved = true[match] @ exp(rng.normal(size=6) * _OFFSET) @ inverse(true[query])  # moves one room onto the other
    for k in range(min(GROUP, len(true) - query)):
        noise = exp(rng.multivariate_normal(np.zeros(6), covariance))
        stated = between(true[match + k], moved @ true[query + k]) @ noise
        yield LoopEdge(query + k, match + k, stated, covariance, 0)


KINDS: Mapping[str, Callable[..., Iterator[LoopEdge]]] = MappingProxyType(
    {"random": _single, "local": _single, "grouped": _cluster}
)
"""Functions that make false loops from a pair of keyframes, by the name of the kind of loops."""
