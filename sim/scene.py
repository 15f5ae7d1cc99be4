"""House -> MjModel: the shell as textured quad meshes per room, every piece of furniture as one mesh on a shared atlas."""

from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64, Int, UInt8

from sim.gl import mujoco
from worlds.furniture.finishes import Finish, finish_of
from worlds.house import House
from worlds.materials import texture
from worlds.meshes import QuadMesh, furniture_mesh, stairs_mesh, triangles
from worlds.parts import Colour
from worlds.surfaces import OUTSIDE, Surface, SurfaceKind, surfaces

CAMERA = "camera"
STAIRS_OBJECT = "stairs"
_SHELL_PX_PER_M = {"wall": 90.0, "floor": 80.0, "ceiling": 40.0}
_MAX_TEXTURE_PX = 4096
_PATCH_PX = 128
_ATLAS_PATCHES = 16
_SKY = (0.62, 0.76, 0.92)


@dataclass(frozen=True, eq=False)
class Scene:
    """A compiled house, ready to render."""

    model: "mujoco.MjModel"
    data: "mujoco.MjData"
    object_of_geom: tuple[str, ...]
    """What each geom shows: a furniture id, `STAIRS_OBJECT`, or "<room id>/<wall|floor|ceiling>"."""


def build_scene(house: House, size_px: tuple[int, int], fovy_deg: float) -> Scene:
    """Compile `house` with one free camera of `size_px` (width, height) and vertical field of view [deg].

    Light is bright and shadowless: shadows and multi-sampling cost an order of magnitude in a software renderer, and
    features fade in the dark.
    """
    rng = np.random.default_rng([house.spec.seed, 1])
    shell_rng, atlas_rng = rng.spawn(2)
    spec = _empty_spec(house, size_px, fovy_deg)
    names = [*_add_shell(spec, house, shell_rng), *_add_objects(spec, house, atlas_rng)]
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return Scene(model, data, tuple(names))


def _empty_spec(house: House, size_px: tuple[int, int], fovy_deg: float) -> "mujoco.MjSpec":
    spec = mujoco.MjSpec()
    bounds = np.array([room.polygon.bounds for room in house.rooms])
    low, high = bounds[:, :2].min(axis=0), bounds[:, 2:].max(axis=0)
    top = house.storeys[-1].ceiling_m
    # Clipping planes scale with the extent: fixed here, so that the size of the house does not change the near plane.
    spec.stat.extent, spec.stat.center = 10.0, [*(low + high) / 2, top / 2]
    spec.visual.map.znear, spec.visual.map.zfar = 0.005, 8.0
    spec.visual.quality.offsamples, spec.visual.quality.shadowsize = 0, 0
    spec.visual.global_.offwidth, spec.visual.global_.offheight = size_px
    spec.visual.headlight.active = 0
    light = dict(type=mujoco.mjtLightType.mjLIGHT_DIRECTIONAL, castshadow=False, specular=[0, 0, 0])
    spec.worldbody.add_light(dir=[0.35, 0.55, -0.75], ambient=[0.62] * 3, diffuse=[0.34] * 3, **light)
    spec.worldbody.add_light(dir=[-0.55, -0.35, 0.3], ambient=[0.0] * 3, diffuse=[0.16] * 3, **light)
    spec.add_texture(
        name="sky", type=mujoco.mjtTexture.mjTEXTURE_SKYBOX, builtin=mujoco.mjtBuiltin.mjBUILTIN_GRADIENT,
        rgb1=_SKY, rgb2=[0.93, 0.95, 0.97], width=64, height=384,
    )  # fmt: skip
    body = spec.worldbody.add_body(name=CAMERA, mocap=True)
    body.add_camera(name=CAMERA, fovy=fovy_deg)
    return spec


def _add_shell(spec: "mujoco.MjSpec", house: House, rng: np.random.Generator) -> Iterator[str]:
    groups: dict[tuple[str, SurfaceKind], list[Surface]] = defaultdict(list)
    for surface in surfaces(house):
        groups[surface.room, surface.kind].append(surface)
    labels = {room.id: room.label for room in house.rooms} | {OUTSIDE: "garden"}
    generators = dict(zip(labels, rng.spawn(len(labels)), strict=True))
    finishes = {room: finish_of(label, generators[room]) for room, label in labels.items()}
    for (room, kind), faces in groups.items():
        pattern, colour = _finish(finishes[room], kind)
        uv = np.array([face.uv for face in faces])
        name, metres = f"{room}/{kind}", uv.max(axis=(0, 1))
        sheet = _sheet(pattern, colour, generators[room], metres, _SHELL_PX_PER_M[kind])
        _add_material(spec, name, sheet)
        mesh = QuadMesh(np.array([face.corners for face in faces]), uv / metres)
        _add_mesh(spec, name, name, mesh)
        yield name


