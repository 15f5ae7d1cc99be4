from itertools import chain

import numpy as np
import pytest
from helpers.box_room import FORWARD_CAMERA

from lexis.config import Config, KeyframeConfig
from lexis.keyframe_window import KeyframeWindow
from lexis.keyframes import Frame
from lexis.maths import se3
from lexis.maths.projection import project
from lexis.types import Features, Observation

IMAGE = np.zeros((240, 320, 3), np.uint8)


@pytest.fixture
def frames(rng):
    """Nine frames, 0.25 m apart, that see the same points; every other frame is a keyframe."""
    points = rng.uniform([3.0, -1.5, -1.0], [8.0, 3.5, 1.5], (60, 3))
    descriptors = rng.integers(0, 256, (60, 61), np.uint8)
    frames = []
    for i in range(9):
        T = np.eye(4)
        T[1, 3] = 0.25 * i
        pixels = project(se3.transform(se3.inverse(T @ FORWARD_CAMERA.T_B_C), points), FORWARD_CAMERA.intrinsics)
        frame = Frame(Observation(i, 0.1 * i, IMAGE, T, np.eye(6)), i % 2 == 0, (i + 1) * np.eye(6))
        frames.append((frame, Features(pixels.astype(np.float32), descriptors)))
    return frames


def feed(window, frames):
    """For each frame, the keyframes that it completes."""
    embeddings = [np.ones(1, np.float32)]
    return [window.add(frame, [features], embeddings if frame.is_keyframe else None) for frame, features in frames]


def test_a_keyframe_is_complete_when_the_frames_after_it_have_come(frames):
    window = KeyframeWindow(FORWARD_CAMERA, Config())
    complete = [[k.observation_index for k in keyframes] for keyframes in feed(window, frames)]
    assert complete == [[], [], [0], [], [2], [], [4], [], [6]]
    assert [k.observation_index for k in window.flush()] == [8]
    assert window.flush() == []


@pytest.mark.parametrize("supports", [1, 3, 20])
def test_every_keyframe_comes_once_in_order_and_is_numbered(frames, supports):
    window = KeyframeWindow(FORWARD_CAMERA, Config(keyframes=KeyframeConfig(supports=supports)))
    keyframes = [*chain.from_iterable(feed(window, frames)), *window.flush()]
    assert [k.observation_index for k in keyframes] == [0, 2, 4, 6, 8]
    assert [k.id for k in keyframes] == [0, 1, 2, 3, 4]
    assert [k.step_covariance[0, 0] for k in keyframes] == [1, 3, 5, 7, 9]


def test_landmarks_come_from_frames_on_both_sides(frames):
    """Three views must agree. With one frame on either side, the first and the last keyframe have too few."""
    window = KeyframeWindow(FORWARD_CAMERA, Config(keyframes=KeyframeConfig(supports=1)))
    keyframes = [*chain.from_iterable(feed(window, frames)), *window.flush()]
    counts = [len(k.landmarks.points) for k in keyframes]
    assert counts[0] == counts[-1] == 0
    assert min(counts[1:-1]) > 30
