"""What cameras truly see of a house: the share of the image that every thing fills, and how far things are."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float32, Float64, Int

from lexis.types import Camera, Poses
from sim.feature_sensor.ray_origins import RayGrid
from sim.feature_sensor.rays import Hits, cast
from sim.feature_sensor.surroundings import KINDS, SURFACES, Surroundings
from worlds.labels import ROOM_LABELS
from worlds.truth import NOWHERE

COLUMNS, ROWS = 40, 30
"""Rays of an image: a thing that fills 1 % of it is met by a dozen."""
LABEL_WEIGHT = 0.05
"""Of labels in a description, against what is visible: a ridge regression on descriptions uses them that much less."""
_NEAR_M = 2.5
"""Depth up to which things are near: in the camera's own room, mostly [m]."""
_DEPTHS_M = (0.5, 1.0, 2.0, 4.0, 8.0)
_COLOUR_WEIGHT = 2.0
"""Of colours in [0, 1] in a description."""
_LEAST_SHARE = 0.02
"""Of the image; surfaces of less have fainter colours."""
LABELS = slice(2 * len(KINDS), 2 * len(KINDS) + len(ROOM_LABELS))
"""Where a description holds what rooms of every label fill."""
SIZE = LABELS.stop + 3 * len(SURFACES) + len(_DEPTHS_M) + 1
"""Length of a description."""


@dataclass(frozen=True, eq=False)
class VisibleShares:
    """What cameras see."""

    around: Surroundings
    hits: Hits
    shares: Float32[np.ndarray, "n things"]
    """Of the image, in [0, 1]; they sum to 1 where there is neither sky nor the house from outside."""

    def of_rooms(self) -> Float64[np.ndarray, "n rooms"]:
        """Shares of rooms: their surfaces and what stands in them."""
        return _summed(self.shares, self.around.room, len(self.around.house.rooms))

    def of_kinds(self) -> Float64[np.ndarray, "n kinds"]:
        """Shares of kinds of things, as in `KINDS`."""
        return _summed(self.shares, self.around.kind, len(KINDS))

    def described(self) -> Float32[np.ndarray, "n size"]:
        """What an encoder can go by: kinds of things, colours of walls, floors and ceilings, how the depths are distributed.

        Kinds by the root of the share that all of them fill, and that the near ones do. Labels of rooms weigh least
        (`LABEL_WEIGHT`): they stand for looks that nothing else here tells.
        """
        depth = self.hits.depth.reshape(len(self.shares), -1)
        nearer = [(depth < limit).mean(axis=1) for limit in _DEPTHS_M]
        sky = (~np.isfinite(depth)).mean(axis=1)
        near = shares_of(np.where(self.hits.depth < _NEAR_M, self.hits.thing, NOWHERE), len(self.around.names))
        kinds = np.sqrt([self.of_kinds(), _summed(near, self.around.kind, len(KINDS))])
        labels = LABEL_WEIGHT * np.sqrt(self._of_labels())
        return np.column_stack([*kinds, labels, self._colours(), *nearer, sky]).astype(np.float32)

    def _of_surfaces(self) -> Float32[np.ndarray, "n rooms surfaces"]:
        """Shares of the walls, the floor and the ceiling of every room."""
        rooms = len(self.around.labels)
        return self.shares[:, : rooms * len(SURFACES)].reshape(len(self.shares), rooms, len(SURFACES))

    def _of_labels(self) -> Float64[np.ndarray, "n labels"]:
        """Shares of the surfaces of all rooms of a label."""
        return _summed(self._of_surfaces().sum(axis=2), self.around.labels, len(ROOM_LABELS))

    def _colours(self) -> Float32[np.ndarray, "n rgb"]:
        """Mean colours of walls, of floors and of ceilings, fading where hardly any of them is in view."""
        seen = self._of_surfaces()
        total = np.maximum(seen.sum(axis=1), np.float32(_LEAST_SHARE))
        means = np.einsum("nrs,rsc->nsc", seen, self.around.colour) / total[:, :, None]
        return np.asarray(_COLOUR_WEIGHT * means.reshape(len(seen), 3 * len(SURFACES)))


def look(around: Surroundings, T_W_B: Poses, camera: Camera) -> VisibleShares:
    """What a camera sees from poses of the body."""
    hits = cast(around, T_W_B @ camera.T_B_C, RayGrid.of(camera.intrinsics, COLUMNS, ROWS))
    return VisibleShares(around, hits, shares_of(hits.thing, len(around.names)))


def shares_of(thing: Int[np.ndarray, "n a b"], things: int) -> Float32[np.ndarray, "n {things}"]:
    """The share of every image that each of so many things fills; `NOWHERE` is none of them."""
    n, size = len(thing), thing[0].size if len(thing) else 1
    flat = thing.reshape(n, -1)
    rows = np.broadcast_to(np.arange(n)[:, None] * things, flat.shape)
    seen = flat != NOWHERE
    counts = np.bincount((rows + flat)[seen], minlength=n * things)
    return (counts.reshape(n, things) / size).astype(np.float32)


def _summed(
    shares: Float32[np.ndarray, "n things"], group: Int[np.ndarray, "things"], groups: int
) -> Float64[np.ndarray, "n {groups}"]:
    member = np.zeros((len(group), groups))
    member[np.arange(len(group)), group] = 1.0
    return np.asarray(shares @ member)
