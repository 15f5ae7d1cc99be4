"""The free space that each keyframe's camera looks into, and which keyframes stand in it.

The space between a camera and a landmark is free, and belongs to what the image shows. Landmarks lie on walls and furniture,
so this space ends at walls. It is represented by places, which are points. A keyframe within `near_m` of a place stands in
the space, even if a wall is between them.

1. Sample places on the way from the camera to each landmark, at the height of the camera (`space_in_view`). The last part of
   the way is left out, because a landmark may have been triangulated behind the wall on which it lies, and so is the part
   beyond `reach_m`, because what is farther away often belongs to another room of an open plan.
2. For each pair of keyframes, compute which share of the places of one keyframe lies near the other keyframe (`sight`).
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float64
from scipy.sparse import csr_array
from scipy.spatial import cKDTree

from lexis.config import SightConfig
from lexis.maths.se3 import inverse, transform
from lexis.maths.ties import MILLIONTH, rounded
from lexis.types import Camera, Keyframe, Pose, Poses

_VISIBLE_SHARE = 0.5
"""Share of the way from the camera to a landmark that counts as visible, because the landmark may have been triangulated
behind the wall on which it lies."""
_SHARES = np.array([0.0, 0.5, 1.0])
"""Places are sampled at these shares of the way from the camera to the end of the visible space."""
_CELL_M = 0.25
"""Width of the cells over which places are averaged, so that there are few of them [m]."""
OBSTACLE_RANGE_M = 3.0
"""Largest distance of an obstacle from the camera [m]; farther landmarks are not accurate enough for the width of a door."""
_BELOW_M, _ABOVE_M = 0.4, 0.6
"""Landmarks from `_BELOW_M` below the camera to `_ABOVE_M` above it are obstacles [m]: the camera would run into them. Low
furniture is no obstacle, because it does not divide rooms."""
_STEEP = 0.1
"""A camera counts as looking straight up or down if the cosine of its elevation is less than this."""


@dataclass(frozen=True, eq=False)
class VisibleSpace:
    """Places in the free space that one image shows, at the height of the camera."""

    places: Float64[np.ndarray, "k 3"]
    """Positions in the frame of the camera [m]."""
    weights: Float64[np.ndarray, "k"]
    """Share of the visible space that each place stands for; the shares add up to 1, unless there are no places."""
    obstacles: Float64[np.ndarray, "m 3"] = field(default_factory=lambda: np.zeros((0, 3)))
    """Positions of the landmarks at about the height of the camera, in the frame of the camera [m]."""


def spaces_in_view(keyframe: Keyframe, camera: Camera, config: SightConfig) -> tuple[VisibleSpace, ...]:
    """Sample the free space that each camera of a keyframe sees, in the order of the rig; see `space_in_view`."""
    return tuple(space_in_view(keyframe, each.T_B_C, config, number) for number, each in enumerate(camera.rig))


def space_in_view(keyframe: Keyframe, T_B_C: Pose, config: SightConfig, camera: int = 0) -> VisibleSpace:
    """Sample the free space between a camera of a keyframe and the landmarks that this camera saw.

    Landmarks farther away than `config.range_m` are left out, and so is the space more than `config.reach_m` away from the
    camera. Without landmarks in range, only the place of the camera is known to be free. For a keyframe that has retired,
    the result has no places: its space is left to the keyframes that show it.

    Args:
        keyframe: its landmarks are used, and the direction of gravity in its odometry pose.
        T_B_C: pose of the camera on the body.
        config: the range and the reach.
        camera: number of the camera in the rig, from 0.
    """
    if keyframe.anchor is not None:
        return VisibleSpace(np.zeros((0, 3)), np.zeros(0))
    rays = transform(inverse(T_B_C), keyframe.views[camera].landmarks.points)
    rays = rays[rounded(np.linalg.norm(rays, axis=1)) <= config.range_m]
    if not len(rays):
        return VisibleSpace(np.zeros((1, 3)), np.ones(1))
    up = T_B_C[:3, :3].T @ keyframe.T_O_B[2, :3]  # z of O points upwards
    axes = _horizontal(up)
    ways = rays @ axes.T
    lengths = np.maximum(np.linalg.norm(ways, axis=1), config.reach_m)
    ends = np.minimum(_VISIBLE_SHARE, config.reach_m / lengths)[:, None] * ways
    places = (_SHARES[:, None, None] * ends).reshape(-1, 2)
    # Places are rounded, because a place on the border of two cells must not change its cell with the last bit.
    cells = np.floor(rounded(places) / _CELL_M).astype(np.int64)
    cells -= cells.min(axis=0)
    cell = cells[:, 0] * (cells[:, 1].max() + 1) + cells[:, 1]
    count = np.bincount(cell)
    seen = np.flatnonzero(count)
    means = np.stack([np.bincount(cell, axis)[seen] for axis in places.T], axis=1) / count[seen, None]
    return VisibleSpace(means @ axes, count[seen] / len(places), _obstacles(rays, up))


def _obstacles(landmarks: Float64[np.ndarray, "k 3"], up: Float64[np.ndarray, "3"]) -> Float64[np.ndarray, "m 3"]:
    """Return the landmarks at about the height of the camera, from positions in the frame of the camera.

    `up` points upwards in that frame.
    """
    heights, distances = rounded(landmarks @ up), rounded(np.linalg.norm(landmarks, axis=1))
    return landmarks[(heights >= -_BELOW_M) & (heights <= _ABOVE_M) & (distances <= OBSTACLE_RANGE_M)]


def _horizontal(up: Float64[np.ndarray, "3"]) -> Float64[np.ndarray, "2 3"]:
    """Return two horizontal unit vectors in the frame of the camera, to its right and to its front, as rows.

    `up` points upwards in that frame. If the camera looks straight up or down, the direction from the bottom to the top of
    its image counts as the front.
    """
    seen = np.array([0.0, 0.0, 1.0])  # the optical axis
    front = seen - (seen @ up) * up
    if np.linalg.norm(front) < _STEEP:
        front = np.array([0.0, -1.0, 0.0]) + up[1] * up
    (x, y, z), (a, b, c) = (front / np.linalg.norm(front)).tolist(), up.tolist()
    right = [y * c - z * b, z * a - x * c, x * b - y * a]  # front × up; np.cross takes ten times as long
    return np.array([right, [x, y, z]])


def sight_of_cameras(
    spaces: Sequence[tuple[VisibleSpace, ...]], T_W_B: Poses, camera: Camera, near_m: float
) -> list[csr_array]:
    """Return for each camera of the rig by which keyframes the place of each keyframe is seen; see `sight`.

    Args:
        spaces: what `spaces_in_view` returns for each keyframe.
        T_W_B: poses of the keyframes.
        camera: the camera, with the others of its rig.
        near_m: a keyframe within this distance of a place stands in the space that the image shows [m].
    """
    by_camera = zip(*spaces, strict=True)
    return [sight(seen, T_W_B, each.T_B_C, near_m) for seen, each in zip(by_camera, camera.rig, strict=True)]


def sight(spaces: Sequence[VisibleSpace], T_W_B: Poses, T_B_C: Pose, near_m: float) -> csr_array:
    """Return by which keyframes the place of each keyframe is seen, as a sparse matrix (n, n).

    Entry (i, j): how well keyframe j sees the place of keyframe i, as the share of j's visible space within `near_m` [m] of
    camera i. It depends only on the relative poses of the keyframes, and not on the frame W.
    """
    T_W_C = T_W_B @ T_B_C
    viewer = np.repeat(np.arange(len(spaces)), [len(space.weights) for space in spaces])
    weights = np.concatenate([space.weights for space in spaces])
    local = np.concatenate([space.places for space in spaces])
    places = np.einsum("nij,nj->ni", T_W_C[viewer, :3, :3], local) + T_W_C[viewer, :3, 3]
    cameras = cKDTree(T_W_C[:, :3, 3])
    # The radius is a little larger, so that no neighbour is lost before the distances are rounded.
    near = cameras.sparse_distance_matrix(cKDTree(places), near_m + MILLIONTH, output_type="ndarray")
    near = near[rounded(near["v"]) <= near_m]
    seen, place = near["i"], near["j"]
    return csr_array((weights[place], (seen, viewer[place])), shape=(len(spaces), len(spaces)))