def _finish(finish: Finish, kind: SurfaceKind) -> tuple[str, Colour]:
    if kind == "wall":
        return finish.wall
    return finish.floor if kind == "floor" else finish.ceiling


def _sheet(
    pattern: str, colour: Colour, rng: np.random.Generator, metres: Float64[np.ndarray, "2"], px_per_m: float
) -> UInt8[np.ndarray, "h w 3"]:
    width, height = np.clip(np.ceil(metres * px_per_m), 16, _MAX_TEXTURE_PX).astype(int)
    return texture(pattern, colour, rng, (int(height), int(width)), (float(metres[0]), float(metres[1])))


def _add_objects(spec: "mujoco.MjSpec", house: House, rng: np.random.Generator) -> Iterator[str]:
    meshes = [(piece.id, furniture_mesh(piece)) for piece in house.furniture]
    meshes += [(f"{STAIRS_OBJECT}/{flight.storey}/{flight.room}", stairs_mesh(flight)) for flight in house.stairs]
    finishes = [finish for _, mesh in meshes for finish in mesh.finishes]
    atlas = _Atlas.of(finishes, rng)
    _add_material(spec, "atlas", atlas.image)
    for (name, mesh), object_rng in zip(meshes, rng.spawn(len(meshes)), strict=True):
        if len(mesh.corners) == 0:
            continue
        patches = np.array([atlas.patch_of[finish] for finish in mesh.finishes])[mesh.finish_of_quad]
        _add_mesh(spec, name, "atlas", QuadMesh(mesh.corners, atlas.place(mesh.uv, patches, object_rng)))
        yield STAIRS_OBJECT if name.startswith(f"{STAIRS_OBJECT}/") else name


@dataclass(frozen=True, eq=False)
class _Atlas:
    """One texture for all furniture: a grid of patches, one per (pattern, colour)."""

    image: UInt8[np.ndarray, "h w 3"]
    patch_of: dict[tuple[str, Colour], int]

    @staticmethod
    def of(finishes: Sequence[tuple[str, Colour]], rng: np.random.Generator) -> "_Atlas":
        distinct = list(dict.fromkeys(finishes))
        # More finishes than places share the patches of earlier ones.
        places = {finish: i % _ATLAS_PATCHES**2 for i, finish in enumerate(distinct)}
        side = _ATLAS_PATCHES * _PATCH_PX
        image = np.zeros((side, side, 3), np.uint8)
        for finish, place in list(places.items())[: _ATLAS_PATCHES**2]:
            row, column = divmod(place, _ATLAS_PATCHES)
            patch = texture(*finish, rng, (_PATCH_PX, _PATCH_PX), (1.0, 1.0))
            image[row * _PATCH_PX : (row + 1) * _PATCH_PX, column * _PATCH_PX : (column + 1) * _PATCH_PX] = patch
        return _Atlas(image, places)

    def place(
        self, uv_m: Float64[np.ndarray, "q 4 2"], patches: Int[np.ndarray, "q"], rng: np.random.Generator
    ) -> Float64[np.ndarray, "q 4 2"]:
        """Texture coordinates on the atlas: each quad at a random place of its patch, never across the edge."""
        extent = uv_m.max(axis=1, keepdims=True)
        margin = 1.0 / _PATCH_PX
        fits = np.minimum(1.0, (1.0 - 2 * margin) / np.maximum(extent, 1e-9))
        offset = margin + rng.random(extent.shape) * (1.0 - 2 * margin - extent * fits)
        row, column = np.divmod(patches, _ATLAS_PATCHES)
        corner = np.stack([column, _ATLAS_PATCHES - 1 - row], axis=-1)[:, None]
        return np.asarray((corner + offset + uv_m * fits) / _ATLAS_PATCHES)


def _add_material(spec: "mujoco.MjSpec", name: str, image: UInt8[np.ndarray, "h w 3"]) -> None:
    texture_2d = spec.add_texture(name=name, type=mujoco.mjtTexture.mjTEXTURE_2D)
    texture_2d.height, texture_2d.width, texture_2d.nchannel = image.shape
    texture_2d.data = image.tobytes()
    material = spec.add_material(name=name, specular=0.0, shininess=0.0, reflectance=0.0)
    material.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = name


def _add_mesh(spec: "mujoco.MjSpec", name: str, material: str, quads: QuadMesh) -> None:
    mesh = spec.add_mesh(name=name, inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL)
    mesh.uservert = quads.corners.reshape(-1)
    mesh.userface = mesh.userfacetexcoord = mesh.userfacenormal = triangles(len(quads.corners)).reshape(-1)
    mesh.usertexcoord = (quads.uv * (1.0, -1.0) + (0.0, 1.0)).reshape(-1)
    mesh.usernormal = np.repeat(quads.normals, 4, axis=0).reshape(-1)
    spec.worldbody.add_geom(
        name=name, type=mujoco.mjtGeom.mjGEOM_MESH, meshname=name, material=material, contype=0, conaffinity=0
    )
