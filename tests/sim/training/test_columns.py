"""The loss of image columns: each column names a label, and their mean has to be the shares of the labels in view."""

import numpy as np
import torch
from scipy.special import softmax

from sim.training.align import AlignedTower
from sim.training.columns import columns_loss, contributions
from sim.training.dense import DenseTower

NONE = np.zeros((1, 3), bool)
"""No label of three is ignored."""


def test_the_contributions_of_the_columns_average_to_the_embedding_of_the_image():
    tower, rng = AlignedTower(DenseTower(), 16), np.random.default_rng(0)
    columns = torch.from_numpy(rng.normal(size=(7, 5, tower.dense.width)).astype(np.float32))
    parts = contributions(columns, tower.projection)
    np.testing.assert_allclose(parts.mean(dim=1).detach(), tower.embedded(columns.mean(dim=1)).detach(), atol=1e-6)


def test_the_features_of_the_columns_average_to_those_of_the_image():
    tower, rng = DenseTower().eval(), np.random.default_rng(1)
    images = torch.from_numpy(rng.normal(size=(2, 3, 128, 160)).astype(np.float32))
    with torch.inference_mode():
        columns, pooled = tower.columns(images), tower(images).pooled
    assert columns.shape == (2, 5, tower.width)
    np.testing.assert_allclose(columns.mean(dim=1), pooled, rtol=0.02, atol=0.02)  # both are computed in bfloat16


def test_the_loss_is_the_cross_entropy_of_the_mean_over_the_columns():
    rng = np.random.default_rng(2)
    logits, shown = rng.normal(0.0, 3.0, (6, 5, 4)), rng.dirichlet(np.ones(4), 6)
    expected = -(shown * np.log(softmax(logits, axis=2).mean(axis=1) + 1e-4)).sum(axis=1).mean()
    nothing = np.zeros((6, 4), bool)
    np.testing.assert_allclose(columns_loss(torch.from_numpy(logits), nothing, torch.from_numpy(shown)), expected)


def test_columns_that_show_different_rooms_are_right_and_columns_that_agree_are_not():
    """A third of the image shows another room. Its column alone may name that room."""
    shown = torch.tensor([[2 / 3, 1 / 3, 0.0]])
    apart = torch.tensor([[[9.0, 0.0, 0.0], [9.0, 0.0, 0.0], [0.0, 9.0, 0.0]]])
    alike = torch.tensor([[[9.0, 0.0, 0.0]] * 3])
    assert columns_loss(apart, NONE, shown) < columns_loss(alike, NONE, shown) - 1.0


def test_a_label_that_the_house_lacks_is_ignored_unless_it_is_in_view():
    ignored = np.array([[False, False, True]])
    logits, unseen, seen = torch.zeros((1, 5, 3)), torch.tensor([[0.5, 0.5, 0.0]]), torch.tensor([[0.5, 0.0, 0.5]])
    strange = logits.clone()
    strange[..., 2] = 20.0
    assert columns_loss(logits, ignored, unseen) == columns_loss(strange, ignored, unseen)
    assert columns_loss(logits, ignored, seen) != columns_loss(strange, ignored, seen)
