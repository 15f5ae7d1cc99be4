from dataclasses import replace

import numpy as np
import pytest
from helpers.box_room import FORWARD_CAMERA, FRONT_REAR
from helpers.map_builder import corridor_with_offices
from helpers.unchecked import unchecked, untyped

from lexis.errors import LexisError, ObservationError
from lexis.inputs import check_camera, check_observation, check_room_names
from lexis.map.folder import save_map
from lexis.types import NO_FEATURES, Camera, Features, Intrinsics, Observation, Percept

GOOD = Observation(3, 0.3, np.zeros((240, 320, 3), np.uint8), np.eye(4), 1e-6 * np.eye(6))
LEANING = np.eye(4) + 0.01


def at(x):
    """A pose at a position on the x axis [m]."""
    T = np.eye(4)
    T[0, 3] = x
    return T


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
        ({"stamp": 2e12}, r"stamp 2000000000000\.0 s is too large; valid: a time up to 1e[+]12 s"),
        ({"stamp": 1e300}, "is too large; valid: a time up to"),
        ({"stamp": -np.inf}, "stamp -inf s is not finite; valid: "),
        ({"T_O_B": at(1e155)}, "not a rigid motion"),
        ({"T_O_B": at(-1.1e8)}, "not a rigid motion"),
        ({"increment_covariance": 1e155 * np.eye(6)}, "not finite, symmetric and .*with values up to 1e[+]12"),
    ],
)
def test_a_bad_observation_is_refused_by_number(change, complaint):
    with pytest.raises(ObservationError, match=rf"observation 3: .*{complaint}"):
        check_observation(replace(GOOD, **change), FORWARD_CAMERA, replace(GOOD, index=2, stamp=0.25))


@pytest.mark.parametrize(
    ("pose", "found"),
    [
        (np.eye(4).tolist(), "a list"),
        (None, "a NoneType"),
        (np.eye(4)[:3], r"float64 \(3, 4\)"),
        (np.eye(4, dtype=bool), r"bool \(4, 4\)"),
    ],
)
def test_a_pose_of_another_type_or_shape_is_refused_as_such(pose, found):
    complaint = rf" is {found}; valid: a 4x4 array of numbers$"
    with pytest.raises(ObservationError, match="observation 3: T_O_B" + complaint):
        check_observation(unchecked(Observation, **vars(GOOD) | {"T_O_B": pose}), FORWARD_CAMERA, None)
    with pytest.raises(LexisError, match="^T_B_C of the camera" + complaint):
        check_camera(unchecked(Camera, **vars(FORWARD_CAMERA) | {"T_B_C": pose}))


@pytest.mark.parametrize(
    ("index", "complaint"),
    [
        (None, "the index is no whole number; valid: "),
        ("3", "the index is no whole number; valid: "),
        (2**70, "the index is too large; valid: a whole number up to 4611686018427387904"),
        (-(2**70), "the index is too large; valid: "),
    ],
)
def test_an_index_that_a_map_cannot_hold_is_refused(index, complaint):
    with pytest.raises(ObservationError, match=complaint):
        check_observation(unchecked(Observation, **vars(GOOD) | {"index": index}), FORWARD_CAMERA, None)


@pytest.mark.parametrize(
    "names",
    [
        [],
        ["kitchen", None],
        "kitchen",
        ["kitchen", " "],
        ["kitchen", "stairs", "kitchen"],
        ["kitchen", "Kitchen"],
        [" kitchen"],
        ["kitchen", "living room "],
        ["k" * 201],
        ["kit\nchen"],
        [f"room {i}" for i in range(1001)],
    ],
)
def test_impossible_room_lists_are_refused(names):
    with pytest.raises(LexisError, match="valid: "):
        untyped(check_room_names)(names)


