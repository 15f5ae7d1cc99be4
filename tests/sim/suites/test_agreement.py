"""Agreement of two estimates needs no truth: it is 1 for equal estimates, and blind to names and frames of reference."""

from dataclasses import replace

import numpy as np
import pytest

from sim.harness import Estimate, EstimatedLoops
from sim.suites.agreement import agreement

N = 12


@pytest.fixture
def estimates(rng):
    poses = np.tile(np.eye(4), (N, 1, 1))
    poses[:, :3, 3] = np.cumsum(rng.normal(size=(N, 3)), axis=0)
    loops = EstimatedLoops(np.array([9, 11]), np.array([1, 0]), np.tile(np.eye(4), (2, 1, 1)), np.ones(2))
    return Estimate(
        np.arange(0, 3 * N, 3), T_W_B=poses, labels=rng.integers(0, 3, N), rooms=np.arange(N) // 4,
        floors=np.zeros(N, int), loops=loops,
    )  # fmt: skip


def test_an_estimate_agrees_with_itself(estimates):
    found = agreement(estimates, estimates)
    assert (found.frames, found.labels, found.rooms, found.floors, found.loops) == (1.0, 1.0, 1.0, 1.0, 1.0)
    assert found.position_m < 1e-9


def test_other_numbers_of_rooms_and_another_world_frame_change_nothing(estimates):
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = [[0, -1, 0], [1, 0, 0], [0, 0, 1]], [5, 6, 7]
    found = agreement(estimates, replace(estimates, rooms=7 - estimates.rooms, T_W_B=T @ estimates.T_W_B))
    assert found.rooms == 1.0 and found.position_m < 1e-9


def test_what_differs_is_measured(estimates):
    labels, rooms = estimates.labels.copy(), np.zeros(N, int)
    labels[:3] += 1
    poses = estimates.T_W_B.copy()
    poses[5, 2, 3] += 1.0
    other = replace(
        estimates, labels=labels, rooms=rooms, T_W_B=poses, loops=replace(estimates.loops, match=np.array([1, 2]))
    )
    found = agreement(estimates, other)
    assert found.labels == 0.75 and found.rooms < 0.1 and found.loops == pytest.approx(1 / 3)
    assert 0.5 < found.position_m < 1.0


def test_frames_are_matched_by_their_index(estimates):
    half = Estimate(estimates.frames[::2], labels=estimates.labels[::2])
    found = agreement(estimates, half)
    assert (found.frames, found.labels) == (0.5, 1.0)
    assert found.rooms is found.floors is found.loops is found.position_m is None


def test_estimates_without_a_common_frame_agree_on_nothing(estimates):
    found = agreement(estimates, replace(estimates, frames=estimates.frames + 1))
    assert found.frames == 0.0 and found.labels is found.position_m is None


@pytest.mark.parametrize("stride_m", [0.5, 0.0])
def test_an_estimate_of_a_straight_path_or_of_a_single_place_agrees_with_itself(estimates, stride_m):
    """The positions do not tell how far such an estimate is rotated."""
    poses = np.tile(np.eye(4), (N, 1, 1))
    poses[:, :3, 3] = stride_m * np.arange(N)[:, None] * [0.6, 0.8, 0.0]
    straight = replace(estimates, T_W_B=poses)
    elsewhere = np.eye(4)
    elsewhere[:3, :3], elsewhere[:3, 3] = [[0, -1, 0], [1, 0, 0], [0, 0, 1]], [5, 6, 7]
    found = agreement(straight, replace(straight, T_W_B=elsewhere @ poses))
    assert found.position_m < 1e-6 and found.rotation_rad < 1e-6
