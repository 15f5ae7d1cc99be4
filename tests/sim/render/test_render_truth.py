"""Rendered images are compared with MuJoCo's ray casting, with the analytic house, and with MuJoCo's own plain renderer.

A pixel shows the surface behind its centre. Near a common edge of two surfaces, rounding decides which one that is. Pixels
are therefore compared where all their neighbours show the same geom, and few others may differ. Depth comes from a 32-bit
reversed buffer and from vertices rounded to 32 bits in frames of about 10 m: it is accurate to a micrometre, and to a few
micrometres on walls seen at a grazing angle.
"""

from dataclasses import replace

import numpy as np
import pytest
import shapely
from helpers.viewpoints import viewpoints

from sim.bench.plain import PlainRenderer
from sim.render.camera import CameraRenderer, fovy_deg, wide_camera
from sim.render.gl import mujoco
from sim.render.scene import NO_ROOM, build_scene, room_of_geom
from sim.render.visibility import Visibility
from worlds.house import build_house
from worlds.presets import sample_house
from worlds.truth import room_at
from worlds.visuals.meshes import normals
from worlds.visuals.surfaces import surfaces

CAMERA = wide_camera(160, 120)
SIZE, FOVY = (160, 120), fovy_deg(CAMERA.intrinsics)


@pytest.fixture(scope="module")
def house():
    return build_house(sample_house("home", 3))


@pytest.fixture(scope="module")
def poses(house):
    return viewpoints(house, 15, tilt=0.2)


@pytest.fixture(scope="module")
def scene(house):
    return build_scene(house, SIZE, FOVY)


@pytest.fixture(scope="module")
def frames(scene, poses):
    with CameraRenderer(scene, CAMERA) as renderer:
        return [renderer.frame(T_W_B) for T_W_B in poses]


def rays(T_W_B):
    """Rays from the camera through every pixel, scaled to unit depth, by the camera model that LEXIS uses."""
    v, u = np.mgrid[: SIZE[1], : SIZE[0]]
    T_W_C = T_W_B @ CAMERA.T_B_C
    in_camera = np.stack([u, v, np.ones_like(u)], axis=-1) @ np.linalg.inv(CAMERA.intrinsics.matrix).T
    return T_W_C[:3, 3], in_camera @ T_W_C[:3, :3].T


def cast(scene, start, directions):
    """The first hit of each ray: its geom, and its distance in multiples of the direction's length."""
    count = len(directions)
    geoms, distances = np.zeros(count, np.int32), np.zeros(count)
    flat = np.ascontiguousarray(directions.reshape(-1))
    mujoco.mj_multiRay(scene.model, scene.data, start, flat, None, 1, -1, geoms, distances, None, count, 1e3)
    return geoms, distances


def inner(ids):
    """Pixels whose eight neighbours show the same geom."""
    same = np.zeros(ids.shape, bool)
    middle = ids[1:-1, 1:-1]
    shifted = [ids[1 + i : ids.shape[0] - 1 + i, 1 + j : ids.shape[1] - 1 + j] for i in (-1, 0, 1) for j in (-1, 0, 1)]
    same[1:-1, 1:-1] = np.all([other == middle for other in shifted], axis=0)
    return same


def test_depth_and_ids_are_those_of_rays(scene, poses, frames):
    agreeing, worst = [], []
    for T_W_B, frame in zip(poses[::3], frames[::3], strict=True):
        start, directions = rays(T_W_B)
        ids, depth, where = frame.geom_ids[::2, ::2], frame.depth[::2, ::2], inner(frame.geom_ids)[::2, ::2]
        geoms, distances = (found.reshape(ids.shape) for found in cast(scene, start, directions[::2, ::2].reshape(-1, 3)))
        hit = where & (ids >= 0)
        agreeing.append(np.mean(geoms[where] == ids[where]))
        same = hit & (geoms == ids)
        worst.append(np.quantile(np.abs(distances - depth)[same] / depth[same], 0.999))
    # Thin parts of one object overlap under one id, so that a few per mille of the pixels lie on edges inside objects.
    assert np.mean(agreeing) > 0.999 and max(worst) < 1e-3
    assert np.median(worst) < 1e-4


def test_shell_pixels_lie_on_the_faces_of_the_house(house, scene, poses, frames):
    planes = {}
    for face in surfaces(house):
        (normal,) = normals(face.corners[None])
        planes.setdefault(f"{face.room}/{face.kind}", []).append((normal, normal @ face.corners[0]))
    checked = 0
    for T_W_B, frame in zip(poses, frames, strict=True):
        start, directions = rays(T_W_B)
        points = start + directions * frame.depth[..., None]
        for geom in np.unique(frame.geom_ids[frame.geom_ids >= 0]):
            faces = planes.get(scene.object_of_geom[geom])
            if faces is not None:
                across, offsets = map(np.array, zip(*faces, strict=True))
                distance = np.abs(points[frame.geom_ids == geom] @ across.T - offsets).min(axis=1)
                assert distance.max() < 1e-4
                checked += len(distance)
    assert checked > 0.3 * len(poses) * SIZE[0] * SIZE[1]