@pytest.mark.parametrize(
    ("names", "kind"),
    [({"kitchen", "office"}, "set"), (dict.fromkeys(["kitchen"]).keys(), "dict_keys"), (iter(["kitchen"]), "list_iterator")],
)
def test_room_names_without_an_order_of_their_own_are_refused(names, kind):
    with pytest.raises(LexisError, match=f"room names are a {kind}; valid: a sequence of names, because labels are indices"):
        untyped(check_room_names)(names)


@pytest.mark.parametrize("names", [["k" * 200], [f"room {i}" for i in range(1000)]])
def test_a_map_can_be_saved_with_every_room_list_that_passes(rng, tmp_path, names):
    check_room_names(names)
    save_map(replace(corridor_with_offices(rng), room_names=tuple(names), rooms=()), tmp_path / "map")


@pytest.mark.parametrize(
    "change",
    [
        {"fx": 0.0},
        {"fy": float("nan")},
        {"fx": float("inf")},
        {"cx": float("nan")},
        {"width": 0},
        {"fx": 1e-300},
        {"fx": 1e155},
        {"cy": -1e155},
        {"width": 10**9},
    ],
)
def test_impossible_intrinsics_are_refused(change):
    with pytest.raises(LexisError, match="fx, fy > 0"):
        check_camera(Camera(replace(FORWARD_CAMERA.intrinsics, **change), np.eye(4)))


@pytest.mark.parametrize("change", [{"width": 10.5}, {"height": "8"}, {"fx": "5"}, {"cy": None}])
def test_intrinsics_of_another_type_are_refused_before_the_run(change):
    intrinsics = unchecked(Intrinsics, **vars(FORWARD_CAMERA.intrinsics) | change)
    with pytest.raises(LexisError, match="valid: whole numbers as width and height, numbers as fx, fy, cx, cy"):
        check_camera(unchecked(Camera, intrinsics, np.eye(4)))


UNIT = np.array([0.6, 0.8], np.float32)


def percept(embedding=UNIT, keypoints=NO_FEATURES.keypoints, descriptors=NO_FEATURES.descriptors):
    """A percept without type checks: the annotations, which are enforced in tests, would refuse a bad one earlier."""
    features, made = Features(**vars(NO_FEATURES)), Percept(UNIT, NO_FEATURES)
    object.__setattr__(features, "keypoints", keypoints)
    object.__setattr__(features, "descriptors", descriptors)
    object.__setattr__(made, "embedding", embedding)
    object.__setattr__(made, "features", features)
    return made


BITS = np.zeros((1, 61), np.uint8)


def with_points(points):
    """A percept with points, without type checks."""
    made = percept()
    object.__setattr__(made, "points", points)
    return made


def test_a_percept_of_the_encoders_size_passes():
    check_observation(replace(GOOD, image=percept()), FORWARD_CAMERA, None, 2)
    rows = np.ones((3, 2), np.float32), np.zeros((3, 61), np.uint8)
    check_observation(replace(GOOD, image=percept(UNIT, *rows)), FORWARD_CAMERA, None, 2)


