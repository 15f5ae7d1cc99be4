"""`EstimateAgreement`: how well two estimates of one run agree, which needs no ground truth."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64, Int

from lexis.evaluation.partitions import overlap
from lexis.evaluation.relative import separation
from lexis.evaluation.rooms import adjusted_rand_index, each_alone
from lexis.evaluation.trajectory import align
from lexis.types import Poses
from sim.harness.estimate import Estimate

_AXIS_M = 1e-3
"""Length of the axes by which poses are aligned [m]."""


@dataclass(frozen=True)
class EstimateAgreement:
    """How well two estimates agree on the frames that both cover; None for a result that at least one of them lacks."""

    frames: float
    """Number of frames that both estimates cover, divided by the number of frames that at least one of them covers."""
    labels: float | None
    """Share of the common frames that have the same label in both estimates."""
    rooms: float | None
    """Adjusted Rand index of the two partitions of the common frames into rooms: 1 if equal, about 0 if unrelated. A frame
    in no room counts as a room of its own."""
    floors: float | None
    """Share of the common frames that have the same floor in both estimates."""
    loops: float | None
    """Number of loop closures that both estimates have, divided by the number that at least one of them has; 1 if both have
    none."""
    rotation_rad: float | None
    """Largest angle between the two orientations of a common frame, after the trajectories are aligned [rad]."""
    position_m: float | None
    """Largest distance between the two positions of a common frame, after the trajectories are aligned [m]."""


def agreement(first: Estimate, second: Estimate) -> EstimateAgreement:
    """Compare two estimates of one run. The frames of both are matched by `Observation.index`."""
    frames, rows_a, rows_b = np.intersect1d(first.frames, second.frames, return_indices=True)
    union = len(first.frames) + len(second.frames) - len(frames)
    largest = _largest_difference(first, second, rows_a, rows_b)
    return EstimateAgreement(
        frames=len(frames) / union,
        labels=_equal_share(first.labels, second.labels, rows_a, rows_b),
        rooms=_rand_index(first.rooms, second.rooms, rows_a, rows_b),
        floors=_equal_share(first.floors, second.floors, rows_a, rows_b),
        loops=_common_loops(first, second),
        rotation_rad=None if largest is None else largest[0],
        position_m=None if largest is None else largest[1],
    )


def _equal_share(
    first: Int[np.ndarray, "n"] | None, second: Int[np.ndarray, "m"] | None, rows_a: Int[np.ndarray, "k"],
    rows_b: Int[np.ndarray, "k"],
) -> float | None:  # fmt: skip
    if first is None or second is None or not len(rows_a):
        return None
    return float((first[rows_a] == second[rows_b]).mean())


def _rand_index(
    first: Int[np.ndarray, "n"] | None, second: Int[np.ndarray, "m"] | None, rows_a: Int[np.ndarray, "k"],
    rows_b: Int[np.ndarray, "k"],
) -> float | None:  # fmt: skip
    if first is None or second is None or not len(rows_a):
        return None
    return adjusted_rand_index(overlap(each_alone(first[rows_a]), each_alone(second[rows_b])))


def _common_loops(first: Estimate, second: Estimate) -> float | None:
    if first.loops is None or second.loops is None:
        return None
    a, b = (set(_loop_frames(estimate)) for estimate in (first, second))
    return len(a & b) / len(a | b) if a | b else 1.0


def _loop_frames(estimate: Estimate) -> list[tuple[int, int]]:
    """Return the pairs of frames that loop closures join, the earlier frame first."""
    loops = estimate.loops
    if loops is None:
        return []
    return list(zip(estimate.frames[loops.match].tolist(), estimate.frames[loops.query].tolist(), strict=True))


def _largest_difference(
    first: Estimate, second: Estimate, rows_a: Int[np.ndarray, "k"], rows_b: Int[np.ndarray, "k"]
) -> tuple[float, float] | None:
    """Return the largest angle [rad] and the largest distance [m] between the two poses of a frame, after alignment."""
    if first.T_W_B is None or second.T_W_B is None or not len(rows_a):
        return None
    a, b = np.asarray(first.T_W_B, float)[rows_a], np.asarray(second.T_W_B, float)[rows_b]
    moved, turned = separation(a, _aligned(b, a))
    return float(turned.max()), float(moved.max())


def _aligned(moving: Poses, fixed: Poses) -> Poses:
    """Move poses rigidly onto other poses, by their positions and the tips of their axes.

    Positions alone do not tell how far a straight path is rotated about itself. The axes are short (`_AXIS_M`), so that they
    decide only where positions do not.
    """
    return np.asarray(align(_tips(moving), _tips(fixed)) @ moving)


def _tips(poses: Poses) -> Float64[np.ndarray, "points 3"]:
    """Return the positions of poses, and the tips of their three axes."""
    origins = poses[:, :3, 3]
    return np.concatenate([origins, *(origins + _AXIS_M * poses[:, :3, axis] for axis in range(3))])
