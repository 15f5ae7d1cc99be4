"""LEXIS as a whole on one and a half laps of a textured room: real pixels, features and loops, without the simulator."""

import json
from dataclasses import replace

import cv2
import numpy as np
import pytest
from helpers.box_room import FORWARD_CAMERA, FRONT_REAR, BoxRoom, walk
from helpers.unchecked import unchecked

from lexis.config import Config, LandmarkConfig, PlaceRecognitionConfig
from lexis.errors import EncoderError, LexisError, ObservationError
from lexis.features import FeatureExtractor
from lexis.map.arrays import pack
from lexis.map.export import export_map
from lexis.map.folder import load_map, save_map
from lexis.maths import se3
from lexis.slam import Slam
from lexis.types import NO_FEATURES, Camera, Features, Observation, Percept

ROOMS = ("office", "kitchen")
COVARIANCE = np.diag([1e-8, 1e-8, 1e-5, 3e-5, 3e-5, 1e-6])


CONFIG = Config(landmarks=LandmarkConfig(max_features=300))  # the texture has many more; fewer save time


class ThumbnailEncoder:
    """Labels every image as an office; the rest of the embedding is a thumbnail of the image."""

    name = fingerprint = "thumbnail"

    def encode_image(self, image):
        small = cv2.resize(image, (8, 6), interpolation=cv2.INTER_AREA).astype(np.float32).ravel()
        look = small - small.mean()
        return np.concatenate([np.float32([0.8, 0.0]), np.float32(0.6) * look / np.linalg.norm(look)])

    def encode_rooms(self, names):
        return np.eye(len(names), 2 + 144, dtype=np.float32)


@pytest.fixture(scope="module")
def true():
    angle = np.linspace(0.0, 2.8 * np.pi, 200)
    return walk(np.stack([3.5 + 2 * np.cos(angle), 3 + 1.8 * np.sin(angle)], axis=1), 0.2501)


@pytest.fixture(scope="module")
def observations(true):
    """Observations whose odometry is noisy and turns 0.7 °/m too far."""
    rng = np.random.default_rng(5)
    room = BoxRoom((7.0, 6.0, 2.8), rng)
    drift = rng.multivariate_normal([0, 0, np.radians(0.7) * 0.25, 0, 0, 0], COVARIANCE, len(true) - 1)
    T = [true[0]]
    for step in se3.between(true[:-1], true[1:]) @ se3.exp(drift):
        T.append(T[-1] @ step)
    return [Observation(i, 0.4 * i, room.render(true[i]), T_O_B, COVARIANCE) for i, T_O_B in enumerate(T)]


class Two(ThumbnailEncoder):
    """Has embeddings of two numbers, one for each room."""

    def encode_rooms(self, names):
        return np.eye(2, dtype=np.float32)


class MistakenEncoder(ThumbnailEncoder):
    """Labels every fifth office as a kitchen."""

    def __init__(self):
        self._images = 0

    def encode_image(self, image):
        self._images += 1
        embedding = super().encode_image(image)
        return np.concatenate([embedding[1::-1], embedding[2:]]) if self._images % 5 == 0 else embedding


def run(observations, config=CONFIG, encoder=None, **stages):
    slam = Slam(FORWARD_CAMERA, encoder or ThumbnailEncoder(), ROOMS, config, **stages)
    for observation in observations:
        slam.process(observation)
    return slam.finish()


@pytest.fixture(scope="module")
def result(observations):
    return run(observations)


def position_errors(T, keyframes, true):
    return np.linalg.norm(T[:, :3, 3] - true[[k.observation_index for k in keyframes], :3, 3], axis=1)


def test_loops_take_most_of_the_drift_away(result, true):
    odometry = np.stack([k.T_O_B for k in result.keyframes])
    before, after = (position_errors(T, result.keyframes, true) for T in (odometry, result.T_W_B))
    assert before.max() > 0.3
    assert after.max() < 0.5 * before.max()


def test_trusted_loop_edges_are_true(result, true):
    assert (result.loop_weights >= 0.5).sum() >= 10
    for loop, weight in zip(result.loops, result.loop_weights, strict=True):
        match, query = (true[result.keyframes[i].observation_index] for i in (loop.match, loop.query))
        error = se3.log(se3.between(loop.T_match_query, se3.between(match, query)))
        assert weight < 0.5 or (np.linalg.norm(error[3:]) < 0.5 and np.linalg.norm(error[:3]) < 0.2)


def test_every_keyframe_has_all_results(result, observations):
    n = len(result.keyframes)
    assert [k.id for k in result.keyframes] == list(range(n))
    np.testing.assert_allclose(result.T_W_B[0], observations[0].T_O_B, atol=1e-5)
    for array in (result.T_W_B, result.similarities, result.baseline_labels, result.labels, result.floors):
        assert len(array) == n
    assert [query for query, _ in result.candidates] == list(range(n))
    assert sorted(i for room in result.rooms for i in room.keyframes) == list(range(n))
    assert {room.label for room in result.rooms} == {"office"}
    assert set(result.stage_seconds) == {"encode", "features", "landmarks", "rooms", "propose", "verify", "optimise"}


