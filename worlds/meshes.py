"""Furniture and stairs as quads: parts to faces with metric texture coordinates, all vectorised over parts."""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64, Int

from worlds.house import Furniture
from worlds.parts import Colour, Part
from worlds.stairs import Stairs

_SIDES = 10


@dataclass(frozen=True, eq=False)
class QuadMesh:
    """Planar quads, visible from the side where their corners run counter-clockwise."""

    corners: Float64[np.ndarray, "q 4 3"]
    """[m]"""
    uv: Float64[np.ndarray, "q 4 2"]
    """Texture coordinates."""

    @property
    def normals(self) -> Float64[np.ndarray, "q 3"]:
        """Unit normals; from the diagonals, so that a quad with two equal corners still has one."""
        c = self.corners
        normal = np.cross(c[:, 2] - c[:, 0], c[:, 3] - c[:, 1])
        return np.asarray(normal / np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-12))


@dataclass(frozen=True, eq=False)
class ObjectMesh(QuadMesh):
    """The quads of one object; `uv` in metres on each quad's own sheet, from (0, 0)."""

    finishes: tuple[tuple[str, Colour], ...]
    """The (material, colour) pairs in use."""
    finish_of_quad: Int[np.ndarray, "q"]
    """Index into `finishes`."""


def triangles(quads: int) -> Int[np.ndarray, "t 3"]:
    """Two triangles per quad, as rows of the flattened corners."""
    return np.asarray(4 * np.arange(quads)[:, None, None] + np.array([[0, 1, 2], [0, 2, 3]])).reshape(-1, 3)


def furniture_mesh(piece: Furniture) -> ObjectMesh:
    """The mesh of a piece of furniture in W."""
    mesh = _mesh(piece.parts)
    cos, sin = np.cos(piece.yaw), np.sin(piece.yaw)
    rotation = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
    corners = mesh.corners @ rotation.T + np.array(piece.position)
    return ObjectMesh(corners, mesh.uv, mesh.finishes, mesh.finish_of_quad)


def stairs_mesh(stairs: Stairs) -> ObjectMesh:
    """The mesh of both flights in W."""
    return _mesh(stairs.treads)


def _mesh(parts: Sequence[Part]) -> ObjectMesh:
    finishes = list(dict.fromkeys((part.material, part.colour) for part in parts))
    corners, owner = [np.zeros((0, 4, 3))], [np.zeros(0, int)]
    for shape, template in _TEMPLATES.items():
        chosen = [i for i, part in enumerate(parts) if part.shape == shape]
        if chosen:
            corners.append(_placed(template, [parts[i] for i in chosen]))
            owner.append(np.repeat([finishes.index((parts[i].material, parts[i].colour)) for i in chosen], len(template)))
    quads = np.concatenate(corners)
    return ObjectMesh(quads, _metric_uv(quads), tuple(finishes), np.concatenate(owner))


def _placed(template: Float64[np.ndarray, "f 4 3"], parts: Sequence[Part]) -> Float64[np.ndarray, "q 4 3"]:
    size, centre = np.array([p.size for p in parts]), np.array([p.centre for p in parts])
    yaw = np.array([p.yaw for p in parts])
    local = template[None] * size[:, None, None]
    cos, sin = np.cos(yaw)[:, None, None], np.sin(yaw)[:, None, None]
    x, y, z = np.moveaxis(local, -1, 0)
    turned = np.stack([cos * x - sin * y, sin * x + cos * y, z], axis=-1)
    return np.asarray(turned + centre[:, None, None]).reshape(-1, 4, 3)


def _metric_uv(quads: Float64[np.ndarray, "q 4 3"]) -> Float64[np.ndarray, "q 4 2"]:
    """In-plane coordinates [m]: u along the first edge (of any length), v across it, from (0, 0)."""
    bottom, top = quads[:, 1] - quads[:, 0], quads[:, 2] - quads[:, 3]
    along = np.where((np.linalg.norm(bottom, axis=1) > 1e-9)[:, None], bottom, top)
    along /= np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-12)
    relative = quads - quads[:, :1]
    u = np.einsum("qij,qj->qi", relative, along)
    v = np.linalg.norm(relative - u[..., None] * along[:, None], axis=2)
    uv = np.stack([u, v], axis=-1)
    return np.asarray(uv - uv.min(axis=1, keepdims=True))


def _unit_box() -> Float64[np.ndarray, "6 4 3"]:
    front = np.array([(-0.5, -0.5, -0.5), (0.5, -0.5, -0.5), (0.5, -0.5, 0.5), (-0.5, -0.5, 0.5)])
    quarter = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    sides = [front @ np.linalg.matrix_power(quarter, k).T for k in range(4)]
    tip = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
    return np.array([*sides, front @ tip.T, front @ tip])


def _lathe(profile: Sequence[tuple[float, float]]) -> Float64[np.ndarray, "f 4 3"]:
    """The solid of revolution of (radius, z) pairs from bottom to top, in the unit cube."""
    angles = 2 * np.pi * np.arange(_SIDES + 1) / _SIDES
    ring = np.column_stack([np.cos(angles), np.sin(angles)])
    quads = []
    for (r0, z0), (r1, z1) in itertools.pairwise(profile):
        lower, upper = (np.column_stack([r * ring, np.full(_SIDES + 1, z)]) for r, z in ((r0, z0), (r1, z1)))
        quads.append(np.stack([lower[:-1], lower[1:], upper[1:], upper[:-1]], axis=1))
    return np.concatenate(quads)


def _ball_profile(rings: int = 6) -> list[tuple[float, float]]:
    angles = np.linspace(-np.pi / 2, np.pi / 2, rings + 1)
    return [(float(0.5 * np.cos(a)), float(0.5 * np.sin(a))) for a in angles]


_TEMPLATES = {
    "box": _unit_box(),
    "cylinder": _lathe([(0.0, -0.5), (0.5, -0.5), (0.5, 0.5), (0.0, 0.5)]),
    "cone": _lathe([(0.0, -0.5), (0.5, -0.5), (0.0, 0.5)]),
    "ball": _lathe(_ball_profile()),
}
