"""Builds the MuJoCo model of a house: a textured mesh for each surface of a room and for each object, and the lighting.

Each of these meshes has a geom, for ray casts and segmentation. The model also holds the faces of all these meshes a second
time, merged into a few meshes without geoms. `sim.render.raster` draws the merged meshes, because the time to render an
image grows with the number of meshes.
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
from worlds.spec import LightName
from worlds.visuals.house_visuals import Visual, Visuals, visuals
from worlds.visuals.meshes import triangles
from worlds.visuals.surfaces import SURFACE_KINDS

CAMERA = "camera"
"""Name of the model's camera, which can be placed freely, and of the body that carries it."""


@dataclass(frozen=True)
class Light:
    """A lighting condition: two directional lights without shadows, and ambient light. Colours are RGB intensities."""

    ambient: Colour
    key: Colour
    key_direction: Vector
    fill: Colour
    sky: tuple[Colour, Colour]
    """Colours of the sky at the zenith and at the horizon."""


NO_ROOM = -1
"""Index in place of a room's index, for geoms that belong to no room or to several rooms."""

LIGHTS: Mapping[LightName, Light] = MappingProxyType(
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
"""Lighting conditions by name, the values of `AppearanceSpec.light`. In brighter light, more image features are found."""


@dataclass(frozen=True, eq=False)
class Scene:
    """A house, compiled as a MuJoCo model and ready to render."""

    model: "mujoco.MjModel"
    data: "mujoco.MjData"
    object_of_geom: tuple[str, ...]
    """For each geom id, what the geom belongs to: the id of a piece of furniture, a door leaf or a window; `STAIRS_OBJECT`
    for stairs; or "<room id>/<wall|floor|ceiling>"."""
    merged: tuple[Merged, ...]
    """Meshes to draw in place of the geoms. In the model, these meshes come after the meshes of the geoms."""
    visibility: Visibility


def build_scene(house: House, size_px: tuple[int, int], fovy_deg: float) -> Scene:
    """Compile `house` with one camera, which has images of up to `size_px` (width, height) and the field of view `fovy_deg`.

    Shadows and multi-sampling are off, because they make a software renderer ten times slower.
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
    """Return the room of each geom as an index into `house.rooms`; `NO_ROOM` for doors, windows and flights of stairs.

    `room_of_geom(house, scene)[frame.geom_ids]` segments an image by rooms, except for pixels with the id -1 (sky and moving
    things), whose values are wrong.
    """
    place = {room.id: i for i, room in enumerate(house.rooms)}
    of = {piece.id: place[piece.room] for piece in house.furniture}
    of |= {f"{room}/{kind}": i for room, i in place.items() for kind in SURFACE_KINDS}
    return np.array([of.get(name, NO_ROOM) for name in scene.object_of_geom], np.int32)


def house_mjspec(house: House, seen: Visuals, texture_files: Mapping[str, str] | None = None) -> "mujoco.MjSpec":
    """Build the MuJoCo model of a house, ready to compile, with lighting but without a camera.

    The geoms are in the order of `seen.parts`. If the model is to be saved as XML, textures have to be in files:
    `texture_files` then maps the name of each image to its file.
    """
    spec = mujoco.MjSpec()
    bounds = np.array([room.polygon.bounds for room in house.rooms])
    low, high = bounds[:, :2].min(axis=0), bounds[:, 2:].max(axis=0)
    # MuJoCo scales the clipping planes by the extent. A fixed extent keeps the near plane the same for every house.
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
