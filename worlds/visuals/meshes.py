"""Furniture, stairs and leaves as quads: parts to faces with metric texture coordinates, vectorised over a whole house."""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64, Int

from worlds.parts import Part, Vector

_SIDES = 10
_PROUD_M = 2e-5
"""By how much each part of a solid is larger than the one before it: of faces in one plane, the later part's is seen."""


@dataclass(frozen=True, eq=False)
class Solid:
    """An object made of parts, in its place."""

    parts: Sequence[Part]
    """In the object's own frame."""
    position: Vector = (0.0, 0.0, 0.0)
    """Of that frame's origin in W [m]."""
    yaw: float = 0.0
    """[rad]"""


@dataclass(frozen=True, eq=False)
class SolidsMesh:
    """The faces of many solids: planar quads, visible from the side where their corners run counter-clockwise."""

    corners: Float64[np.ndarray, "q 4 3"]
    """In W [m]."""
    uv: Float64[np.ndarray, "q 4 2"]
    """In metres on each quad's own sheet, from (0, 0)."""
    solid: Int[np.ndarray, "q"]
    """Index of the solid that each quad belongs to, ascending."""
    part: Int[np.ndarray, "q"]
    """Index of the part, counted through all solids."""


def solids_mesh(solids: Sequence[Solid]) -> SolidsMesh:
    """The faces of all `solids`."""
    parts = [part for solid in solids for part in solid.parts]
    counts = [len(solid.parts) for solid in solids]
    owner = np.repeat(np.arange(len(solids)), counts)
    proud = _PROUD_M * np.concatenate([np.zeros(0), *map(np.arange, counts)])
    corners, part_of = [np.zeros((0, 4, 3))], [np.zeros(0, int)]
    for shape, template in _TEMPLATES.items():
        chosen = np.array([i for i, part in enumerate(parts) if part.shape == shape], int)
        if len(chosen):
            corners.append(_placed(template, [parts[i] for i in chosen], proud[chosen]))
            part_of.append(np.repeat(chosen, len(template)))
    part = np.concatenate(part_of)
    order = np.argsort(part, kind="stable")
    part, local = part[order], np.concatenate(corners)[order]
    solid = owner[part] if len(part) else part
    return SolidsMesh(_in_world(local, solids, solid), _metric_uv(local), solid, part)


def normals(corners: Float64[np.ndarray, "q 4 3"]) -> Float64[np.ndarray, "q 3"]:
    """Unit normals of quads; from the diagonals, so that a quad with two equal corners still has one."""
    normal = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    return np.asarray(normal / np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-12))


def triangles(quads: int) -> Int[np.ndarray, "t 3"]:
    """Two triangles per quad, as rows of the flattened corners."""
    return np.asarray(4 * np.arange(quads)[:, None, None] + np.array([[0, 1, 2], [0, 2, 3]])).reshape(-1, 3)


def _placed(
    template: Float64[np.ndarray, "f 4 3"], parts: Sequence[Part], proud: Float64[np.ndarray, "n"]
) -> Float64[np.ndarray, "q 4 3"]:
    size, centre = np.array([p.size for p in parts]) + proud[:, None], np.array([p.centre for p in parts])
    yaw = np.array([p.yaw for p in parts])[:, None, None]
    turned = _turned(template[None] * size[:, None, None], yaw)
    return np.asarray(turned + centre[:, None, None]).reshape(-1, 4, 3)


def _in_world(
    local: Float64[np.ndarray, "q 4 3"], solids: Sequence[Solid], owner: Int[np.ndarray, "q"]
) -> Float64[np.ndarray, "q 4 3"]:
    if not solids:
        return local
    yaw, position = np.array([solid.yaw for solid in solids]), np.array([solid.position for solid in solids])
    return np.asarray(_turned(local, yaw[owner][:, None]) + position[owner][:, None])


def _turned(points: Float64[np.ndarray, "*n 3"], yaw: Float64[np.ndarray, "*m"]) -> Float64[np.ndarray, "*n 3"]:
    cos, sin = np.cos(yaw), np.sin(yaw)
    x, y, z = points[..., 0], points[..., 1], points[..., 2]
    return np.stack([cos * x - sin * y, sin * x + cos * y, z], axis=-1)


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
