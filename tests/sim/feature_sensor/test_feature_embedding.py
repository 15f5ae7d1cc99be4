"""The embeddings drawn by the feature sensor have the statistics of the data that it was fitted to."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from helpers.viewpoints import viewpoints

from sim.feature_fitting.fit_embedding import fit_embedding
from sim.feature_fitting.fit_samples import Sample
from sim.feature_sensor.embedding import KERNELS, EmbeddingModel, error_scores, kernel_values
from sim.feature_sensor.surroundings import KINDS, survey
from sim.feature_sensor.visible_shares import SIZE, look
from sim.render.camera import wide_camera
from worlds.furniture.catalogue import CATALOGUE
from worlds.house import build_house
from worlds.labels import ROOM_LABELS
from worlds.presets import sample_house

CAMERA = wide_camera()
D = 12


@pytest.fixture(scope="module")
def model():
    rng = np.random.default_rng(0)
    shares = np.array([0.1, 0.2, 0.1, 0.1, 0.4, 0.1])
    weights, errors = rng.normal(0.0, 0.5, (SIZE, D)), rng.normal(0.0, 0.15, (6, D))
    return EmbeddingModel(weights.astype(np.float32), np.full(D, 0.1, np.float32), errors.astype(np.float32), shares)


@cache
def seen(seed, frames):
    house = build_house(sample_house("apartment", seed))
    poses = viewpoints(house, frames, seed)
    return look(survey(house), poses, CAMERA), poses


@pytest.fixture(scope="module")
def views():
    return seen(5, 20)


def test_they_are_a_function_of_pose_house_and_seed(model, views):
    looked, poses = views
    drawn = model.draw(looked, poses, (3, 4))
    np.testing.assert_allclose(np.linalg.norm(drawn, axis=1), 1.0, atol=1e-6)
    back = look(looked.around, poses[::-1], CAMERA)
    np.testing.assert_allclose(model.draw(back, poses[::-1], (3, 4))[::-1], drawn, atol=1e-5)
    assert np.abs(model.draw(looked, poses, (3, 5)) - drawn).max() > 0.05


def test_without_error_they_are_the_expected_ones(model, views):
    sure = replace(model, errors=np.zeros_like(model.errors))
    expected = model.expected(views[0])
    units = expected / np.linalg.norm(expected, axis=1, keepdims=True)
    np.testing.assert_allclose(sure.draw(*views, (1,)), units, atol=1e-5)


def test_errors_are_alike_as_the_kernels_say(model, views):
    """Checked over many seeds in small dimensions of the error, beside a long fixed one: normalising has no effect there."""
    flat = replace(
        model,
        weights=np.zeros_like(model.weights),
        offset=np.eye(D, dtype=np.float32)[0] * 1000.0,
        errors=np.eye(D, dtype=np.float32)[1:4],
    )
    draws = 1000.0 * np.concatenate([flat.draw(*views, (seed,))[:, 1:4] for seed in range(150)], axis=1)
    measured = draws @ draws.T / draws.shape[1]
    expected = sum(share * values for share, values in zip(model.kernels, kernel_values(*views), strict=True))
    np.testing.assert_allclose(measured, expected, atol=0.25)
    assert np.corrcoef(measured.ravel(), expected.ravel())[0, 1] > 0.95


class Labels:
    """An encoder whose dimensions are room labels."""

    name = fingerprint = "labels"

    def encode_image(self, image):
        raise NotImplementedError

    def encode_rooms(self, names):
        return np.eye(len(ROOM_LABELS), dtype=np.float32)[[ROOM_LABELS.index(name) for name in names]]


@pytest.fixture(scope="module")
def truth():
    """An encoder that recognises furniture and its typical room, with errors per room and per place."""
    weights = np.zeros((SIZE, len(ROOM_LABELS)), np.float32)
    for kind in CATALOGUE.values():
        weights[KINDS.index(kind.name), [ROOM_LABELS.index(label) for label in kind.rooms]] = 1.0
    shares = np.array([0.0, 0.5, 0.0, 0.0, 0.5, 0.0])
    offset = np.full(len(ROOM_LABELS), 1e-3, np.float32)
    return EmbeddingModel(weights, offset, 0.3 * np.eye(len(ROOM_LABELS), dtype=np.float32), shares)


def drawn_samples(model, seeds, frames):
    """Samples before normalisation, as the fit describes them."""
    for seed in seeds:
        views, poses = seen(seed, frames)
        errors = error_scores(model, views, poses, (seed,)) @ model.errors
        yield Sample(views.around, poses, views, model.expected(views) + errors)


@pytest.fixture(scope="module")
def fitted(truth):
    """A model fitted to frames that are closer together than the narrowest kernel is wide, so that it is identifiable."""
    return fit_embedding(list(drawn_samples(truth, range(28), 80)), Labels())


def test_fitting_finds_what_was_drawn_from(truth, fitted):
    views, _ = seen(53, 40)
    assert np.corrcoef(fitted.expected(views).ravel(), truth.expected(views).ravel())[0, 1] > 0.75
    found = dict(zip(KERNELS, fitted.kernels, strict=True))
    assert fitted.kernels.sum() == pytest.approx(1.0) and (fitted.kernels >= 0.0).all()
    assert found["rooms"] > 0.25 and found["1 m, 0.6 rad"] > 0.25 and found["house"] < 0.2


def test_labels_are_right_as_often_as_those_that_were_fitted_to(truth, fitted):
    def accuracy(model):
        samples = list(drawn_samples(model, range(50, 66), 40))
        texts = [Labels().encode_rooms(sample.around.house.spec.room_labels) for sample in samples]
        said = [(sample.embeddings @ text.T).argmax(axis=1) for sample, text in zip(samples, texts, strict=True)]
        return np.mean(np.concatenate(said) == np.concatenate([sample.true_labels for sample in samples]))

    assert 0.5 < accuracy(truth) < 0.95
    assert accuracy(fitted) == pytest.approx(accuracy(truth), abs=0.08)
