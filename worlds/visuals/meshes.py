"""Meshes of furniture, stairs, door leaves and windows: the parts of these objects become quads with texture coordinates.

All objects of a house are converted in one vectorised pass.
"""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64, Int

from worlds.parts import Part, Vector

_SIDES = 10
_BALL_RINGS = 6
_GROWTH_M = 2e-5
"""Every part is drawn larger than it is: by this length for each part that comes before it in its solid [m]. Where faces of
two parts lie in one plane, the face of the later part is therefore the visible one."""


@dataclass(frozen=True, eq=False)
class Solid:
    """An object made of parts, with its pose in the world."""

    parts: Sequence[Part]
    """The parts, in the object's own frame."""
    position: Vector = (0.0, 0.0, 0.0)
    """Origin of the object's frame in the world frame W [m]."""
    yaw: float = 0.0
    """Rotation of the object's frame about z [rad]."""


@dataclass(frozen=True, eq=False)
class SolidsMesh:
    """The faces of many solids as planar quads, visible from the side on which their corners run counter-clockwise."""

    corners: Float64[np.ndarray, "q 4 3"]
    """Corners of every quad in the world frame W [m]."""
    uv: Float64[np.ndarray, "q 4 2"]
    """Coordinates (u, v) of the corners within the plane of each quad [m]; the smallest u and the smallest v are 0."""
    solid: Int[np.ndarray, "q"]
    """Index of the solid that each quad belongs to, in ascending order."""
    part: Int[np.ndarray, "q"]
    """Index of the part that each quad belongs to; parts are numbered consecutively over all solids."""


def solids_mesh(solids: Sequence[Solid]) -> SolidsMesh:
    """Return the mesh of all `solids`. Its quads are ordered by solid, and within a solid by part."""
    parts = [part for solid in solids for part in solid.parts]
    counts = [len(solid.parts) for solid in solids]
    owner = np.repeat(np.arange(len(solids)), counts)
    growth = _GROWTH_M * np.concatenate([np.zeros(0), *map(np.arange, counts)])
    corners, part_of = [np.zeros((0, 4, 3))], [np.zeros(0, int)]
    for shape, template in _TEMPLATES.items():
        chosen = np.array([i for i, part in enumerate(parts) if part.shape == shape], int)
        if len(chosen):
            corners.append(_placed(template, [parts[i] for i in chosen], growth[chosen]))
            part_of.append(np.repeat(chosen, len(template)))
    part = np.concatenate(part_of)
    order = np.argsort(part, kind="stable")
    part, local = part[order], np.concatenate(corners)[order]
    solid = owner[part] if len(part) else part
    return SolidsMesh(_in_world(local, solids, solid), _metric_uv(local), solid, part)


def normals(corners: Float64[np.ndarray, "q 4 3"]) -> Float64[np.ndarray, "q 3"]:
    """Return the unit normals of quads. They follow from the diagonals: a quad with two equal corners has a normal, too."""
    normal = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    return np.asarray(normal / np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-12))


def triangles(quads: int) -> Int[np.ndarray, "t 3"]:
    """Return two triangles per quad, as indices into the list of all corners (four per quad)."""
    return np.asarray(4 * np.arange(quads)[:, None, None] + np.array([[0, 1, 2], [0, 2, 3]])).reshape(-1, 3)


def _placed(
    template: Float64[np.ndarray, "f 4 3"], parts: Sequence[Part], growth: Float64[np.ndarray, "n"]
) -> Float64[np.ndarray, "q 4 3"]:
    size, centre = np.array([p.size for p in parts]) + growth[:, None], np.array([p.centre for p in parts])
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
    """Return coordinates (u, v) of the corners within the plane of each quad [m]; the smallest u and the smallest v are 0.

    The u axis runs along the bottom edge, or along the top edge if the bottom edge has no length. The v axis is
    perpendicular to the u axis.
    """
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
    tilt = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
    return np.array([*sides, front @ tilt.T, front @ tilt])


def _lathe(profile: Sequence[tuple[float, float]]) -> Float64[np.ndarray, "f 4 3"]:
    """Return the quads of the solid that a profile describes when it rotates about the z axis.

    The profile lists points (radius, z), from bottom to top. Radius and z are in [-0.5, 0.5], so that the solid fits into a
    unit cube around the origin.
    """
    angles = 2 * np.pi * np.arange(_SIDES + 1) / _SIDES
    ring = np.column_stack([np.cos(angles), np.sin(angles)])
    quads = []
    for (r0, z0), (r1, z1) in itertools.pairwise(profile):
        lower, upper = (np.column_stack([r * ring, np.full(_SIDES + 1, z)]) for r, z in ((r0, z0), (r1, z1)))
        quads.append(np.stack([lower[:-1], lower[1:], upper[1:], upper[:-1]], axis=1))
    return np.concatenate(quads)


def _ball_profile() -> list[tuple[float, float]]:
    angles = np.linspace(-np.pi / 2, np.pi / 2, _BALL_RINGS + 1)
    return [(float(0.5 * np.cos(a)), float(0.5 * np.sin(a))) for a in angles]


_TEMPLATES = {
    "box": _unit_box(),
    "cylinder": _lathe([(0.0, -0.5), (0.5, -0.5), (0.5, 0.5), (0.0, 0.5)]),
    "cone": _lathe([(0.0, -0.5), (0.5, -0.5), (0.0, 0.5)]),
    "ball": _lathe(_ball_profile()),
}
