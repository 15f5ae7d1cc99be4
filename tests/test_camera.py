"""The renderer against the analytic house: back-projected pixels lie on its floors, ceilings and walls."""

import numpy as np
import pytest

from sim.camera import CameraRenderer, fovy_deg, wide_camera
from sim.scene import build_scene
from sim.tour import plan_tour
from worlds.house import build_house
from worlds.meshes import normals
from worlds.presets import sample_house
from worlds.surfaces import surfaces
from worlds.walkable import Walkable

CAMERA = wide_camera(160, 120)
SIZE, FOVY = (160, 120), fovy_deg(CAMERA.intrinsics)


@pytest.fixture(scope="module")
def house():
    return build_house(sample_house("uh2-apt", 3))


@pytest.fixture(scope="module")
def poses(house):
    tour = plan_tour(house, Walkable(house), np.random.default_rng(0))
    return tour.T_W_B[np.linspace(0, len(tour.T_W_B) - 1, 12).astype(int)]


@pytest.fixture(scope="module")
def renderer(house):
    with CameraRenderer(build_scene(house, SIZE, FOVY), CAMERA) as renderer:
        yield renderer


def back_projected(depth, T_W_B):
    """Every pixel's point in W, by the camera model that LEXIS is given."""
    intrinsics = CAMERA.intrinsics
    v, u = np.mgrid[: intrinsics.height, : intrinsics.width]
    rays = np.stack([u, v, np.ones_like(u)], axis=-1) @ np.linalg.inv(intrinsics.matrix).T
    T_W_C = T_W_B @ CAMERA.T_B_C
    return (rays * depth[..., None]) @ T_W_C[:3, :3].T + T_W_C[:3, 3]


def test_depth_and_segmentation_agree_with_the_house(house, poses, renderer):
    planes = {}
    for face in surfaces(house):
        (normal,) = normals(face.corners[None])
        planes.setdefault(f"{face.room}/{face.kind}", []).append((normal, normal @ face.corners[0]))
    names = renderer.scene.object_of_geom
    checked = 0
    for T_W_B in poses:
        points, ids = back_projected(renderer.depth(T_W_B), T_W_B), renderer.geom_ids(T_W_B)
        for geom in np.unique(ids[ids >= 0]):
            if names[geom] not in planes:
                continue
            normals, offsets = map(np.array, zip(*planes[names[geom]], strict=True))
            distance = np.abs(points[ids == geom] @ normals.T - offsets).min(axis=1)
            assert np.quantile(distance, 0.99) < 0.02
            checked += len(distance)
    assert checked > 0.3 * len(poses) * SIZE[0] * SIZE[1]


def test_what_stands_in_front_hides_what_is_behind(poses, renderer):
    """Furniture, walls and floors are all nearer than the far plane wherever something is seen."""
    for T_W_B in poses:
        seen = renderer.geom_ids(T_W_B) >= 0
        assert (renderer.depth(T_W_B)[seen] < 40.0).all() and seen.any()


def test_a_new_renderer_of_the_same_house_gives_the_same_images(house, poses, renderer):
    with CameraRenderer(build_scene(house, SIZE, FOVY), CAMERA) as other:
        theirs = [other.rgb(T) for T in poses]
    for T_W_B, image in zip(poses, theirs, strict=True):  # and closing the newer one left the older one whole
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
