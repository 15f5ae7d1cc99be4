"""Recall@1 of revisits, compared with a literal implementation of its definition."""

import numpy as np
import pytest

from lexis.maths.se3 import between, rotation_angle
from sim.bench.encoders.retrieval import found_at_1, share

STAMPS = np.arange(40) * 1.5


def poses(x, y, yaw):
    T = np.tile(np.eye(4), (len(x), 1, 1))
    T[:, 0, 3], T[:, 1, 3] = x, y
    T[:, 0, 0] = T[:, 1, 1] = np.cos(yaw)
    T[:, 1, 0] = np.sin(yaw)
    T[:, 0, 1] = -T[:, 1, 0]
    return T


def unit(rows):
    return (rows / np.linalg.norm(rows, axis=1, keepdims=True)).astype(np.float32)


def alike(descriptors):
    return descriptors @ descriptors.T


def same_place(T_W_B, i, j):
    near = np.linalg.norm(T_W_B[i, :3, 3] - T_W_B[j, :3, 3]) <= 1.0
    return near and float(rotation_angle(between(T_W_B[i], T_W_B[j]))) <= 0.5


def by_definition(descriptors, T_W_B, groups):
    found = []
    for i in range(len(STAMPS)):
        if not any(STAMPS[i] - STAMPS[j] >= 10.0 and same_place(T_W_B, i, j) for j in range(i)):
            continue
        far = [j for j in range(len(STAMPS)) if abs(STAMPS[i] - STAMPS[j]) >= 10.0 and groups[i] == groups[j]]
        found.append(bool(far) and same_place(T_W_B, i, max(far, key=lambda j: descriptors[i] @ descriptors[j])))
    return float(np.mean(found))


@pytest.mark.parametrize("seed", range(4))
def test_agrees_with_the_definition(seed):
    rng = np.random.default_rng(seed)
    T_W_B = poses(rng.uniform(0, 3, 40), rng.uniform(0, 3, 40), rng.uniform(-0.6, 0.6, 40))
    descriptors, groups = unit(rng.normal(size=(40, 5))), rng.integers(0, 3, 40)
    assert share(found_at_1(alike(descriptors), T_W_B, STAMPS)) == pytest.approx(
        by_definition(descriptors, T_W_B, np.zeros(40))
    )
    in_groups = share(found_at_1(alike(descriptors), T_W_B, STAMPS, groups))
    assert in_groups == pytest.approx(by_definition(descriptors, T_W_B, groups))


def test_place_embeddings_find_revisits_and_time_embeddings_do_not():
    place = np.tile(np.arange(20), 2)
    T_W_B = poses(2.0 * place, 0.0 * place, 0.0 * place)
    where, when = unit(np.eye(20)[place] + 0.1), unit(np.column_stack([np.cos(STAMPS / 40), np.sin(STAMPS / 40)]))
    assert share(found_at_1(alike(where), T_W_B, STAMPS)) == 1.0
    assert share(found_at_1(alike(when), T_W_B, STAMPS)) < 0.2
    assert share(found_at_1(alike(where), T_W_B, STAMPS, np.arange(40))) == 0.0  # alone in its room: no match exists


def test_a_walk_that_never_comes_back_has_no_recall():
    x = np.arange(40) * 2.0
    assert share(found_at_1(np.ones((40, 40)), poses(x, 0 * x, 0 * x), STAMPS)) is None


def test_keyframes_that_are_ten_seconds_apart_but_for_rounding_are_candidates():
    x = np.array([0.0, 5.0, 0.0])
    stamps = np.array([0.3, 5.3, 10.299999999999998])
    assert stamps[2] - stamps[0] < 10.0
    assert found_at_1(np.ones((3, 3)), poses(x, 0 * x, 0 * x), stamps).tolist() == [True]