def test_edges_come_from_the_candidates(result):
    proposed = {(query, match) for query, matches in result.candidates for match in matches}
    assert {(loop.query, loop.match) for loop in result.loops} <= proposed


def test_loops_are_sought_in_the_room_that_the_image_itself_shows(observations):
    sought = []

    def nothing(query, label, *rest):
        sought.append(label)
        return ()

    result = run(observations[:24], encoder=MistakenEncoder(), place_recogniser=nothing)
    assert sought == [ROOMS[label] for label in result.baseline_labels]
    assert "kitchen" in sought and (result.labels == 0).all()


def test_given_labels_are_clustered_in_place_of_those_of_the_images(observations):
    result = run(observations[:24], labeller=lambda keyframes: np.array([k.id >= 5 for k in keyframes], int))
    n = len(result.keyframes)
    assert [(room.label, room.keyframes) for room in result.rooms] == [
        ("office", tuple(range(5))),
        ("kitchen", tuple(range(5, n))),
    ]
    assert (result.baseline_labels == 0).all() and result.labels.sum() == n - 5


def test_without_candidates_the_result_is_the_odometry(observations):
    result = run(observations[:12], Config(place_recognition=PlaceRecognitionConfig(candidates=0)))
    assert result.loops == ()
    np.testing.assert_allclose(result.T_W_B, np.stack([k.T_O_B for k in result.keyframes]), atol=1e-9)


def test_the_same_observations_give_the_same_map(observations, result):
    again = run(observations)
    np.testing.assert_array_equal(again.T_W_B, result.T_W_B)
    assert again.candidates == result.candidates


def reusing_buffers(observations):
    """The same observations from a driver that writes each one into the same buffers."""
    buffers = None
    for observation in observations:
        arrays = _arrays(observation)
        if buffers is None:
            buffers = [array.copy() for array in arrays]
        for k, array in enumerate(arrays):
            if buffers[k].shape == array.shape:
                buffers[k][...] = array
            else:  # the number of key points has changed
                buffers[k].fill(0)
                buffers[k] = array.copy()
        yield _observation(observation, buffers)
    for buffer in buffers:
        buffer.fill(0)


def _arrays(observation):
    seen = observation.image
    of_image = [seen.embedding, seen.points, *vars(seen.features).values()] if isinstance(seen, Percept) else [seen]
    return [observation.T_O_B, observation.increment_covariance, *of_image]


def _observation(observation, buffers):
    T_O_B, covariance, *of_image = buffers
    image = of_image[0] if len(of_image) == 1 else Percept(of_image[0], Features(*of_image[2:]), of_image[1])
    return replace(observation, image=image, T_O_B=T_O_B, increment_covariance=covariance)


def percepts(observations):
    """The percepts that LEXIS would compute from the images."""
    encoder, extractor = ThumbnailEncoder(), FeatureExtractor(CONFIG.landmarks)
    for observation in observations:
        image = observation.image
        points = np.array([[1.0 + 0.1 * observation.index, 0.5, 0.0]])
        yield replace(observation, image=Percept(encoder.encode_image(image), extractor.extract(image), points))


class ReusingEncoder(ThumbnailEncoder):
    """Writes every embedding into the same buffer."""

    def __init__(self):
        self._buffer = np.zeros(146, np.float32)

    def encode_image(self, image):
        self._buffer[:] = super().encode_image(image)
        return self._buffer


@pytest.mark.parametrize("form", ["images", "percepts"])
def test_a_driver_may_reuse_its_buffers(observations, form):
    brief = observations[:24] if form == "images" else [*percepts(observations[:24])]
    expected, found = pack(run(brief), True), pack(run(reusing_buffers(brief), encoder=ReusingEncoder()), True)
    assert len(expected["stamp"]) == 10
    for name, array in expected.items():
        np.testing.assert_array_equal(found[name], array, err_msg=name)


def test_the_camera_is_the_one_that_was_handed_over(observations):
    camera = Camera(FORWARD_CAMERA.intrinsics, FORWARD_CAMERA.T_B_C.copy())
    slam = Slam(camera, ThumbnailEncoder(), ROOMS, CONFIG)
    camera.T_B_C[:] = 0.0
    slam.process(observations[0])
    np.testing.assert_array_equal(slam.finish().camera.T_B_C, FORWARD_CAMERA.T_B_C)


def test_one_observation_makes_a_map(observations):
    assert len(run(observations[:1]).keyframes) == 1


@pytest.mark.parametrize(("whole", "seconds"), [(np.int64, np.float64), (np.uint8, np.float32), (int, np.int32)])
def test_a_map_of_numpy_s_numbers_can_be_exported(observations, whole, seconds, tmp_path):
    """ROS messages and tables of pandas give such numbers."""
    lexis_map = run([unchecked(Observation, **vars(observations[3]) | {"index": whole(3), "stamp": seconds(2)})])
    for form in ("json", "spark-dsg"):
        export_map(lexis_map, form, tmp_path / form)
    summary = json.loads((tmp_path / "json").read_text())
    assert summary["keyframes"][0]["stamp_s"] == 2.0


