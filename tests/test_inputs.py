from dataclasses import replace

import numpy as np
import pytest
from box_room import FORWARD_CAMERA

from lexis.errors import LexisError, ObservationError
from lexis.inputs import check_camera, check_observation, check_room_names
from lexis.types import Camera, Observation

GOOD = Observation(3, 0.3, np.zeros((240, 320, 3), np.uint8), np.eye(4), 1e-6 * np.eye(6))
LEANING = np.eye(4) + 0.01


def test_good_input_passes():
    check_camera(FORWARD_CAMERA)
    check_room_names(["kitchen", "stairs"])
    check_observation(GOOD, FORWARD_CAMERA, None)
    check_observation(GOOD, FORWARD_CAMERA, replace(GOOD, index=2, stamp=0.2))


@pytest.mark.parametrize(
    ("change", "complaint"),
    [
        ({"image": np.zeros((240, 321, 3), np.uint8)}, r"uint8 \(240, 320, 3\)"),
        ({"T_O_B": LEANING}, "not a rigid motion"),
        ({"T_O_B": np.full((4, 4), np.nan)}, "not a rigid motion"),
        ({"increment_covariance": np.diag([1.0, 1, 1, 1, 1, np.inf])}, "not finite"),
        ({"increment_covariance": np.triu(np.ones((6, 6)))}, "symmetric"),
        ({"increment_covariance": -np.eye(6)}, "negative eigenvalue"),
        ({"stamp": 0.2}, "not after 0.25 s"),
        ({"stamp": float("nan")}, "not finite"),
    ],
)
def test_a_bad_observation_is_refused_by_number(change, complaint):
    with pytest.raises(ObservationError, match=rf"observation 3: .*{complaint}"):
        check_observation(replace(GOOD, **change), FORWARD_CAMERA, replace(GOOD, index=2, stamp=0.25))


@pytest.mark.parametrize("names", [[], ["kitchen", " "], ["kitchen", "stairs", "kitchen"]])
def test_impossible_room_lists_are_refused(names):
    with pytest.raises(LexisError, match="valid: "):
        check_room_names(names)


def test_impossible_cameras_are_refused():
    with pytest.raises(LexisError, match="fx, fy > 0"):
        check_camera(Camera(replace(FORWARD_CAMERA.intrinsics, fx=0.0), np.eye(4)))
    with pytest.raises(LexisError, match="T_B_C"):
        check_camera(Camera(FORWARD_CAMERA.intrinsics, LEANING))
