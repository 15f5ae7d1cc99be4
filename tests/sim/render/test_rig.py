"""Camera rigs: every camera projects known corners according to its calibration, a fisheye as exactly as a pinhole."""

import numpy as np
import pytest
from helpers.viewpoints import viewpoints

from sim.errors import SimError
from sim.render.fisheye import Fisheye
from sim.render.gl import mujoco
from sim.render.rig import RIGS, STEREO_BASELINE_M, Rig, RigRenderer, build_rig_scene, displaced, make_rig
from worlds.house import build_house
from worlds.presets import sample_house
from worlds.spec import FurnitureSpec, HouseSpec, RoomSpec, StoreySpec
from worlds.visuals.house_visuals import visuals

BOXES = {"ahead": (4.5, 2.2), "behind": (0.7, 1.8), "left": (2.2, 3.5), "right": (2.8, 0.6)}
EYE = (2.5, 2.0, 0.9)


@pytest.fixture(scope="module")
def box_room():
    """An empty room of 5 x 4 m with a square object in the middle of each side."""
    room = RoomSpec(id="room", label="office", polygon_m=((0.0, 0.0), (5.0, 0.0), (5.0, 4.0), (0.0, 4.0)))
    boxes = tuple(
        FurnitureSpec(
            id=name, kind="dresser", room="room", position_m=(*place, 0.0), yaw_rad=0.3, size_m=(0.5, 0.4, 0.8), seed=i
        )
        for i, (name, place) in enumerate(BOXES.items())
    )
    return build_house(HouseSpec(storeys=(StoreySpec(rooms=(room,), windows=(), furniture=boxes),)))


def body(yaw=0.0):
    T_W_B = np.eye(4)
    T_W_B[:2, :2] = [[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]]
    T_W_B[:3, 3] = EYE
    return T_W_B


@pytest.mark.parametrize("name", RIGS)
def test_corners_are_seen_where_they_project_to(box_room, name):
    corners_of = {visual.shows: visual.corners.reshape(-1, 3) for visual in visuals(box_room).parts}
    rig = make_rig(name, 320, 240)
    scene = build_rig_scene(box_room, rig)
    found = dict.fromkeys(rig.cameras, 0)
    with RigRenderer(scene, rig) as renderer:
        for yaw in (0.0, 0.15, -0.2):
            frames = renderer.frames(body(yaw))
            for camera, eye in rig.cameras.items():
                k = eye.intrinsics
                for thing in BOXES:
                    T_C_W = np.linalg.inv(body(yaw) @ eye.T_B_C)
                    points = corners_of[thing] @ T_C_W[:3, :3].T + T_C_W[:3, 3]
                    pixels = points @ k.matrix.T
                    pixels = pixels[:, :2] / pixels[:, 2:]
                    low, high = pixels.min(axis=0), pixels.max(axis=0)
                    if points[:, 2].min() < 0.1 or (low < 2).any() or (high > np.array([k.width, k.height]) - 3).any():
                        continue
                    v, u = np.nonzero(frames[camera].geom_ids == scene.object_of_geom.index(thing))
                    # A pixel shows the object if its centre does, so the outermost are less than a pixel inside its edges.
                    seen_low, seen_high = np.array([u.min(), v.min()]), np.array([u.max(), v.max()])
                    assert ((seen_low > low - 0.05) & (seen_low < low + 1.3)).all()
                    assert ((seen_high < high + 0.05) & (seen_high > high - 1.3)).all()
                    found[camera] += 1
    assert all(found.values())


def test_rigs_look_where_they_say():
    ahead = {camera: eye.T_B_C[:3, 2].round(9).tolist() for camera, eye in make_rig("four").cameras.items()}
    assert ahead == {
        "front left": [1, 0, 0], "front right": [1, 0, 0], "lateral left": [0, 1, 0], "lateral right": [0, -1, 0]
    }  # fmt: skip
    left, right = make_rig("stereo").cameras.values()
    assert np.allclose(np.linalg.inv(left.T_B_C) @ right.T_B_C[:, 3], [STEREO_BASELINE_M, 0, 0, 1])
    assert np.allclose(make_rig("front-rear").cameras["rear"].T_B_C[:3, 2], [-1, 0, 0])
    for name in RIGS:
        for eye in make_rig(name).cameras.values():
            assert np.allclose(eye.T_B_C[:3, :3] @ eye.T_B_C[:3, :3].T, np.eye(3))
            assert np.linalg.det(eye.T_B_C[:3, :3]) == pytest.approx(1.0)