@pytest.mark.parametrize(
    ("image", "complaint"),
    [
        (percept(np.eye(1, 3, dtype=np.float32)[0]), "has 3 numbers; valid: 2, as the encoder's"),
        (percept([0.6, 0.8]), "the embedding is a list"),
        (percept(None), "the embedding is a NoneType"),
        (percept(np.array([1, 0])), r"the embedding is int64 \(2,\)"),
        (percept(UNIT[None]), r"the embedding is float32 \(1, 2\)"),
        (percept(np.array([np.nan, 1], np.float32)), "norm nan"),
        (percept(descriptors=np.zeros((0, 32), np.uint8)), r"valid: float32 \(n, 2\) and uint8 \(n, 61\)"),
        (percept(descriptors=np.zeros((0, 61))), r"valid: float32 \(n, 2\) and uint8 \(n, 61\)"),
        (percept(keypoints=np.zeros((0, 3), np.float32)), r"valid: float32 \(n, 2\)"),
        (percept(keypoints=[]), "key points are a list"),
        (percept(keypoints=np.ones((1, 2), np.float32)), "1 key points and 0 descriptors"),
        (percept(UNIT, np.full((1, 2), 1e30, np.float32), np.zeros((1, 61), np.uint8)), "finite positions"),
        (percept(UNIT, np.full((1, 2), 1e30, np.float32), BITS), "a key point has the coordinate 1e[+]30 px; valid: finite"),
        (percept(UNIT, np.float32([[3.0, np.nan]]), BITS), "a key point has the coordinate nan px; valid: finite"),
        (
            with_points(np.array([[0.0, 1e9, 0.0]])),
            "a point has the coordinate 1e[+]09 m; valid: finite positions up to 1e[+]08 m",
        ),
        (with_points(np.array([[np.inf, 0.0, 0.0]])), "a point has the coordinate inf m; valid: finite positions"),
        (with_points(np.zeros((1, 2))), r"points are float64 \(1, 2\); valid: float64 \(m, 3\)"),
        ("an image", "the image is a str"),
        (None, "the image is a NoneType"),
    ],
)
def test_a_percept_that_would_cost_the_map_is_refused(image, complaint):
    """A percept with an embedding of another size must not be stored: optimising at the end would fail and lose the map."""
    wrong = replace(GOOD)
    object.__setattr__(wrong, "image", image)
    with pytest.raises(ObservationError, match=f"observation 3: .*{complaint}"):
        check_observation(wrong, FORWARD_CAMERA, None, 2)


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("T_O_B", np.eye(3)),
        ("T_O_B", np.eye(4).tolist()),
        ("T_O_B", np.full((4, 4), None)),
        ("increment_covariance", np.ones(6)),
        ("increment_covariance", None),
        ("stamp", "0.3"),
        ("stamp", None),
        ("stamp", 2 + 1j),
        ("stamp", np.timedelta64(3, "s")),
        ("stamp", np.int64(-(2**63))),
    ],
)
def test_arrays_of_another_shape_are_refused(field, value):
    wrong = replace(GOOD)
    object.__setattr__(wrong, field, value)  # the annotations, which are enforced in tests, would refuse it earlier
    with pytest.raises(ObservationError, match=f"{field}.*valid: "):
        check_observation(wrong, FORWARD_CAMERA, None)


def test_a_mount_that_is_no_rigid_motion_is_refused():
    with pytest.raises(LexisError, match="T_B_C"):
        check_camera(Camera(FORWARD_CAMERA.intrinsics, LEANING))


def test_every_camera_of_a_rig_needs_an_image_of_its_size():
    both = replace(GOOD, others=(GOOD.image,))
    check_observation(both, FRONT_REAR, None)
    for seen, camera in ((GOOD, FRONT_REAR), (both, FORWARD_CAMERA)):
        with pytest.raises(
            ObservationError, match=r"observation 3: has the images of \d cameras; valid: of \d, one for each"
        ):
            check_observation(seen, camera, None)
    with pytest.raises(ObservationError, match=r"observation 3: the image is uint8 \(24, 32, 3\)"):
        check_observation(
            unchecked(Observation, **vars(GOOD) | {"others": (GOOD.image[::10, ::10].copy(),)}), FRONT_REAR, None
        )


def test_a_rig_is_flat_and_all_of_its_cameras_are_checked():
    check_camera(FRONT_REAR)
    with pytest.raises(LexisError, match="`others` at the first camera alone"):
        check_camera(replace(FORWARD_CAMERA, others=(FRONT_REAR,)))
    with pytest.raises(LexisError, match="a rig of 17 cameras"):
        check_camera(replace(FORWARD_CAMERA, others=(FORWARD_CAMERA,) * 16))
    with pytest.raises(LexisError, match="not a rigid motion"):
        check_camera(replace(FORWARD_CAMERA, others=(replace(FORWARD_CAMERA, T_B_C=2.0 * np.eye(4)),)))
