from dataclasses import replace

import numpy as np
import pytest
from box_room import FORWARD_CAMERA
from map_builder import corridor_with_offices

from lexis.errors import LexisError, ObservationError
from lexis.inputs import check_camera, check_observation, check_room_names
from lexis.map_io import save_map
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
        ({"stamp": 0.25}, "not after 0.25 s"),
    ],
)
def test_a_bad_observation_is_refused_by_number(change, complaint):
    with pytest.raises(ObservationError, match=rf"observation 3: .*{complaint}"):
        check_observation(replace(GOOD, **change), FORWARD_CAMERA, replace(GOOD, index=2, stamp=0.25))


@pytest.mark.parametrize(
    "names",
    [
        [],
        "kitchen",
        ["kitchen", " "],
        ["kitchen", "stairs", "kitchen"],
        ["kitchen", "Kitchen "],
        ["k" * 201],
        ["kit\nchen"],
        [f"room {i}" for i in range(1001)],
    ],
)
def test_impossible_room_lists_are_refused(names):
    with pytest.raises(LexisError, match="valid: "):
        check_room_names(names)


@pytest.mark.parametrize("names", [["k" * 200], [f"room {i}" for i in range(1000)]])
def test_a_map_can_be_saved_with_every_room_list_that_passes(rng, tmp_path, names):
    check_room_names(names)
    save_map(replace(corridor_with_offices(rng), room_names=tuple(names), rooms=()), tmp_path / "map")


@pytest.mark.parametrize(
    "change", [{"fx": 0.0}, {"fy": float("nan")}, {"fx": float("inf")}, {"cx": float("nan")}, {"width": 0}]
)
def test_impossible_intrinsics_are_refused(change):
    with pytest.raises(LexisError, match="fx, fy > 0"):
        check_camera(Camera(replace(FORWARD_CAMERA.intrinsics, **change), np.eye(4)))


@pytest.mark.parametrize(("field", "value"), [("T_O_B", np.eye(3)), ("increment_covariance", np.ones(6))])
def test_arrays_of_another_shape_are_refused(field, value):
    wrong = replace(GOOD)
    object.__setattr__(wrong, field, value)  # the annotations, which are enforced in tests, would refuse it earlier
    with pytest.raises(ObservationError, match=f"{field}.*valid: "):
        check_observation(wrong, FORWARD_CAMERA, None)


def test_a_mount_that_is_no_rigid_motion_is_refused():
    with pytest.raises(LexisError, match="T_B_C"):
        check_camera(Camera(FORWARD_CAMERA.intrinsics, LEANING))