def test_stereo_disparity_is_baseline_over_depth(box_room):
    rig = make_rig("stereo", 320, 240)
    with RigRenderer(build_rig_scene(box_room, rig), rig) as renderer:
        frames = renderer.frames(body())
    k = rig.front.intrinsics
    depth, row = frames["left"].depth[60], np.arange(320)
    across = np.rint(row - k.fx * STEREO_BASELINE_M / depth).astype(int)
    both = across >= 0
    there = frames["right"].depth[60][across[both]]
    assert np.median(np.abs(there - depth[both])) < 0.01


def test_a_displaced_rig_is_moved_and_turned_as_one():
    rig, moved = make_rig("four"), displaced(make_rig("four"), (0.1, 0.0, -0.05), (0.0, 0.0, 90.0))
    T = moved.front.T_B_C @ np.linalg.inv(rig.front.T_B_C)
    np.testing.assert_allclose(T, [[0, -1, 0, 0.1], [1, 0, 0, 0], [0, 0, 1, -0.05], [0, 0, 0, 1]], atol=1e-12)
    for name, camera in rig.cameras.items():
        np.testing.assert_allclose(moved.cameras[name].T_B_C, T @ camera.T_B_C, atol=1e-12)
    eye = displaced(make_rig("fisheye"), (0.0, 0.1, 0.0)).fisheyes["fisheye"]
    assert eye.T_B_C[1, 3] == pytest.approx(0.1)
    with pytest.raises(SimError, match=r"lever arm .*; valid: .* up to 0\.15 m from the IMU"):
        displaced(rig, (0.2, 0.0, 0.0))


def test_unknown_rigs_are_named():
    with pytest.raises(SimError, match=r"unknown rig 'spider'.*; valid: wide, stereo, front-rear, four, fisheye"):
        make_rig("spider")
    with pytest.raises(SimError, match="fisheye: 480 px and 300"):
        Fisheye(480, 300.0, np.eye(4))


def test_equidistant_rays():
    rays, valid = Fisheye(201, 180.0, np.eye(4)).rays()
    assert np.allclose(np.linalg.norm(rays, axis=-1), 1.0)
    assert np.allclose(rays[100, 100], [0, 0, 1])
    angle = np.degrees(np.arccos(rays[100, :, 2]))
    assert np.allclose(np.diff(angle[100:]), 180 / 201)  # identical in every direction
    assert valid[100].all() and not valid[0, 0] and rays[100, 150, 0] > 0 and rays[150, 100, 1] > 0


@pytest.mark.parametrize("fov_deg", [120.0, 180.0, 220.0])
def test_a_fisheye_sees_what_rays_meet(fov_deg):
    house = build_house(sample_house("uh2-apt", 3))
    T_B_C = make_rig("wide").front.T_B_C
    fisheye = Fisheye(160, fov_deg, T_B_C)
    rig = Rig("test", make_rig("wide", 64, 48).cameras, {"eye": fisheye})
    scene = build_rig_scene(house, rig)
    rays, valid = fisheye.rays()
    with RigRenderer(scene, rig) as renderer:
        for T_W_B in viewpoints(house, 4, tilt=0.3):
            frame = renderer.frames(T_W_B)["eye"]
            T_W_C = T_W_B @ T_B_C
            geoms, distances = np.zeros(valid.sum(), np.int32), np.zeros(valid.sum())
            directions = (rays[valid] @ T_W_C[:3, :3].T).reshape(-1)
            mujoco.mj_multiRay(
                scene.model, scene.data, T_W_C[:3, 3], directions, None, 1, -1, geoms, distances, None, len(geoms), 1e3
            )
            same = (geoms == frame.geom_ids[valid]) & (geoms >= 0)
            # The label of a pixel is that of the nearest pixel of a cube face: up to half a pixel off where two geoms meet.
            assert same.sum() > 0.96 * (geoms >= 0).sum()
            error = np.abs(frame.depth[valid] - distances)[same] / distances[same]
            flat = np.array([scene.object_of_geom[geom].endswith(("floor", "ceiling")) for geom in geoms[same]])
            # Exact on planes; where two geoms meet, the depth is that of a ray half a pixel off.
            assert np.quantile(error[flat], 0.9) < 1e-5 and np.quantile(error, 0.95) < 0.02
            assert (frame.depth[~valid] == 0).all() and (frame.geom_ids[~valid] == -1).all()
