"""A session yields what a robot would sense, in order, and keeps the truth out of it."""

import gc
import threading
from contextlib import closing
from dataclasses import fields, replace

import numpy as np
import pytest

from lexis.maths.quaternions import pose_rows, poses_of
from lexis.types import Observation
from sim.errors import SimError
from sim.faults.delivery import Dropped, Duplicated, Frozen
from sim.faults.images import Blur, Noise
from sim.faults.poses import Kidnap, OdometryFreeze, OdometryJump
from sim.faults.stamps import StampJitter
from sim.faults.world import MovedFurniture
from sim.odometry.config import ODOMETRY_PRESETS
from sim.odometry.simulation import simulate_odometry
from sim.prefetch import THREAD
from sim.render.camera import CameraRenderer, wide_camera
from sim.render.lens import Distortion
from sim.render.rig import displaced, make_rig
from sim.session import Session
from sim.tours.tour import Tour, plan_tour
from worlds.house import build_house
from worlds.presets import sample_house
from worlds.walkable import Walkable

FRAMES = 40
GUARD_S = 20.0
"""Only a thread that hangs takes that long [s]."""


@pytest.fixture(scope="module")
def session():
    house = build_house(sample_house("uh2-apt", 5))
    tour = plan_tour(house, Walkable(house), np.random.default_rng(1))
    short = Tour(tour.stamps[:FRAMES], tour.T_W_B[:FRAMES], tour.motion, tour.eye_height_m)
    odometry = simulate_odometry(short.T_W_B, short.stamps, ODOMETRY_PRESETS["mono"], np.random.default_rng(2))
    return Session(house, short, odometry, wide_camera(160, 120))


@pytest.fixture(scope="module")
def pairs(session):
    return list(session)


def test_one_pair_per_frame_in_the_order_of_time(session, pairs):
    assert len(pairs) == len(session) == FRAMES
    assert [o.index for o, _ in pairs] == [t.index for _, t in pairs] == list(range(FRAMES))
    assert (np.diff([o.stamp for o, _ in pairs]) > 0).all()


def test_kept_images_are_rendered_once_and_whatever_is_done_to_them(session, pairs):
    kept = Session(session.house, session.tour, session.odometry, session.camera, keeps_images=True)
    with closing(iter(kept)) as stopped:
        next(stopped)
    for seconds_grow in (True, False, False):
        before = kept.render_seconds
        for (observation, _), (expected, _) in zip(kept, pairs, strict=True):
            assert np.array_equal(observation.image, expected.image)
            observation.image[...] = 0  # as a SLAM may do
        assert (kept.render_seconds > before) == seconds_grow


