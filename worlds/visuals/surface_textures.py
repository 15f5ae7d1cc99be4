"""Textures of the shell: the material and the image of the floor, the walls and the ceiling of each room.

All walls of a room share one image, onto which `worlds.visuals.surfaces` has unrolled them.
"""

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64, UInt8
from numpy.random import Generator

from worlds.furniture.finishes import Covering, Finish, finish_of
from worlds.house import House
from worlds.seeds import house_rng, room_rng
from worlds.visuals.materials import texture, tileable
from worlds.visuals.surfaces import OUTSIDE, SURFACE_KINDS, Surface, SurfaceKind

_PX_PER_M: Mapping[SurfaceKind, float] = {"wall": 90.0, "floor": 80.0, "ceiling": 40.0}
_MAX_PX = 4096
PERIOD_M: Mapping[SurfaceKind, float] = {"wall": 1.0, "floor": 0.5, "ceiling": 0.5}
"""Period of the texture of each kind of surface, along both axes, in houses with repeating textures [m]. One metre is a
whole number of periods, so all textures look the same from a viewpoint one metre further along a surface."""
_OUTSIDE_LOOKS = "garden"


@dataclass(frozen=True, eq=False)
class SurfaceTexture:
    """The faces of one kind (walls, floor or ceiling) in one room, with their material and their image."""

    room: str
    kind: SurfaceKind
    covering: Covering
    image: UInt8[np.ndarray, "h w 3"]
    corners: Float64[np.ndarray, "q 4 3"]
    """Corners of every quad in the world frame W [m]."""
    uv: Float64[np.ndarray, "q 4 2"]
    """Texture coordinates as fractions of the image's width and height, v upwards; the image repeats beyond 1."""


def finishes(house: House) -> dict[str, Finish]:
    """Return the finish of each room by the room's id, and the finish of the outside by `OUTSIDE`.

    A room's finish is drawn at random. It depends only on the room's label and on the seed of the room (see `room_rng`).
    """
    return {room: finish_of(label, _rng(house, room)) for room, label in _labels(house).items()}


def surface_textures(house: House, faces: Sequence[Surface]) -> Iterator[SurfaceTexture]:
    """Return the textures of all `faces` of the shell of `house`, grouped by room and kind."""
    groups: dict[tuple[str, SurfaceKind], list[Surface]] = defaultdict(list)
    for face in faces:
        groups[face.room, face.kind].append(face)
    finish = finishes(house)
    generators = {
        room: dict(zip(SURFACE_KINDS, _rng(house, room).spawn(len(SURFACE_KINDS)), strict=True)) for room in finish
    }
    for (room, kind), group in groups.items():
        pattern, colour = covering = getattr(finish[room], kind)
        uv = np.array([face.uv for face in group])
        rng, looks, scale = generators[room][kind], house.spec.appearance.texture, _PX_PER_M[kind]
        if looks == "repeating":
            metres = np.full(2, PERIOD_M[kind])
            image = tileable(pattern, colour, rng, round(PERIOD_M[kind] * scale), PERIOD_M[kind])
        else:
            metres = uv.max(axis=(0, 1))
            image = _painted("bare" if looks == "poor" else pattern, covering, rng, metres, scale)
        yield SurfaceTexture(room, kind, covering, image, np.array([face.corners for face in group]), uv / metres)


def _painted(
    pattern: str, covering: Covering, rng: Generator, metres: Float64[np.ndarray, "2"], px_per_m: float
) -> UInt8[np.ndarray, "h w 3"]:
    width, height = np.clip(np.ceil(metres * px_per_m), 16, _MAX_PX).astype(int)
    return texture(pattern, covering[1], rng, (int(height), int(width)), (float(metres[0]), float(metres[1])))


def _labels(house: House) -> dict[str, str]:
    return {room.id: room.label for room in house.rooms} | {OUTSIDE: _OUTSIDE_LOOKS}


def _rng(house: House, room: str) -> Generator:
    if room == OUTSIDE:
        return house_rng(house.spec)
    return room_rng(house.spec, next(r for storey in house.spec.storeys for r in storey.rooms if r.id == room), "finish")
