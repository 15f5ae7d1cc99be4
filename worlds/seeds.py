"""Where every room's randomness comes from: a generator of its own per purpose."""

import zlib
from typing import Literal

import numpy as np

from worlds.spec import HouseSpec, RoomSpec

Purpose = Literal["windows", "furniture", "finish"]
_PURPOSES: dict[Purpose, int] = {"windows": 0, "furniture": 1, "finish": 2}


def room_rng(spec: HouseSpec, room: RoomSpec, purpose: Purpose) -> np.random.Generator:
    """The generator for one purpose in one room.

    It depends on nothing else of the house, so that a change to one room leaves the others alone; rooms with the same
    seed of their own (twins) get the same draws.
    """
    own = [spec.seed, zlib.crc32(room.id.encode())] if room.seed is None else [room.seed]
    painted = _repaint(spec) if purpose == "finish" else []
    return np.random.default_rng([*own, *painted, _PURPOSES[purpose]])


def house_rng(spec: HouseSpec, *key: int) -> np.random.Generator:
    """The generator for the looks of what belongs to no room; a `key` for each thing."""
    return np.random.default_rng([spec.seed, *_repaint(spec), _PURPOSES["finish"], *key])


def _repaint(spec: HouseSpec) -> list[int]:
    return [] if spec.appearance.seed is None else [spec.appearance.seed]