@pytest.mark.parametrize("deviation", [4e-7, -4e-7])
def test_poses_whose_rotations_are_only_nearly_orthonormal_make_a_map_that_can_be_loaded(true, tmp_path, deviation):
    """Poses in single precision, and calibrations with seven digits, are such poses. Products add up their deviations."""
    scaled = true.copy()
    scaled[:, :3, :3] *= 1.0 + deviation
    seen = Percept(np.float32([1.0, 0.0]), NO_FEATURES)
    slam = Slam(FORWARD_CAMERA, Two(), ROOMS, CONFIG)
    for i, T_O_B in enumerate(scaled):
        slam.process(Observation(i, 0.4 * i, seen, T_O_B, COVARIANCE))
    save_map(slam.finish(), tmp_path / "map")
    saved = load_map(tmp_path / "map").T_W_B
    assert len(saved) > 20 and se3.is_rigid(saved, 1e-9).all()


def test_no_observation_makes_none():
    with pytest.raises(LexisError, match="at least one"):
        run([])


def test_time_cannot_run_backwards(observations):
    with pytest.raises(ObservationError, match="not after"):
        run([observations[1], replace(observations[2], stamp=0.0)])


class FailingEncoder(ThumbnailEncoder):
    """Gives no unit norm for every other image."""

    def __init__(self):
        self._images = 0

    def encode_image(self, image):
        self._images += 1
        return super().encode_image(image) * (1.0 if self._images % 2 else 2.0)


def test_an_observation_that_the_encoder_failed_on_can_be_processed_again(observations):
    slam, failures = Slam(FORWARD_CAMERA, FailingEncoder(), ROOMS, CONFIG), 0
    for observation in observations[:24]:
        try:
            slam.process(observation)
        except EncoderError:
            failures += 1
            slam.process(observation)
    found, expected = pack(slam.finish(), True), pack(run(observations[:24]), True)
    assert failures >= 5
    for name, array in expected.items():
        np.testing.assert_array_equal(found[name], array, err_msg=name)


def test_a_keyframe_after_an_image_that_the_encoder_failed_on_keeps_the_earlier_covariance(observations):
    """The run goes on without the observations that fail."""
    slam = Slam(FORWARD_CAMERA, FailingEncoder(), ROOMS, CONFIG)
    failed = []
    for observation in observations[:12]:
        try:
            slam.process(observation)
        except EncoderError:
            failed.append(observation.index)
    second = slam.finish().keyframes[1]
    assert second.observation_index == failed[0] + 1
    assert second.step_covariance[3, 3] > 0.9 * failed[0] * COVARIANCE[3, 3]


@pytest.fixture(scope="module")
def there_and_back():
    """A walk along a curve and back on the same way, seen by a front and a rear camera; the odometry is right."""
    room = BoxRoom((9.0, 6.0, 2.8), np.random.default_rng(5))
    way = np.stack([np.linspace(1.5, 7.5, 40), 3.0 + 0.8 * np.sin(np.linspace(0.0, 3.0, 40))], axis=1)
    there, back = walk(way, 0.2501), walk(way[::-1], 0.2501)
    true = np.concatenate([there, back])
    front, rear = FRONT_REAR.rig
    return [
        Observation(i, 0.5 * i, room.render(T, front), T, COVARIANCE, (room.render(T, rear),)) for i, T in enumerate(true)
    ]


def mapped_way(observations, camera):
    slam = Slam(camera, ThumbnailEncoder(), ROOMS, CONFIG)
    for observation in observations:
        slam.process(observation)
    return slam.finish()


def test_a_rig_closes_loops_on_the_way_back(there_and_back):
    both = mapped_way(there_and_back, FRONT_REAR)
    alone = mapped_way([replace(observation, others=()) for observation in there_and_back], FORWARD_CAMERA)
    assert not alone.loops and len(both.loops) > 5
    for loop in both.loops:
        error = se3.between(se3.between(both.T_W_B[loop.match], both.T_W_B[loop.query]), loop.T_match_query)
        assert np.linalg.norm(error[:3, 3]) < 0.2 and loop.T_match_query[0, 0] < -0.5  # looking back
    assert [len(keyframe.views) for keyframe in both.keyframes] == [2] * len(both.keyframes)


def test_a_rig_s_map_can_be_continued_and_another_rig_is_refused(there_and_back):
    half = len(there_and_back) // 2
    first = mapped_way(there_and_back[:half], FRONT_REAR)
    slam = Slam(FRONT_REAR, ThumbnailEncoder(), ROOMS, CONFIG, map=first)
    for observation in there_and_back[half:]:
        slam.process(observation)
    whole = slam.finish()
    assert {keyframe.session for keyframe in whole.keyframes} == {0, 1} and whole.loops
    with pytest.raises(LexisError, match="the rig has 1 cameras, and that of the map 2"):
        Slam(FORWARD_CAMERA, ThumbnailEncoder(), ROOMS, CONFIG, map=first)
