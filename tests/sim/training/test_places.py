"""Places: the frames that show one, and the loss that brings their embeddings together."""

import numpy as np
import torch
from scipy.spatial.transform import Rotation

from sim.training.places import pairs_of_places, place_loss


def _poses(positions, yaws):
    T = np.tile(np.eye(4), (len(yaws), 1, 1))
    T[:, :3, :3] = Rotation.from_rotvec(np.outer(yaws, (0, 0, 1))).as_matrix()
    T[:, :2, 3] = positions
    return T


def test_bounds_of_a_place_are_those_of_a_revisit():
    T = _poses([(0, 0), (0.95, 0), (0, 0), (1.2, 0), (1.6, 0), (0, 0), (0, 0)], [0.0, 0.0, 0.45, 0.0, 0.0, 0.8, 0.0])
    same, apart = pairs_of_places(T, np.array([1, 1, 1, 1, 1, 1, 2]), np.zeros(7, int))
    assert same[0].tolist() == [False, True, True, False, False, False, False]
    assert apart[0].tolist() == [False, False, False, False, True, True, True]


def test_a_doorway_is_neither_one_place_nor_two():
    T = _poses([(0, 0), (0.5, 0), (0.6, 0)], [0.0, 0.0, 0.0])
    same, apart = pairs_of_places(T, np.zeros(3, int), np.array([4, 4, 9]))
    assert same.sum() == 2 and same[0, 1] and not apart.any()


def test_pairs_are_mutual_exclusive_and_the_same_wherever_the_house_stands():
    rng = np.random.default_rng(0)
    T, houses = _poses(rng.uniform(0, 4, (60, 2)), rng.uniform(-1, 1, 60)), rng.integers(0, 2, 60)
    rooms = rng.integers(0, 2, 60)
    same, apart = pairs_of_places(T, houses, rooms)
    moved = np.eye(4)
    moved[:3, :3], moved[:3, 3] = Rotation.random(random_state=1).as_matrix(), (3.0, -2.0, 1.0)
    assert same.any() and apart.any() and not (same & apart).any() and not same.diagonal().any()
    for pairs, elsewhere in zip((same, apart), pairs_of_places(moved @ T, houses, rooms), strict=True):
        assert np.array_equal(pairs, pairs.T) and np.array_equal(pairs, elsewhere)


def test_the_loss_is_the_cross_entropy_of_the_own_place():
    """Compared with a plain softmax over the frame's own place and all others, one pair at a time."""
    rng = np.random.default_rng(1)
    T, houses = _poses(rng.uniform(0, 5, (30, 2)), rng.uniform(-0.5, 0.5, 30)), np.zeros(30, int)
    same, apart = pairs_of_places(T, houses, houses)
    unit = rng.normal(size=(30, 8))
    unit /= np.linalg.norm(unit, axis=1, keepdims=True)
    odds = np.exp(unit @ unit.T / 0.07)
    surprise = [
        np.mean([-np.log(odds[i, j] / (odds[i, j] + odds[i, apart[i]].sum())) for j in np.flatnonzero(same[i])])
        for i in range(30)
        if same[i].any()
    ]
    loss = place_loss(torch.from_numpy(unit @ unit.T), torch.from_numpy(same), torch.from_numpy(apart))
    np.testing.assert_allclose(float(loss), np.mean(surprise), rtol=1e-9)


def test_without_a_second_look_there_is_nothing_to_learn():
    cosines = torch.ones(3, 3, requires_grad=True)
    loss = place_loss(cosines, torch.zeros(3, 3, dtype=torch.bool), torch.ones(3, 3, dtype=torch.bool))
    loss.backward()
    assert loss.item() == 0.0 and not cosines.grad.any()
