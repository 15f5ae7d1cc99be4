"""The embeddings that the feature sensor draws have the statistics that it was fitted to."""

from dataclasses import replace

import numpy as np
import pytest
from viewpoints import viewpoints

from sim.camera import wide_camera
from sim.features.embedding import KERNELS, EmbeddingModel, kernel_values
from sim.features.fit_embedding import fit_embedding
from sim.features.samples import Sample
from sim.features.surroundings import survey
from sim.features.views import SIZE, look
from worlds.house import build_house
from worlds.presets import sample_house

CAMERA = wide_camera()
D = 12


@pytest.fixture(scope="module")
def model():
    rng = np.random.default_rng(0)
    shares = np.array([0.1, 0.2, 0.1, 0.1, 0.4, 0.1])
    weights, errors = rng.normal(0.0, 0.5, (SIZE, D)), rng.normal(0.0, 0.15, (6, D))
    return EmbeddingModel(weights.astype(np.float32), np.full(D, 0.1, np.float32), errors.astype(np.float32), shares)


def seen(seed, frames):
    house = build_house(sample_house("apartment", seed))
    poses = viewpoints(house, frames, seed)
    return look(survey(house), poses, CAMERA), poses


@pytest.fixture(scope="module")
def views():
    return seen(5, 20)


def errors_of(model, views, poses, seed):
    """Of draws without a mean, before they are normalised."""
    centred = replace(model, weights=np.zeros_like(model.weights), offset=np.zeros(D, np.float32))
    drawn = centred.draw(views, poses, seed)
    return drawn


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
    """Over many seeds, in one dimension of the error where normalising changes nothing: beside a long, fixed one."""
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


def test_fitting_finds_what_was_drawn_from():
    rng = np.random.default_rng(1)
    weights = np.zeros((SIZE, D), np.float32)
    weights[: SIZE // 2] = rng.normal(0.0, 1.0, (SIZE // 2, D))
    shares = np.array([0.0, 0.5, 0.0, 0.5, 0.0, 0.0])
    truth = EmbeddingModel(weights, np.zeros(D, np.float32), 0.1 * np.eye(D, dtype=np.float32), shares)
    samples = []
    for seed in range(12):
        views, poses = seen(seed, 50)
        # Not normalised: the fit is of what is drawn before.
        expected = truth.expected(views)
        units = truth.draw(views, poses, (seed,))
        lengths = np.linalg.norm(expected, axis=1, keepdims=True)
        samples.append(Sample(views.around, poses, views, units * lengths))
    fitted = fit_embedding(samples)
    views, _ = seen(90, 40)
    explained = np.corrcoef(fitted.expected(views).ravel(), truth.expected(views).ravel())[0, 1]
    assert explained > 0.9
    found = dict(zip(KERNELS, fitted.kernels, strict=True))
    assert fitted.kernels.sum() == pytest.approx(1.0) and (fitted.kernels >= 0.0).all()
    assert found["rooms"] > 0.2 and found["house"] < 0.2
