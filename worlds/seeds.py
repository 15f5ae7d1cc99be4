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
    painted = [spec.appearance.seed] if purpose == "finish" and spec.appearance.seed is not None else []
    return np.random.default_rng([*own, *painted, _PURPOSES[purpose]])
