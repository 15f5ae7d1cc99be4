from dataclasses import replace

import numpy as np
import pytest

from lexis.config import KeyframeConfig
from lexis.inputs import MAX_VARIANCE, usable_covariances
from lexis.keyframes import KeyframeSelector
from lexis.maths import se3
from lexis.types import Observation

IMAGE = np.zeros((4, 4, 3), np.uint8)
COVARIANCE = np.diag([1e-6, 1e-6, 1e-6, 1e-4, 1e-4, 1e-4])


def observations(T_O_B):
    return [Observation(i, 0.1 * i, IMAGE, T, COVARIANCE) for i, T in enumerate(T_O_B)]


def straight(step_m, count):
    T = np.tile(np.eye(4), (count, 1, 1))
    T[:, 0, 3] = step_m * np.arange(count)
    return T


def selected(T_O_B, config=None):
    selector = KeyframeSelector(config or KeyframeConfig())
    return [frame for o in observations(T_O_B) if (frame := selector.select(o)) is not None]


def test_keyframes_are_equally_spaced_with_a_support_frame_between():
    frames = selected(straight(0.0625, 41))  # a path of 2.5 m
    assert [f.observation.T_O_B[0, 3] for f in frames if f.is_keyframe] == [0.0, 0.5, 1.0, 1.5, 2.0, 2.5]
    assert [f.observation.T_O_B[0, 3] for f in frames if not f.is_keyframe] == [0.25, 0.75, 1.25, 1.75, 2.25]


def test_spacing_counts_path_not_displacement():
    there = straight(0.0625, 5)
    to_and_fro = np.concatenate([there, there[-2::-1], there[1:]])  # a path of 0.75 m within 0.25 m
    assert sum(f.is_keyframe for f in selected(to_and_fro)) == 2


def test_selection_does_not_depend_on_where_odometry_starts(rng):
    T = straight(0.07, 60)
    elsewhere = se3.exp(rng.normal(size=6)) @ T
    indices = [[f.observation.index for f in selected(poses)] for poses in (T, elsewhere)]
    assert indices[0] == indices[1]


@pytest.mark.parametrize(("rotation_rad", "keyframes"), [(None, 1), (0.5, 4)])
def test_turning_on_the_spot_gives_keyframes_only_when_asked(rotation_rad, keyframes):
    yaw = np.linspace(0.0, 1.6, 33)
    T = se3.exp(np.stack([0 * yaw, 0 * yaw, yaw, 0 * yaw, 0 * yaw, 0 * yaw], axis=1))
    assert sum(f.is_keyframe for f in selected(T, KeyframeConfig(rotation_rad=rotation_rad))) == keyframes


def test_step_covariance_gathers_every_increment_since_the_last_keyframe():
    first, second = (f for f in selected(straight(0.0625, 9)) if f.is_keyframe)
    np.testing.assert_array_equal(first.step_covariance, np.zeros((6, 6)))
    expected = np.zeros((6, 6))
    for _ in range(8):
        expected = se3.compose_covariance(expected, straight(0.0625, 2)[1], COVARIANCE)
    np.testing.assert_allclose(second.step_covariance, expected)
    assert second.step_covariance[4, 4] > 8 * COVARIANCE[4, 4]  # a rotation early on moves the later path sideways


@pytest.mark.parametrize("variance", [MAX_VARIANCE, 1e-2])
@pytest.mark.parametrize("way", [[0.0, 0.25, 0.5], [0.0, 1e7, 2e7], [0.0, 3e6, 0.2], [0.0, 1e8, -1e8, 1e8]])
def test_step_covariances_are_those_that_a_saved_map_may_have(variance, way):
    """Long jumps turn an uncertain rotation into an uncertain position, and a jump back cancels most of it."""
    selector = KeyframeSelector(KeyframeConfig(rotation_rad=0.1))
    T = np.tile(np.eye(4), (len(way), 1, 1))
    T[:, 0, 3] = way
    for observation in observations(T):
        frame = selector.select(replace(observation, increment_covariance=variance * np.eye(6)))
        assert frame is None or usable_covariances(frame.step_covariance)
        assert frame is None or not frame.observation.index or frame.step_covariance.max() >= variance
