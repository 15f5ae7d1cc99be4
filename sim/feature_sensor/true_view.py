"""`TrueView`: the ground truth of what one camera of a keyframe sees, and the covisibility of two views."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from jaxtyping import Float32, Float64, Int

from lexis.maths.se3 import inverse
from lexis.maths.ties import rounded
from lexis.types import Camera, Pose, Poses
from sim.feature_sensor.ray_origins import RayGrid
from sim.feature_sensor.surroundings import Surroundings
from sim.feature_sensor.visible_shares import COLUMNS, ROWS, VisibleShares
from worlds.truth import NOWHERE

_DEPTH_SHARE, _DEPTH_M = 0.15, 0.05
"""Two depths count as depths of the same point if they differ by at most this share of the depth plus this length [m]. These
bounds are generous, because the grid of rays is coarse."""


@dataclass(frozen=True, eq=False)
class RayImage:
    """What the rays of one camera hit, as the camera sees it: depths, looks and rooms.

    The camera is taken to be upright, so that the points of a camera that looks down by 20 degrees are up to 6 % off.
    """

    depth: Float32[np.ndarray, "columns rows"]
    """Depth of each ray [m]; infinite for a ray that hits nothing."""
    thing: Int[np.ndarray, "columns rows"]
    """What each ray hits, as an index into the things of `around`; `NOWHERE` if nothing."""
    grid: RayGrid
    """Image positions of the rays, in the order of `depth`."""
    around: Surroundings

    @cached_property
    def looks(self) -> Int[np.ndarray, "rays"]:
        """What the things that the rays hit look like; see `Surroundings.looks`."""
        return np.where(self.thing == NOWHERE, NOWHERE, self.around.looks[self.thing]).reshape(-1)

    @cached_property
    def rooms(self) -> Int[np.ndarray, "rays"]:
        """The rooms of the things that the rays hit, as indices into `House.rooms`."""
        return np.where(self.thing == NOWHERE, NOWHERE, self.around.room[self.thing]).reshape(-1)

    @cached_property
    def points(self) -> Float64[np.ndarray, "3 rays"]:
        """End points of the rays in the frame of the camera [m]; NaN for a ray that hits nothing."""
        z = np.where(np.isfinite(self.depth) & (self.depth > 0.0), self.depth, np.nan).astype(float)
        return np.stack([self.grid.x[:, None] * z, self.grid.y[None] * z, z]).reshape(3, -1)


@dataclass(frozen=True, eq=False)
class TrueView:
    """Ground truth of what one camera of a keyframe sees, and of where it stands.

    For a further camera of a rig, the pose of the body is the pose at which the first camera would look in the direction of
    this camera.
    """

    T_W_B: Pose
    T_W_C: Pose
    image: RayImage
    room: int
    """Index into `House.rooms` of the room of the camera; `NOWHERE` outside of all rooms."""
    is_moved: bool = False
    """Whether the camera and all that it sees are imagined at another place."""

    def moved(self, offset: Float64[np.ndarray, "3"]) -> "TrueView":
        """Return what the camera would see if the house were moved by an offset in W [m]."""
        T = np.eye(4)
        T[:3, 3] = offset
        return replace(self, T_W_B=T @ self.T_W_B, T_W_C=T @ self.T_W_C, is_moved=True)

    @cached_property
    def T_C_W(self) -> Pose:
        """The inverse of `T_W_C`."""
        return np.asarray(inverse(self.T_W_C))


def mistaken_by(match: TrueView, query: TrueView) -> Float64[np.ndarray, "3"] | None:
    """Return by how much the query is misplaced if its room is mistaken for another room near the match, in W [m].

    Of the rooms with the same label, the one that brings the query nearest to the match is taken. The result is None if both
    are in one room, or if no other room brings the query nearer than it is.
    """
    if match.room == query.room:
        return None
    apart, offsets = query.T_W_B[:3, 3] - match.T_W_B[:3, 3], query.image.around.offsets(query.room)
    distances = rounded(np.linalg.norm(np.concatenate([[apart], apart + offsets]), axis=1))
    nearest = int(distances.argmin())
    return offsets[nearest - 1] if nearest else None


def true_views(seen: VisibleShares, T_W_B: Poses, camera: Camera, as_first: Poses | None = None) -> list[TrueView]:
    """Return the ground truth of the views of a camera from body poses, given what the camera sees from there.

    For a further camera of a rig, `as_first` are the poses of the body at which the first camera would look in the same
    directions.
    """
    grid, T_W_C = RayGrid.of(camera.intrinsics, COLUMNS, ROWS), T_W_B @ camera.T_B_C
    bodies, hits = T_W_B if as_first is None else as_first, seen.hits
    images = [RayImage(*hit, grid, seen.around) for hit in zip(hits.depth, hits.thing.astype(np.int16), strict=True)]
    return [TrueView(*row) for row in zip(bodies, T_W_C, images, hits.rooms.tolist(), strict=True)]


def covisibilities(firsts: Sequence[TrueView], seconds: Sequence[TrueView]) -> Float64[np.ndarray, "pairs"]:
    """Return the covisibility of pairs of views, in [0, 1]: firsts[i] with seconds[i].

    It is the geometric mean of two shares: of the second view in the first view, and of the first in the second.
    """
    shared = _seen_by(firsts, seconds)
    overlap = np.flatnonzero(shared)  # pairs without overlap in this direction have covisibility 0
    if len(overlap):
        back = _seen_by([seconds[i] for i in overlap.tolist()], [firsts[i] for i in overlap.tolist()])
        shared[overlap] = np.sqrt(shared[overlap] * back)
    return shared


def _seen_by(viewers: Sequence[TrueView], others: Sequence[TrueView]) -> Float64[np.ndarray, "pairs"]:
    """Return, for each pair, the share of the rays of `others[i]` whose end points are also visible in `viewers[i]`.

    A point is visible if the viewer's ray in its direction has the same depth, and hits something that looks the same. If no
    view is moved, both things must also belong to one room, because the two faces of a wall are no common surface. All views
    have the same grid of rays.
    """
    T = np.stack([view.T_C_W for view in viewers]) @ np.stack([view.T_W_C for view in others])
    points = T[:, :3, :3] @ np.stack([view.image.points for view in others]) + T[:, :3, 3:]
    depths, grid = np.stack([view.image.depth.reshape(-1) for view in viewers]), viewers[0].image.grid
    depth, rays = points[:, 2].reshape(-1), points.shape[2]
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):  # NaN for rays that hit nothing
        column = _nearest(points[:, 0] / points[:, 2], grid.x).reshape(-1)
        row = _nearest(points[:, 1] / points[:, 2], grid.y).reshape(-1)
        inside = (column >= 0) & (column < len(grid.x)) & (row >= 0) & (row < len(grid.y))
        inside &= depth > _DEPTH_M  # leaves out points behind the camera
    point = np.flatnonzero(inside)  # one integer array selects faster than a boolean array
    pair, depth = point // rays, depth[point]
    ray = (column[point] * len(grid.y) + row[point]).astype(int)
    meets = np.flatnonzero(np.abs(depths[pair, ray] - depth) <= _DEPTH_SHARE * depth + _DEPTH_M)
    pair, ray, own = pair[meets], ray[meets], point[meets] % rays
    moved = np.array([viewer.is_moved or other.is_moved for viewer, other in zip(viewers, others, strict=True)])
    looks, own_looks = (np.stack([view.image.looks for view in views]) for views in (viewers, others))
    rooms, own_rooms = (np.stack([view.image.rooms for view in views]) for views in (viewers, others))
    same = looks[pair, ray] == own_looks[pair, own]
    same &= moved[pair] | (rooms[pair, ray] == own_rooms[pair, own])
    return np.asarray(np.bincount(pair[same], minlength=len(points)) / rays)


def _nearest(values: Float64[np.ndarray, "n k"], axis: Float32[np.ndarray, "m"]) -> Float64[np.ndarray, "n k"]:
    """Return the number of the grid line nearest to each value, counted from 0, as if the grid had no ends; NaN for NaN."""
    return np.asarray(np.rint((values - axis[0]) / (axis[1] - axis[0])))
