"""A fisheye camera, composed of several pinhole images.

MuJoCo renders pinhole images only, and their field of view has to be well below 180 degrees. A frame is made in two steps:

1. Imagine a cube around the camera. Render a pinhole image of each face of the cube that is in the field of view.
2. For each pixel of the fisheye image, find the face through which the pixel's ray passes, and look up the pixel there.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from jaxtyping import Bool, Float32, Float64, Int32

from lexis.types import Intrinsics, Pose
from sim.errors import SimError
from sim.render.raster import NO_GEOM, Raster, RenderedFrame

_RIM_PX = 2
"""Width of a border around the 90 degrees of each face [px], so that bilinear interpolation needs one face's image only."""
_FACES = np.array(
    [
        [[1, 0, 0], [0, 1, 0], [0, 0, 1]],  # ahead
        [[0, 0, -1], [0, 1, 0], [1, 0, 0]],  # left
        [[0, 0, 1], [0, 1, 0], [-1, 0, 0]],  # right
        [[1, 0, 0], [0, 0, -1], [0, 1, 0]],  # up
        [[1, 0, 0], [0, 0, 1], [0, -1, 0]],  # down
    ],
    float,
)
"""Rotation from the fisheye's frame to each face's frame. The third row of a matrix is the optical axis of the face."""
_NO_FACE = -1
"""Index of the face for pixels outside of the field of view, which no face shows."""


@dataclass(frozen=True, eq=False)
class Fisheye:
    """A fisheye camera with equidistant projection: a ray at angle θ to the axis is imaged at distance f θ from the centre.

    Its image is square. Raises `SimError` if the field of view is not in (0, 250] degrees or the image is smaller than 8 px.
    """

    size_px: int
    fov_deg: float
    """Angle that the image covers from its left edge to its right edge, through its centre [deg]."""
    T_B_C: Pose

    def __post_init__(self) -> None:
        """Check the size and the field of view."""
        if self.size_px < 8 or not 0.0 < self.fov_deg <= 250.0:
            raise SimError(
                f"fisheye: {self.size_px} px and {self.fov_deg} degrees; valid: 8 px or more, above 0 and up to 250 degrees"
            )

    @property
    def focal_px(self) -> float:
        """Focal length f [px/rad]."""
        return float(self.size_px / np.radians(self.fov_deg))

    @property
    def face(self) -> Intrinsics:
        """Intrinsics of the pinhole image of each cube face. Its centre is resolved as well as the fisheye's centre."""
        focal = self.focal_px
        size = 2 * int(np.ceil(focal) + _RIM_PX)
        return Intrinsics(size, size, focal, focal, size / 2 - 0.5, size / 2 - 0.5)

    def rays(self) -> tuple[Float64[np.ndarray, "n n 3"], Bool[np.ndarray, "n n"]]:
        """Return the unit ray of each pixel in the camera's frame, and a mask of the pixels in the field of view."""
        v, u = np.mgrid[: self.size_px, : self.size_px] - (self.size_px - 1) / 2
        radius = np.hypot(u, v)
        angle = radius / self.focal_px
        sine = np.sin(angle) / np.maximum(radius, 1e-12)
        return np.stack([sine * u, sine * v, np.cos(angle)], axis=-1), angle <= np.radians(self.fov_deg) / 2


class FisheyeRenderer:
    """Renders the images of a fisheye camera, from one pinhole image for each cube face that is in view."""

    def __init__(self, raster: Raster, fisheye: Fisheye) -> None:
        self._raster, self._fisheye, self._face = raster, fisheye, fisheye.face
        rays, valid = fisheye.rays()
        along = np.einsum("fij,hwj->fhwi", _FACES, rays)
        face = np.where(valid, np.argmax(along[..., 2], axis=0), _NO_FACE)
        self._maps = [_Map.of(along[i], face == i, self._face) for i in range(len(_FACES)) if (face == i).any()]
        self._turns = [_FACES[i] for i in range(len(_FACES)) if (face == i).any()]

    def frame(self, T_W_B: Pose) -> RenderedFrame:
        """Render image, depth and geom ids from a body pose. `depth` is the distance along each pixel's ray [m].

        Pixels outside of the field of view are black, with the distance 0 and the id `NO_GEOM`. The inverse of the depth is
        interpolated between four pixels. It is linear in a pinhole image of a plane, so distances are exact on planes. Where
        the four pixels belong to several geoms, the pixel that is closest in the image gives the distance instead.
        """
        n, T_W_C = self._fisheye.size_px, T_W_B @ self._fisheye.T_B_C
        rgb, depth, ids = np.zeros((n, n, 3), np.uint8), np.zeros((n, n), np.float32), np.full((n, n), NO_GEOM, np.int32)
        for turn, face_map in zip(self._turns, self._maps, strict=True):
            T_C_F = np.eye(4)
            T_C_F[:3, :3] = turn.T
            seen, mask = self._raster.frame(T_W_C @ T_C_F, self._face), face_map.mask
            rgb[mask] = cv2.remap(seen.rgb, face_map.u, face_map.v, cv2.INTER_LINEAR)[mask]
            depth[mask], ids[mask] = face_map.distances(seen), face_map.nearest(seen.geom_ids)
        return RenderedFrame(rgb, depth, ids)


@dataclass(frozen=True, eq=False)
class _Map:
    """Coordinates (u, v) [px] of fisheye pixels in the image of one cube face. `mask` marks the pixels on this face."""

    mask: Bool[np.ndarray, "n n"]
    u: Float32[np.ndarray, "n n"]
    v: Float32[np.ndarray, "n n"]
    stretch: Float64[np.ndarray, "k"]
    """For each pixel in `mask`, the ratio of the distance along the pixel's ray to the depth in the face's image."""

    @staticmethod
    def of(rays: Float64[np.ndarray, "n n 3"], mask: Bool[np.ndarray, "n n"], face: Intrinsics) -> "_Map":
        depth = np.where(mask, rays[..., 2], 1.0)
        u, v = (face.fx * rays[..., i] / depth + c for i, c in ((0, face.cx), (1, face.cy)))
        inside = [np.where(mask, place, 0.0).astype(np.float32) for place in (u, v)]
        return _Map(mask, inside[0], inside[1], 1.0 / rays[..., 2][mask])

    def nearest(self, image: Int32[np.ndarray, "h w"]) -> Int32[np.ndarray, "k"]:
        return np.asarray(image[np.rint(self.v[self.mask]).astype(int), np.rint(self.u[self.mask]).astype(int)])

    def distances(self, seen: RenderedFrame) -> Float64[np.ndarray, "k"]:
        u, v = self.u[self.mask].astype(float), self.v[self.mask].astype(float)
        i, j = np.floor(v).astype(int), np.floor(u).astype(int)
        a, b = v - i, u - j
        corners = [(i, j, (1 - a) * (1 - b)), (i, j + 1, (1 - a) * b), (i + 1, j, a * (1 - b)), (i + 1, j + 1, a * b)]
        inverse = sum(weight / seen.depth[row, column] for row, column, weight in corners)
        nearest = self.nearest(seen.geom_ids)
        same = np.all([seen.geom_ids[row, column] == nearest for row, column, _ in corners], axis=0)
        depth = np.where(same, 1.0 / inverse, seen.depth[np.rint(v).astype(int), np.rint(u).astype(int)])
        return np.asarray(depth * self.stretch)