def test_floors_and_ceilings_are_where_the_polygons_are(house, scene, poses, frames):
    """Uses the floor plan alone: no mesh and no surfaces."""
    rooms = {room.id: room for room in house.rooms}
    for T_W_B, frame in zip(poses, frames, strict=True):
        start, directions = rays(T_W_B)
        points = start + directions * frame.depth[..., None]
        for geom in np.unique(frame.geom_ids[frame.geom_ids >= 0]):
            name, _, kind = scene.object_of_geom[geom].rpartition("/")
            if kind == "floor" and name in rooms:
                x, y, z = points[frame.geom_ids == geom].T
                # Enlarged by half a wall: the floor under the doors.
                assert shapely.contains_xy(rooms[name].polygon.buffer(0.051, join_style="mitre"), x, y).all()
                assert np.abs(z - rooms[name].floor_m).max() < 1e-4


def test_rooms_are_segmented_as_the_polygons_say(house, scene, poses, frames):
    """A pixel of a floor or of furniture shows a point that lies in the pixel's room."""
    room_of = room_of_geom(house, scene)
    standing = np.array([name.endswith("/floor") or "/" not in name for name in scene.object_of_geom])
    checked = agreeing = 0
    for T_W_B, frame in zip(poses, frames, strict=True):
        start, directions = rays(T_W_B)
        where = inner(frame.geom_ids) & (frame.geom_ids >= 0)
        where &= standing[frame.geom_ids] & (room_of[frame.geom_ids] != NO_ROOM)
        points = (start + directions * frame.depth[..., None])[where]
        agreeing += np.sum(room_at(house, points + [0.0, 0.0, 1e-3]) == room_of[frame.geom_ids[where]])
        checked += len(points)
    # An object that extends over an edge, such as a rug in a doorway, counts for the room that it belongs to.
    assert checked > 0.2 * len(poses) * SIZE[0] * SIZE[1] and agreeing > 0.99 * checked


def test_a_camera_in_a_room_by_the_polygons_is_in_it_by_rays():
    """The ray down hits the room's floor, the ray up its ceiling, and the others its walls or pass through its openings."""
    spec = sample_house("home", 3)
    bare = tuple(storey.model_copy(update={"furniture": (), "windows": ()}) for storey in spec.storeys)
    house = build_house(spec.model_copy(update={"storeys": bare}))
    scene = build_scene(house, (32, 32), 60.0)
    poses = viewpoints(house, 60, seed=4)
    inside = [house.rooms[i] for i in room_at(house, poses[:, :3, 3])]
    angles = np.linspace(0.0, 2 * np.pi, 16, endpoint=False)
    around = np.column_stack([np.cos(angles), np.sin(angles), np.zeros(16)])
    for T_W_B, room in zip(poses, inside, strict=True):
        down, up, *level = cast(scene, T_W_B[:3, 3], np.concatenate([[[0, 0, -1], [0, 0, 1]], around]))[0]
        assert scene.object_of_geom[down] == f"{room.id}/floor"
        assert room.outdoor or scene.object_of_geom[up] == f"{room.id}/ceiling"
        assert room.outdoor or f"{room.id}/wall" in {scene.object_of_geom[geom] for geom in level if geom >= 0}


@pytest.mark.parametrize(("preset", "seed"), [("home", 3), ("uh2-office", 2), ("random", 3)])
def test_what_is_not_drawn_is_not_seen(preset, seed):
    house = build_house(sample_house(preset, seed))
    scene = build_scene(house, SIZE, FOVY)
    poses = np.concatenate([viewpoints(house, 20, seed=1, tilt=0.4), viewpoints(house, 10, seed=2, tilt=np.pi / 2)])
    poses[::5, :3, 3] = [[*_middle_of_an_opening(house, i), T[2, 3]] for i, T in enumerate(poses[::5])]
    everything = replace(scene, visibility=_Everything(house))
    hidden = 0
    with CameraRenderer(scene, CAMERA) as renderer, CameraRenderer(everything, CAMERA) as other:
        for T_W_B in poses:
            assert np.array_equal(renderer.rgb(T_W_B), other.rgb(T_W_B))
            hidden += len(scene.visibility.all - scene.visibility.seen(T_W_B @ CAMERA.T_B_C, CAMERA.intrinsics))
    assert hidden > 0.5 * len(poses) * len(scene.visibility.all)


def _middle_of_an_opening(house, i):
    openings = house.spec.storeys[0].openings
    opening = openings[i % len(openings)]
    return np.mean([opening.start_m, opening.end_m], axis=0)


class _Everything(Visibility):
    def seen(self, T_W_C, intrinsics):
        return self.all


def test_pictures_are_those_of_a_plain_renderer(house, poses):
    """The reference model has a geom for every part. Within 2 grey levels on 99.9 % of the pixels of every view."""
    plain = PlainRenderer(house, CAMERA)
    assert plain.model.ngeom >= 1000
    with CameraRenderer(build_scene(house, SIZE, FOVY), CAMERA) as renderer:
        for T_W_B in poses:
            worst = np.abs(renderer.rgb(T_W_B).astype(int) - plain.rgb(T_W_B)).max(axis=-1)
            assert np.mean(worst <= 2) >= 0.999
    plain.close()
