"""House -> MjModel: textured quad meshes, one per surface of a room and per object, under the light asked for.

The geoms are what rays meet and what segmentation tells apart. Beside them the model holds the same quads merged into few
meshes without geoms, which `sim.render.raster` draws: pictures cost by the mesh.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
from jaxtyping import Int32

from sim.render.gl import mujoco
from sim.render.merged_meshes import Merged, merge
from sim.render.visibility import Visibility
from worlds.house import House
from worlds.parts import Colour, Vector
from worlds.visuals.house_visuals import Visual, Visuals, visuals
from worlds.visuals.meshes import triangles

CAMERA = "camera"


@dataclass(frozen=True)
class Light:
    """Two directional lights without shadows, over ambient light; colours are RGB intensities."""

    ambient: Colour
    key: Colour
    key_direction: Vector
    fill: Colour
    sky: tuple[Colour, Colour]
    """At the zenith and at the horizon."""


NO_ROOM = -1

LIGHTS: Mapping[str, Light] = MappingProxyType(
    {
        "day": Light(
            ambient=(0.62, 0.62, 0.62),
            key=(0.34, 0.34, 0.34),
            key_direction=(0.35, 0.55, -0.75),
            fill=(0.16, 0.16, 0.16),
            sky=((0.62, 0.76, 0.92), (0.93, 0.95, 0.97)),
        ),
        "evening": Light(
            ambient=(0.5, 0.41, 0.31),
            key=(0.42, 0.3, 0.17),
            key_direction=(0.6, 0.65, -0.3),
            fill=(0.08, 0.07, 0.1),
            sky=((0.28, 0.32, 0.52), (0.92, 0.6, 0.4)),
        ),
        "dim": Light(
            ambient=(0.2, 0.21, 0.23),
            key=(0.12, 0.12, 0.13),
            key_direction=(0.35, 0.55, -0.75),
            fill=(0.05, 0.05, 0.05),
            sky=((0.1, 0.12, 0.18), (0.2, 0.22, 0.26)),
        ),
    }
)
"""By `AppearanceSpec.light`. Day is bright: features fade in the dark."""


@dataclass(frozen=True, eq=False)
class Scene:
    """A compiled house, ready to render."""

    model: "mujoco.MjModel"
    data: "mujoco.MjData"
    object_of_geom: tuple[str, ...]
    """What each geom shows: a furniture id, `STAIRS_OBJECT`, or "<room id>/<wall|floor|ceiling>"."""
    merged: tuple[Merged, ...]
    """What to draw instead of the geoms; their meshes come after those of the geoms."""
    visibility: Visibility


def build_scene(house: House, size_px: tuple[int, int], fovy_deg: float) -> Scene:
    """Compile `house` with one free camera of `size_px` (width, height) and vertical field of view [deg].

    There are no shadows and no multi-sampling: they cost an order of magnitude in a software renderer.
    """
    seen, visibility = visuals(house), Visibility(house)
    merged = merge(seen.parts, visibility)
    spec = house_mjspec(house, seen)
    for part in merged:
        _add_mesh(spec, part.visual)
    spec.visual.quality.offsamples, spec.visual.quality.shadowsize = 0, 0
    spec.visual.global_.offwidth, spec.visual.global_.offheight = size_px
    body = spec.worldbody.add_body(name=CAMERA, mocap=True)
    body.add_camera(name=CAMERA, fovy=fovy_deg)
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return Scene(model, data, tuple(visual.shows for visual in seen.parts), merged, visibility)


def room_of_geom(house: House, scene: Scene) -> Int32[np.ndarray, "geoms"]:
    """Index into `house.rooms` of each geom, `NO_ROOM` for what is between rooms (doors, windows) and for flights of stairs.

    With ids per pixel this segments rooms: `room_of_geom(house, scene)[frame.geom_ids]`, sky (-1) apart.
    """
    place = {room.id: i for i, room in enumerate(house.rooms)}
    of = {piece.id: place[piece.room] for piece in house.furniture}
    of |= {f"{room}/{kind}": i for room, i in place.items() for kind in ("wall", "floor", "ceiling")}
    return np.array([of.get(name, NO_ROOM) for name in scene.object_of_geom], np.int32)


def house_mjspec(house: House, seen: Visuals, texture_files: Mapping[str, str] | None = None) -> "mujoco.MjSpec":
    """The house as a model to compile, with light and without a camera; geoms in the order of `seen`.

    To save it as XML, its images have to be in files: `texture_files` names them by image.
    """
    spec = mujoco.MjSpec()
    bounds = np.array([room.polygon.bounds for room in house.rooms])
    low, high = bounds[:, :2].min(axis=0), bounds[:, 2:].max(axis=0)
    # Clipping planes scale with the extent: fixed here, so that the size of the house does not change the near plane.
    spec.stat.extent, spec.stat.center = 10.0, [*(low + high) / 2, house.storeys[-1].ceiling_m / 2]
    spec.visual.map.znear, spec.visual.map.zfar = 0.005, 8.0
    _add_light(spec, LIGHTS[house.spec.appearance.light])
    for name, image in seen.images.items():
        texture = _add_material(spec, name)
        if texture_files is None:
            texture.height, texture.width, texture.nchannel = image.shape
            texture.data = image.tobytes()
        else:
            texture.file = texture_files[name]
    for visual in seen.parts:
        _add_mesh(spec, visual)
        spec.worldbody.add_geom(
            name=visual.name, type=mujoco.mjtGeom.mjGEOM_MESH, meshname=visual.name, material=visual.image,
            contype=0, conaffinity=0,
        )  # fmt: skip
    return spec


def _add_light(spec: "mujoco.MjSpec", light: Light) -> None:
    spec.visual.headlight.active = 0
    shared = dict(type=mujoco.mjtLightType.mjLIGHT_DIRECTIONAL, castshadow=False, specular=[0, 0, 0])
    spec.worldbody.add_light(dir=light.key_direction, ambient=light.ambient, diffuse=light.key, **shared)
    spec.worldbody.add_light(dir=[-0.55, -0.35, 0.3], ambient=[0.0] * 3, diffuse=light.fill, **shared)
    zenith, horizon = light.sky
    spec.add_texture(
        name="sky", type=mujoco.mjtTexture.mjTEXTURE_SKYBOX, builtin=mujoco.mjtBuiltin.mjBUILTIN_GRADIENT,
        rgb1=zenith, rgb2=horizon, width=64, height=384,
    )  # fmt: skip


def _add_material(spec: "mujoco.MjSpec", name: str) -> "mujoco.MjsTexture":
    texture: mujoco.MjsTexture = spec.add_texture(name=name, type=mujoco.mjtTexture.mjTEXTURE_2D)
    material = spec.add_material(name=name, specular=0.0, shininess=0.0, reflectance=0.0)
    material.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = name
    return texture


def _add_mesh(spec: "mujoco.MjSpec", visual: Visual) -> None:
    mesh = spec.add_mesh(name=visual.name, inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL)
    mesh.uservert = visual.corners.reshape(-1)
    mesh.userface = mesh.userfacetexcoord = mesh.userfacenormal = triangles(len(visual.corners)).reshape(-1)
    mesh.usertexcoord = (visual.uv * (1.0, -1.0) + (0.0, 1.0)).reshape(-1)
    mesh.usernormal = np.repeat(visual.normals, 4, axis=0).reshape(-1)