def test_pictures_are_the_images_of_the_walk_in_the_changed_world(session):
    """Furniture that a fault has moved is where the SLAM saw it."""
    moved = Session(session.house, session.tour, session.odometry, session.camera, (MovedFurniture(1.0),), 3)
    images = {observation.index: observation.image for observation, _ in moved}
    frames = range(0, FRAMES, FRAMES // 5)
    for frame, picture in zip(frames, moved.pictures(frames), strict=True):
        assert np.array_equal(picture, images[frame])
    assert not moved.faults_of_images


def test_faults_of_images_are_those_that_pictures_do_not_show(session, pairs):
    faulty = Session(session.house, session.tour, session.odometry, session.camera, (Blur(5), StampJitter(0.01)), 3)
    assert faulty.faults_of_images == ("blur",)
    frozen = Session(session.house, session.tour, session.odometry, session.camera, (Frozen(),), 3)
    assert frozen.faults_of_images == ("frozen",)
    assert np.array_equal(faulty.pictures([3])[0], pairs[3][0].image)


POSES_CHANGE = (
    Duplicated(0.3),
    OdometryJump(1.0),
    OdometryFreeze(at_s=1.0, for_s=0.5),
    Kidnap(1.0, skip_s=0.5),
    Dropped(0.3),
)


@pytest.mark.parametrize("fault", POSES_CHANGE, ids=lambda fault: fault.name)
def test_whatever_the_slam_writes_into_an_observation_no_later_one_changes(session, fault):
    faulty = Session(session.house, session.tour, session.odometry, session.camera, (fault,), 3, keeps_images=True)
    expected = [(each.T_O_B.copy(), each.increment_covariance.copy(), each.image.copy()) for each, _ in faulty]
    for (observation, _), unchanged in zip(faulty, expected, strict=True):
        given = observation.T_O_B, observation.increment_covariance, observation.image
        assert all(np.array_equal(a, b) for a, b in zip(given, unchanged, strict=True))
        for array in given:
            array[...] = 0


@pytest.mark.parametrize("fault", POSES_CHANGE, ids=lambda fault: fault.name)
def test_poses_are_the_same_to_the_last_bit_after_they_were_written_as_quaternions(session, fault):
    faulty = Session(session.house, session.tour, session.odometry, session.camera, (fault,), 3, keeps_images=True)
    T_O_B = np.array([observation.T_O_B for observation, _ in faulty])
    np.testing.assert_array_equal(poses_of(pose_rows(T_O_B)), T_O_B)


def test_images_are_the_renderer_s(session, pairs):
    with CameraRenderer(session.scene, session.camera) as renderer:
        for observation, truth in pairs[:: FRAMES // 5]:
            assert np.array_equal(observation.image, renderer.rgb(truth.T_W_B))


def test_a_rig_yields_the_images_of_all_cameras_at_the_same_time(session, pairs):
    """The rear camera sees what the front camera would see from a body that is turned round."""
    rig = displaced(make_rig("front-rear", 160, 120), (0.05, 0.0, 0.0))
    both = Session(session.house, session.tour, session.odometry, rig.front, (Noise(20.0), Frozen(0.5, 2)), 3)
    front, rear = rig.cameras.values()
    seen = list(both)
    with CameraRenderer(both.scene, front) as ahead, CameraRenderer(both.scene, rear) as behind:
        for observation, truth in seen[:: FRAMES // 5]:
            if "frozen" in truth.faults:
                continue
            (image,) = observation.others
            for noisy, clean in ((observation.image, ahead.rgb(truth.T_W_B)), (image, behind.rgb(truth.T_W_B))):
                assert 5.0 < np.abs(noisy.astype(float) - clean).mean() < 20.0
    frozen = [i for i, (_, truth) in enumerate(seen) if "frozen" in truth.faults and i]
    assert frozen
    for i in frozen:
        assert all(np.array_equal(a, b) for a, b in zip(seen[i][0].images, seen[i - 1][0].images, strict=True))


@pytest.mark.parametrize("distortion", [None, Distortion(-0.05, 0.002)], ids=["pinhole", "distorted"])
def test_every_camera_of_a_rig_has_images_of_its_own_size(session, distortion):
    sizes = [(160, 120), (200, 100), (80, 240)]
    first, *others = (wide_camera(*size, 80.0) for size in sizes)
    short = replace(session.tour, stamps=session.tour.stamps[:2], T_W_B=session.tour.T_W_B[:2])
    camera = replace(first, others=tuple(others))
    mixed = Session(session.house, short, session.odometry, camera, distortion=distortion)
    for observation, _ in mixed:
        assert [image.shape[1::-1] for image in observation.images] == sizes


def test_a_second_pass_is_the_same(session, pairs):
    for (first, _), (again, _) in zip(pairs, session, strict=True):
        assert np.array_equal(first.image, again.image) and np.array_equal(first.T_O_B, again.T_O_B)


def threads_of_sessions():
    return [thread for thread in threading.enumerate() if thread.name == THREAD]


def test_leaving_early_ends_the_thread_that_renders(session):
    with closing(iter(session)) as pairs:
        assert next(pairs)[0].index == 0 and threads_of_sessions()
    for thread in threads_of_sessions():
        thread.join(GUARD_S)
    assert not threads_of_sessions()


def test_an_iterator_in_garbage_is_collected_without_waiting(session):
    """This happens after an exception, whose traceback keeps the iterating frames: the whole cycle is collected at once."""

    def abandon():
        cycle = [iter(session)]
        next(cycle[0])
        cycle.append(cycle)
        del cycle
        gc.collect()

    guard = threading.Thread(target=abandon, daemon=True)
    guard.start()
    guard.join(GUARD_S)
    assert not guard.is_alive()
    for thread in threads_of_sessions():
        thread.join(GUARD_S)
    assert not threads_of_sessions()


def test_an_observation_has_no_place_for_truth(session, pairs):
    sensed = {"index", "stamp", "image", "others", "T_O_B", "increment_covariance"}
    assert {field.name for field in fields(Observation)} == sensed
    last_seen, last_true = pairs[-1]
    assert not np.allclose(last_seen.T_O_B, last_true.T_W_B)


def test_a_tour_that_leaves_the_house_is_refused(session):
    away = replace(session.tour, T_W_B=session.tour.T_W_B + np.array([0.0, 0.0, 0.0, 500.0])[None, None, :])
    with pytest.raises(SimError, match=r"frame 0 at .* is in no room; valid"):
        Session(session.house, away, session.odometry, session.camera)


def test_truth_names_the_room_that_holds_the_camera(session, pairs):
    for _, truth in pairs:
        room = session.house.rooms[truth.room]
        x, y, z = truth.T_W_B[:3, 3]
        x0, y0, x1, y1 = room.polygon.bounds
        assert x0 <= x <= x1 and y0 <= y <= y1 and room.floor_m < z < room.ceiling_m and truth.label == room.label
