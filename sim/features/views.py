"""What cameras truly see of a house: the share of the image that every thing fills, and how far things are."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float32, Float64, Int

from lexis.types import Camera, Poses
from sim.features.eyes import RayGrid
from sim.features.rays import Hits, cast
from sim.features.surroundings import KINDS, Surroundings
from worlds.truth import NOWHERE

COLUMNS, ROWS = 40, 30
"""Rays of an image: a thing that fills 1 % of it is met by a dozen."""
PRESENT = 0.004
"""Share of the image from which on an object counts as present."""
_DEPTHS_M = (0.5, 1.0, 2.0, 4.0, 8.0)
SIZE = 2 * len(KINDS) + len(_DEPTHS_M) + 1
"""Length of a description."""


@dataclass(frozen=True, eq=False)
class Views:
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
        """Kinds of things by the root of their share and by presence, and how the depths are distributed."""
        kinds = self.of_kinds()
        depth = self.hits.depth.reshape(len(kinds), -1)
        nearer = [(depth < limit).mean(axis=1) for limit in _DEPTHS_M]
        sky = (~np.isfinite(depth)).mean(axis=1)
        return np.column_stack([np.sqrt(kinds), kinds > PRESENT, *nearer, sky]).astype(np.float32)


def look(around: Surroundings, T_W_B: Poses, camera: Camera) -> Views:
    """What a camera sees from poses of the body."""
    hits = cast(around, T_W_B @ camera.T_B_C, RayGrid.of(camera.intrinsics, COLUMNS, ROWS))
    return Views(around, hits, shares_of(hits.thing, len(around.names)))


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
