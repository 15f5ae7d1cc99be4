"""All visible surfaces of a house as textured quads, for renderers and exporters."""

import itertools
import zlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64, UInt8

from worlds.house import House
from worlds.visuals.atlas import SHOWN_WHOLE, Atlas, paint_of
from worlds.visuals.meshes import Solid, normals, solids_mesh
from worlds.visuals.surface_textures import surface_textures
from worlds.visuals.surfaces import surfaces

STAIRS_OBJECT = "stairs"
ATLAS = "(atlas)"
"""Name of the atlas image that all objects share. No room id contains brackets, so no image of a room has this name."""


@dataclass(frozen=True, eq=False)
class Visual:
    """The quads of one object or surface. A quad is visible from the side on which its corners run counter-clockwise."""

    name: str
    """The name of these quads, unique in the house."""
    shows: str
    """What the quads show: the id of a piece of furniture, a door leaf or a window; `STAIRS_OBJECT` for stairs; or
    "<room id>/<wall|floor|ceiling>"."""
    image: str
    """Key of the image in `Visuals.images`."""
    corners: Float64[np.ndarray, "q 4 3"]
    """Corners of every quad in the world frame W [m]."""
    uv: Float64[np.ndarray, "q 4 2"]
    """Texture coordinates as fractions of the image's width and height, v upwards; the image repeats beyond 1."""
    normals: Float64[np.ndarray, "q 3"]


@dataclass(frozen=True, eq=False)
class Visuals:
    """The textured quads of a whole house, with their images."""

    images: Mapping[str, UInt8[np.ndarray, "h w 3"]]
    """RGB images of the textures. The keys are the names in `Visual.image`."""
    parts: tuple[Visual, ...]


@dataclass(frozen=True, eq=False)
class _Object:
    name: str
    shows: str
    solid: Solid
    seed: int


def visuals(house: House) -> Visuals:
    """Return all visuals of a house: walls, floors and ceilings by room, then furniture, stairs, door leaves and windows."""
    images, parts = {}, []
    for sheet in surface_textures(house, surfaces(house)):
        name = f"{sheet.room}/{sheet.kind}"
        images[name] = sheet.image
        parts.append(Visual(name, name, name, sheet.corners, sheet.uv, normals(sheet.corners)))
    objects = [thing for thing in _objects(house) if thing.solid.parts]
    if objects:
        images[ATLAS], drawn = _object_visuals(house, objects)
        parts += drawn
    return Visuals(images, tuple(parts))


def _objects(house: House) -> Iterator[_Object]:
    for piece in house.furniture:
        yield _Object(piece.id, piece.id, Solid(piece.parts, piece.position, piece.yaw), piece.seed)
    for flight in house.stairs:
        yield _Object(f"{STAIRS_OBJECT}/{flight.storey}/{flight.room}", STAIRS_OBJECT, Solid(flight.parts), flight.storey)
    for leaf in house.leaves:
        yield _Object(leaf.id, leaf.id, Solid(leaf.parts, leaf.position, leaf.yaw), zlib.crc32(leaf.id.encode()))
    for window in house.windows:
        yield _Object(window.id, window.id, Solid(window.parts, window.position, window.yaw), window.seed)


def _object_visuals(house: House, objects: Sequence[_Object]) -> tuple[UInt8[np.ndarray, "h w 3"], Iterator[Visual]]:
    mesh = solids_mesh([thing.solid for thing in objects])
    paints = [paint_of(part.material, part.colour, thing.seed) for thing in objects for part in thing.solid.parts]
    atlas = Atlas.of(paints, house.spec)
    patches = np.array([atlas.patch_of[paint] for paint in paints])[mesh.part]
    whole = np.array([material in SHOWN_WHOLE for material, _, _ in paints])[mesh.part]
    starts = np.searchsorted(mesh.solid, np.arange(len(objects) + 1))
    cut = np.concatenate(
        [np.random.default_rng(thing.seed).random((n, 2)) for thing, n in zip(objects, np.diff(starts), strict=True)]
    )
    uv, facing = atlas.place(mesh.uv, patches, whole, cut), normals(mesh.corners)
    quads = [slice(a, b) for a, b in itertools.pairwise(starts)]
    return atlas.image, (
        Visual(thing.name, thing.shows, ATLAS, mesh.corners[q], uv[q], facing[q])
        for thing, q in zip(objects, quads, strict=True)
    )
