"""Agreement of two estimates needs no truth: it is 1 for equal claims, and blind to names and frames of reference."""

from dataclasses import replace

import numpy as np
import pytest

from sim.harness import Estimate, LoopClaims
from sim.suites.agreement import agreement

N = 12


@pytest.fixture
def claims(rng):
    poses = np.tile(np.eye(4), (N, 1, 1))
    poses[:, :3, 3] = np.cumsum(rng.normal(size=(N, 3)), axis=0)
    loops = LoopClaims(np.array([9, 11]), np.array([1, 0]), np.tile(np.eye(4), (2, 1, 1)), np.ones(2))
    return Estimate(
        np.arange(0, 3 * N, 3), T_W_B=poses, labels=rng.integers(0, 3, N), rooms=np.arange(N) // 4,
        floors=np.zeros(N, int), loops=loops,
    )  # fmt: skip


def test_an_estimate_agrees_with_itself(claims):
    found = agreement(claims, claims)
    assert (found.frames, found.labels, found.rooms, found.floors, found.loops) == (1.0, 1.0, 1.0, 1.0, 1.0)
    assert found.position_m < 1e-9


def test_other_numbers_of_rooms_and_another_world_frame_change_nothing(claims):
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = [[0, -1, 0], [1, 0, 0], [0, 0, 1]], [5, 6, 7]
    found = agreement(claims, replace(claims, rooms=7 - claims.rooms, T_W_B=T @ claims.T_W_B))
    assert found.rooms == 1.0 and found.position_m < 1e-9


def test_what_differs_is_measured(claims):
    labels, rooms = claims.labels.copy(), np.zeros(N, int)
    labels[:3] += 1
    poses = claims.T_W_B.copy()
    poses[5, 2, 3] += 1.0
    other = replace(claims, labels=labels, rooms=rooms, T_W_B=poses, loops=replace(claims.loops, match=np.array([1, 2])))
    found = agreement(claims, other)
    assert found.labels == 0.75 and found.rooms < 0.1 and found.loops == pytest.approx(1 / 3)
    assert 0.5 < found.position_m < 1.0


def test_frames_are_matched_by_their_index(claims):
    half = Estimate(claims.frames[::2], labels=claims.labels[::2])
    found = agreement(claims, half)
    assert (found.frames, found.labels) == (0.5, 1.0)
    assert found.rooms is found.floors is found.loops is found.position_m is None


def test_estimates_without_a_common_frame_agree_on_nothing(claims):
    found = agreement(claims, replace(claims, frames=claims.frames + 1))
    assert found.frames == 0.0 and found.labels is found.position_m is None
