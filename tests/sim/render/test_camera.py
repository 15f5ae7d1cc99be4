"""The renderer: its images, its lifetime and its limits. `test_render_truth` checks the contents of the images."""

import os
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

import numpy as np
import pytest
from helpers.viewpoints import viewpoints

from sim.errors import GraphicsError
from sim.render.camera import CameraRenderer, fovy_deg, wide_camera
from sim.render.raster import NO_GEOM
from sim.render.scene import build_scene
from worlds.house import build_house
from worlds.parts import Part
from worlds.presets import sample_house
from worlds.spec import HouseSpec, RoomSpec, StoreySpec
from worlds.visuals.meshes import Solid

CAMERA = wide_camera(160, 120)
SIZE, FOVY = (160, 120), fovy_deg(CAMERA.intrinsics)


@pytest.fixture(scope="module")
def house():
    return build_house(sample_house("uh2-apt", 3))


@pytest.fixture(scope="module")
def poses(house):
    return viewpoints(house, 12)


@pytest.fixture(scope="module")
def renderer(house):
    with CameraRenderer(build_scene(house, SIZE, FOVY), CAMERA) as renderer:
        yield renderer


def test_a_new_renderer_of_the_same_house_gives_the_same_images(house, poses, renderer):
    with CameraRenderer(build_scene(house, SIZE, FOVY), CAMERA) as other:
        theirs = [other.rgb(T) for T in poses]
    for T_W_B, image in zip(poses, theirs, strict=True):  # closing the newer renderer left the older one intact
        assert np.array_equal(renderer.rgb(T_W_B), image)


def test_images_show_something(poses, renderer):
    for T_W_B in poses:
        assert renderer.rgb(T_W_B).std() > 10


def test_the_field_of_view_is_the_one_asked_for():
    for degrees in (60.0, 100.0, 120.0):
        k = wide_camera(640, 480, degrees).intrinsics
        left = np.arctan((k.cx + 0.5) / k.fx)
        right = np.arctan((k.width - 0.5 - k.cx) / k.fx)
        assert np.degrees(left + right) == pytest.approx(degrees)


def test_a_frame_is_its_picture_depth_and_ids(poses, renderer):
    for T_W_B in poses[:4]:
        frame = renderer.frame(T_W_B)
        assert np.array_equal(frame.rgb, renderer.rgb(T_W_B))
        assert np.array_equal(frame.depth, renderer.depth(T_W_B))
        assert np.array_equal(frame.geom_ids, renderer.geom_ids(T_W_B))


def seen_by_camera(T_W_B, ahead_m):
    """A small red ball on the camera's axis."""
    x, y, z = (T_W_B @ CAMERA.T_B_C @ (0.0, 0.0, ahead_m, 1.0))[:3].tolist()
    return Solid((Part("ball", (0.0, 0.0, 0.0), (0.1, 0.1, 0.1), (1.0, 0.0, 0.0)),), (x, y, z), 0.0)


def test_moving_things_hide_what_is_behind_them_and_are_no_geoms(house, poses):
    with CameraRenderer(build_scene(house, SIZE, FOVY), CAMERA) as own:
        empty = own.frame(poses[0])
        own.place([seen_by_camera(poses[0], 0.3)] * 2)
        frame = own.frame(poses[0])
        hidden = frame.geom_ids == NO_GEOM
        assert hidden[60, 80] and not (empty.geom_ids == NO_GEOM)[60, 80]
        assert np.array_equal(frame.geom_ids[~hidden], empty.geom_ids[~hidden])
        own.place(())
        assert np.array_equal(own.geom_ids(poses[0]), empty.geom_ids)


def test_any_number_of_moving_parts_is_drawn(house, poses):
    """A house with 150 doors that close has more than a thousand of them."""
    grain, ball = seen_by_camera(poses[0], -900.0), seen_by_camera(poses[0], 0.3)
    with CameraRenderer(build_scene(house, SIZE, FOVY), CAMERA) as own:
        own.place((ball,))
        few = own.frame(poses[0])
        own.place((*[grain] * 3000, ball))
        many = own.frame(poses[0])
        assert np.array_equal(few.rgb, many.rgb) and np.array_equal(few.geom_ids, many.geom_ids)


def test_closing_an_old_renderer_leaves_a_newer_one_whole(house, poses, renderer):
    scene = build_scene(house, SIZE, FOVY)
    old, new = CameraRenderer(scene, CAMERA), CameraRenderer(scene, CAMERA)
    expected = old.rgb(poses[0])
    old.close()
    old.close()  # closing it twice does no harm
    assert np.array_equal(new.rgb(poses[0]), expected)
    new.close()
    with pytest.raises(GraphicsError, match="closed"):
        new.rgb(poses[0])
    assert np.array_equal(renderer.rgb(poses[0]), expected)


def test_images_larger_than_the_scenes_are_refused(house, poses):
    with (
        CameraRenderer(build_scene(house, SIZE, FOVY), wide_camera(200, 120)) as renderer,
        pytest.raises(GraphicsError, match="200 x 120 px; valid: up to 160 x 120 px, which the scene was built for"),
    ):
        renderer.rgb(poses[0])


def bare_room():
    """The cheapest possible scene."""
    corners = ((0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0))
    room = RoomSpec(id="room", label="office", polygon_m=corners)
    return build_house(HouseSpec(storeys=(StoreySpec(rooms=(room,), windows=(), furniture=()),)))


def in_the_middle():
    T_W_B = np.eye(4)
    T_W_B[:3, 3] = 1.0, 1.0, 1.4
    return T_W_B


def resident_mb():
    with open("/proc/self/statm", encoding="utf-8") as file:
        return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 1e6


def grown_mb(renderers):
    scene, sizes = build_scene(bare_room(), SIZE, FOVY), []
    for _ in range(renderers):
        with CameraRenderer(scene, CAMERA) as renderer:
            renderer.rgb(in_the_middle())
        sizes.append(resident_mb())
    return sizes[-1] - sizes[min(9, renderers // 2)]  # the first renderers fill the driver's caches


@pytest.mark.skipif(not os.path.exists("/proc/self/statm"), reason="reads Linux's /proc")
def test_renderers_leave_no_memory_behind():
    assert grown_mb(20) < 4.0


@pytest.mark.slow
def test_two_hundred_renderers_leave_no_memory_behind():
    assert grown_mb(200) < 8.0


def mean_grey(count):
    with CameraRenderer(build_scene(bare_room(), SIZE, FOVY), CAMERA) as renderer:
        return [float(renderer.rgb(in_the_middle()).mean()) for _ in range(count)]


def test_two_processes_render_at_once():
    with ProcessPoolExecutor(2, get_context("spawn")) as pool:
        one, other = pool.map(mean_grey, (20, 20))
    assert one == other and len(set(one)) == 1 and one[0] > 10
