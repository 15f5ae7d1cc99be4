"""`VisibleShares`: the share of the image that each thing of a house fills, and depths, both computed by ray casts."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float32, Float64, Int

from lexis.types import Camera, Poses
from sim.feature_sensor.ray_origins import RayGrid
from sim.feature_sensor.rays import Hits, cast
from sim.feature_sensor.surroundings import KINDS, Surroundings
from worlds.labels import ROOM_LABELS
from worlds.truth import NOWHERE
from worlds.visuals.surfaces import SURFACE_KINDS

COLUMNS, ROWS = 40, 30
"""Number of columns and of rows of rays per image. An object that fills 1 % of the image is hit by a dozen rays."""
LABEL_WEIGHT = 0.05
"""Factor on the entries for room labels in the description of a view. It is small, so that a ridge regression prefers the
entries that describe visible things."""
_NEAR_M = 2.5
"""Largest depth of near things [m]; near things are mostly in the same room as the camera."""
_DEPTHS_M = (0.5, 1.0, 2.0, 4.0, 8.0)
"""Depths [m]. For each depth, the description of a view holds the share of rays that hit something nearer."""
_COLOUR_WEIGHT = 2.0
"""Factor on the colours in the description of a view. Without this factor, the colours are in [0, 1]."""
_LEAST_SHARE = 0.02
"""The colour of a surface counts in full if the surface fills at least this share of the image. For smaller surfaces, the
colour is scaled down in proportion to the share."""
LABELS = slice(2 * len(KINDS), 2 * len(KINDS) + len(ROOM_LABELS))
"""Slice of a view's description vector: the entries that hold the shares of the image by room label."""
SIZE = LABELS.stop + 3 * len(SURFACE_KINDS) + len(_DEPTHS_M) + 1
"""Length of the description vector of a view, the input of the embedding model."""


@dataclass(frozen=True, eq=False)
class VisibleShares:
    """Visible contents of images: the share of the image that each thing (surface or object) fills, and the rays' hits."""

    around: Surroundings
    hits: Hits
    shares: Float32[np.ndarray, "n things"]
    """Share of each image that each thing fills, in [0, 1]. Sky and the outside of the house belong to no thing."""

    def of_rooms(self) -> Float64[np.ndarray, "n rooms"]:
        """Return the share of each image that each room fills, with its surfaces and the objects in it."""
        return _summed(self.shares, self.around.room, len(self.around.house.rooms))

    def of_kinds(self) -> Float64[np.ndarray, "n kinds"]:
        """Return the share of each image that each kind of thing fills, in the order of `KINDS`."""
        return _summed(self.shares, self.around.kind, len(KINDS))

    def described(self) -> Float32[np.ndarray, "n size"]:
        """Return descriptions of the views, the inputs of the embedding model.

        A description holds, in this order:

        1. The square root of the share of the image that each kind of thing fills.
        2. The same, but counting only rays that hit something nearer than 2.5 m.
        3. The square root of the share of each room label, with the low weight `LABEL_WEIGHT`. These
           entries stand for visual differences that no other entry holds.
        4. The mean colours of walls, floors and ceilings.
        5. The shares of rays that hit something nearer than 0.5, 1, 2, 4 and 8 m.
        6. The share of the sky.
        """
        depth = self.hits.depth.reshape(len(self.shares), -1)
        nearer = [(depth < limit).mean(axis=1) for limit in _DEPTHS_M]
        sky = (~np.isfinite(depth)).mean(axis=1)
        near = shares_of(np.where(self.hits.depth < _NEAR_M, self.hits.thing, NOWHERE), len(self.around.names))
        kinds = np.sqrt([self.of_kinds(), _summed(near, self.around.kind, len(KINDS))])
        labels = LABEL_WEIGHT * np.sqrt(self._of_labels())
        return np.column_stack([*kinds, labels, self._colours(), *nearer, sky]).astype(np.float32)

    def _of_surfaces(self) -> Float32[np.ndarray, "n rooms surfaces"]:
        """Return the share of each image that the walls, the floor and the ceiling of each room fill."""
        rooms = len(self.around.labels)
        return self.shares[:, : rooms * len(SURFACE_KINDS)].reshape(len(self.shares), rooms, len(SURFACE_KINDS))

    def _of_labels(self) -> Float64[np.ndarray, "n labels"]:
        """Return the share of each image that the surfaces of rooms of each label fill, in the order of `ROOM_LABELS`."""
        return _summed(self._of_surfaces().sum(axis=2), self.around.labels, len(ROOM_LABELS))

    def _colours(self) -> Float32[np.ndarray, "n rgb"]:
        """Return the mean colours of walls, floors and ceilings, scaled down if they fill less than `_LEAST_SHARE`."""
        seen = self._of_surfaces()
        total = np.maximum(seen.sum(axis=1), np.float32(_LEAST_SHARE))
        means = np.einsum("nrs,rsc->nsc", seen, self.around.colour) / total[:, :, None]
        return np.asarray(_COLOUR_WEIGHT * means.reshape(len(seen), 3 * len(SURFACE_KINDS)))


def look(around: Surroundings, T_W_B: Poses, camera: Camera) -> VisibleShares:
    """Cast the rays of a camera from body poses, and sum up the share of the image that each thing fills."""
    hits = cast(around, T_W_B @ camera.T_B_C, RayGrid.of(camera.intrinsics, COLUMNS, ROWS))
    return VisibleShares(around, hits, shares_of(hits.thing, len(around.names)))


def shares_of(thing: Int[np.ndarray, "n a b"], things: int) -> Float32[np.ndarray, "n things"]:
    """Return the share of each image's rays that hit each thing.

    `thing` holds the index of the thing that each ray hits, or `NOWHERE` for a ray that hits no thing. `things` is the
    number of things.
    """
    n, size = len(thing), thing[0].size if len(thing) else 1
    first = np.arange(n)[:, None] * (things + 1) - NOWHERE  # column 0 counts the rays with `NOWHERE`
    counts = np.bincount((thing.reshape(n, -1) + first).ravel(), minlength=n * (things + 1))
    return (counts.reshape(n, -1)[:, 1:] / size).astype(np.float32)


def _summed(
    shares: Float32[np.ndarray, "n things"], group: Int[np.ndarray, "things"], groups: int
) -> Float64[np.ndarray, "n groups"]:
    member, known = np.zeros((len(group), groups)), np.flatnonzero(group != NOWHERE)
    member[known, group[known]] = 1.0
    return np.asarray(shares @ member)
