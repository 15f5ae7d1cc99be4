"""Random generators of the rooms: each room has one of its own for every purpose."""

import zlib
from typing import Literal

import numpy as np

from worlds.spec import HouseSpec, RoomSpec

Purpose = Literal["windows", "furniture", "finish"]
_PURPOSES: dict[Purpose, int] = {"windows": 0, "furniture": 1, "finish": 2}


def room_rng(spec: HouseSpec, room: RoomSpec, purpose: Purpose) -> np.random.Generator:
    """The generator for one purpose in one room.

    It is seeded with the house's seed and the room's id, so that a change to one room changes no other room. For a room with
    a seed of its own, this seed replaces both, so that rooms with the same seed (twins) get the same draws.
    """
    own = [spec.seed, zlib.crc32(room.id.encode())] if room.seed is None else [room.seed]
    painted = _repaint(spec) if purpose == "finish" else []
    return np.random.default_rng([*own, *painted, _PURPOSES[purpose]])


def house_rng(spec: HouseSpec, *key: int) -> np.random.Generator:
    """The generator for the appearance of things that belong to no room; each thing has a `key` of its own."""
    return np.random.default_rng([spec.seed, *_repaint(spec), _PURPOSES["finish"], *key])


def _repaint(spec: HouseSpec) -> list[int]:
    return [] if spec.appearance.seed is None else [spec.appearance.seed]
