"""Random generators of a house: one for every purpose in each room, and one for each thing that belongs to no room."""

import zlib
from typing import Literal

import numpy as np

from worlds.spec import HouseSpec, RoomSpec

Purpose = Literal["windows", "furniture", "finish"]
_PURPOSES: dict[Purpose, int] = {"windows": 0, "furniture": 1, "finish": 2}


def room_rng(spec: HouseSpec, room: RoomSpec, purpose: Purpose) -> np.random.Generator:
    """Return the random generator for one purpose in one room.

    The generator is seeded with the house's seed and the room's id, so that a change to one room changes no other room. If
    the room has a seed of its own, only that seed is used, so that rooms with the same seed (twins) get the same random
    numbers. The generator for finishes also depends on `appearance.seed`.
    """
    own = [spec.seed, zlib.crc32(room.id.encode())] if room.seed is None else [room.seed]
    painted = _repaint(spec) if purpose == "finish" else []
    return np.random.default_rng([*own, *painted, _PURPOSES[purpose]])


def house_rng(spec: HouseSpec, *key: int) -> np.random.Generator:
    """Return the random generator for the appearance of a thing that belongs to no room; `key` identifies the thing."""
    return np.random.default_rng([spec.seed, *_repaint(spec), _PURPOSES["finish"], *key])


def _repaint(spec: HouseSpec) -> list[int]:
    return [] if spec.appearance.seed is None else [spec.appearance.seed]
