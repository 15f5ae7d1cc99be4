"""Houses for other tools: a GLB of coloured triangles, one node per room's shell and per object."""

from collections import defaultdict

import numpy as np
import trimesh
from jaxtyping import Float64, UInt8

from worlds.furniture.finishes import finish_of
from worlds.house import House
from worlds.meshes import furniture_mesh, stairs_mesh, triangles
from worlds.parts import Colour
from worlds.surfaces import OUTSIDE, Surface, surfaces


def to_trimesh(house: House) -> trimesh.Scene:
    """The house as a scene in W [m, z up]; nodes are named by room id and surface, by furniture id, by stairs."""
    scene = trimesh.Scene()
    shell: dict[tuple[str, str], list[Surface]] = defaultdict(list)
    for surface in surfaces(house):
        shell[surface.room, surface.kind].append(surface)
    labels = {room.id: room.label for room in house.rooms} | {OUTSIDE: "garden"}
    for (room, kind), faces in shell.items():
        finish = finish_of(labels[room], np.random.default_rng(house.spec.seed))
        _, colour = getattr(finish, kind)
        quads = np.array([face.corners for face in faces])
        scene.add_geometry(_triangles(quads, np.repeat([_rgba(colour)], len(quads), axis=0)), node_name=f"{room}/{kind}")
    objects = [(piece.id, furniture_mesh(piece)) for piece in house.furniture]
    objects += [(f"stairs/{flight.storey}", stairs_mesh(flight)) for flight in house.stairs]
    for name, mesh in objects:
        colours = np.array([_rgba(colour) for _, colour in mesh.finishes], np.uint8).reshape(-1, 4)
        scene.add_geometry(_triangles(mesh.corners, colours[mesh.finish_of_quad]), node_name=name)
    return scene


def to_glb(house: House) -> bytes:
    """The house as a binary glTF file."""
    return bytes(to_trimesh(house).export(file_type="glb"))  # type: ignore[no-untyped-call]


def _triangles(quads: Float64[np.ndarray, "q 4 3"], colours: UInt8[np.ndarray, "q 4"]) -> trimesh.Trimesh:
    faces = triangles(len(quads))
    return trimesh.Trimesh(quads.reshape(-1, 3), faces, face_colors=np.repeat(colours, 2, axis=0), process=False)


def _rgba(colour: Colour) -> UInt8[np.ndarray, "4"]:
    return np.append(np.round(np.array(colour) * 255), 255).astype(np.uint8)
