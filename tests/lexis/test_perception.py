"""Observations may carry percepts instead of an image; LEXIS then makes the same map."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.box_room import FORWARD_CAMERA, BoxRoom, walk
from helpers.map_builder import corridor_with_offices

from lexis.config import Config, LandmarkConfig
from lexis.errors import EncoderError, ObservationError
from lexis.features import FeatureExtractor
from lexis.inputs import pixels
from lexis.map.relabelling import relabel
from lexis.perception import embedding_of, features_of
from lexis.slam import Slam
from lexis.types import NO_FEATURES, EncoderId, Observation, Percept
from lexis.verification import Verification

CONFIG = Config(landmarks=LandmarkConfig(max_features=200))
BITS = np.zeros((1, 61), np.uint8)


class MeanColour:
    name = fingerprint = "mean colour"

    def encode_image(self, image):
        mean = image.reshape(-1, 3).mean(axis=0)
        return np.float32(mean / np.linalg.norm(mean))

    def encode_rooms(self, names):
        return np.eye(len(names), 3, dtype=np.float32)


@pytest.fixture(scope="module")
def observations():
    room = BoxRoom((7.0, 6.0, 2.5), np.random.default_rng(3))
    poses = walk(np.array([[1.0, 1.0], [5.5, 1.5], [5.0, 4.5]]), 0.26)
    covariance = np.diag([1e-8] * 6)
    return [Observation(i, float(i), room.render(T, FORWARD_CAMERA), T, covariance) for i, T in enumerate(poses)]


def percept_of(observation):
    extractor = FeatureExtractor(CONFIG.landmarks)
    image = observation.image
    return replace(observation, image=Percept(embedding_of(image, MeanColour()), features_of(image, extractor)))


def mapped(observations):
    slam = Slam(FORWARD_CAMERA, MeanColour(), ("kitchen", "office"), CONFIG)
    for observation in observations:
        slam.process(observation)
    return slam.finish()


def test_the_map_of_percepts_is_the_map_of_the_images_they_are_of(observations):
    seen, told = mapped(observations), mapped([percept_of(observation) for observation in observations])
    np.testing.assert_array_equal(told.T_W_B, seen.T_W_B)
    np.testing.assert_array_equal(told.similarities, seen.similarities)
    assert [len(k.landmarks.points) for k in told.keyframes] == [len(k.landmarks.points) for k in seen.keyframes]
    assert sum(len(k.landmarks.points) for k in told.keyframes) > 100


def test_an_encoder_whose_embeddings_have_another_norm_is_refused_at_the_first_image(observations):
    class Doubled(MeanColour):
        def encode_image(self, image):
            return 2.0 * super().encode_image(image)

    slam = Slam(FORWARD_CAMERA, Doubled(), ("kitchen", "office"), CONFIG)
    with pytest.raises(EncoderError, match="encoder mean colour: the embedding of an image has norm 2; valid: unit norm"):
        slam.process(observations[0])


def test_an_encoder_that_gives_a_batch_for_an_image_is_refused_at_the_first_image(observations):
    class Batched(MeanColour):
        def encode_image(self, image):
            return super().encode_image(image)[None]

    slam = Slam(FORWARD_CAMERA, Batched(), ("kitchen", "office"), CONFIG)
    with pytest.raises(EncoderError, match=r"the embedding of an image has shape \(1, 3\); valid: \(d,\)"):
        slam.process(observations[0])


@pytest.mark.parametrize(
    ("given", "found"),
    [
        (None, "a NoneType"),
        ([1.0, 0.0, 0.0], "a list"),
        (np.array([1, 0, 0]), r"int64 \(3,\)"),
        (np.array(["a"]), "<U1"),
        (np.array([1j, 0, 0]), "complex128"),
    ],
)
def test_an_encoder_that_gives_no_vector_of_floats_is_refused_at_the_first_image(observations, given, found):
    class Wrong(MeanColour):
        encode_image = staticmethod(lambda image: given)

    slam = Slam(FORWARD_CAMERA, Wrong(), ("kitchen", "office"), CONFIG)
    with pytest.raises(EncoderError, match=f"the embedding of an image is {found}.*; valid: float32"):
        slam.process(observations[0])


def test_an_encoder_whose_images_and_texts_differ_in_length_is_refused_at_the_first_image(observations):
    class Longer(MeanColour):
        def encode_image(self, image):
            return np.append(super().encode_image(image), np.float32(0.0))

    slam = Slam(FORWARD_CAMERA, Longer(), ("kitchen", "office"), CONFIG)
    with pytest.raises(EncoderError, match="the embedding of an image has 4 numbers; valid: 3, as those of room names"):
        slam.process(observations[0])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (np.eye(3, dtype=np.float32), r"the embeddings of 2 room names are float32 \(3, 3\); valid: float32 \(2, d\)"),
        (np.ones(2, np.float32), r"the embeddings of 2 room names are float32 \(2,\); valid: float32 \(2, d\)"),
        ([[1.0], [1.0]], r"the embeddings of 2 room names are a list; valid: float32 \(2, d\)"),
        (np.eye(2, 3, dtype=np.float32) * 2.0, "the embedding of room name 0 has norm 2; valid: unit norm"),
        (np.array([[1.0, 0.0], [np.nan, 1.0]], np.float32), "the embedding of room name 1 has norm nan; valid: unit norm"),
    ],
)
def test_an_encoder_without_a_vector_of_unit_norm_for_each_room_name_is_refused_at_once(text, message):
    class Wrong(MeanColour):
        def encode_rooms(self, names):
            return text

    with pytest.raises(EncoderError, match=f"encoder mean colour: {message}"):
        Slam(FORWARD_CAMERA, Wrong(), ("kitchen", "office"), CONFIG)
    own = EncoderId(Wrong.name, Wrong.fingerprint)
    lexis_map = replace(corridor_with_offices(np.random.default_rng(1)), encoder=own)
    with pytest.raises(EncoderError, match=f"encoder mean colour: {message}"):
        relabel(lexis_map, ("kitchen", "office"), Wrong())


def test_loops_are_the_verifiers(observations):
    asked = []

    def verifier(query, candidates, graph, camera, config):
        asked.append((query.id, tuple(candidates)))
        return Verification(())

    slam = Slam(FORWARD_CAMERA, MeanColour(), ("kitchen", "office"), CONFIG, verifier)
    for observation in observations:
        slam.process(observation)
    assert slam.finish().candidates == tuple(asked)


@pytest.mark.parametrize(
    ("percept", "message"),
    [
        (Percept(np.full(3, np.nan, np.float32), NO_FEATURES), "unit norm"),
        (Percept(np.float32([0.0, 2.0, 0.0]), NO_FEATURES), "unit norm"),
        (
            Percept(
                np.float32([0.0, 1.0, 0.0]), replace(NO_FEATURES, keypoints=np.float32([[np.inf, 0.0]]), descriptors=BITS)
            ),
            "finite",
        ),
    ],
)
def test_bad_percepts_are_refused(observations, percept, message):
    slam = Slam(FORWARD_CAMERA, MeanColour(), ("kitchen", "office"), CONFIG)
    with pytest.raises(ObservationError, match=message):
        slam.process(replace(observations[0], image=percept))


def test_pixels_are_those_of_the_image(observations):
    (image,) = pixels(observations[0])
    assert image is observations[0].image
    with pytest.raises(ObservationError, match="has a percept but no image"):
        pixels(percept_of(observations[0]))
