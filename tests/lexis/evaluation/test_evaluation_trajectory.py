"""Trajectory errors: ATE agrees with the package evo, RPE with its definition."""

import numpy as np
import pytest
from evo.core import metrics, sync
from evo.core.trajectory import PoseTrajectory3D
from evo.tools import file_interface
from scipy.spatial.transform import Rotation

from lexis.evaluation.relative import pairs_within
from lexis.evaluation.trajectory import align, ate_rmse, rpe_translation
from lexis.files.tum_trajectory import write_tum


def random_walk(rng, n=80, noise=0.3):
    """Poses with steps of about half a metre and random rotations."""
    poses = np.tile(np.eye(4), (n, 1, 1))
    poses[:, :3, :3] = Rotation.from_rotvec(np.cumsum(rng.normal(0.0, 0.1, (n, 3)), axis=0)).as_matrix()
    poses[:, :3, 3] = np.cumsum(rng.normal(0.0, noise, (n, 3)), axis=0)
    return poses


def moved(poses, rng):
    """The same trajectory expressed in another world frame."""
    T = np.eye(4)
    T[:3, :3] = Rotation.random(rng=rng).as_matrix()
    T[:3, 3] = rng.normal(0.0, 10.0, 3)
    return T @ poses


@pytest.mark.parametrize("seed", range(5))
def test_ate_is_evos(seed, tmp_path):
    rng = np.random.default_rng(seed)
    truth = random_walk(rng)
    estimate = moved(truth, rng)
    estimate[:, :3, 3] += np.cumsum(rng.normal(0.0, 0.05, (len(truth), 3)), axis=0)
    stamps = np.arange(len(truth)) * 0.1
    write_tum(tmp_path / "truth.tum", stamps, truth)
    write_tum(tmp_path / "estimate.tum", stamps, estimate)
    reference, other = (file_interface.read_tum_trajectory_file(tmp_path / f"{name}.tum") for name in ("truth", "estimate"))
    reference, other = sync.associate_trajectories(reference, other)
    other.align(reference)
    ape = metrics.APE(metrics.PoseRelation.translation_part)
    ape.process_data((reference, other))
    assert ate_rmse(estimate[:, :3, 3], truth[:, :3, 3]) == pytest.approx(
        ape.get_statistic(metrics.StatisticsType.rmse), abs=1e-6
    )


def test_ate_of_a_flat_walk_is_evos_too(rng):
    truth = random_walk(rng)
    truth[:, 2, 3] = 0.0
    estimate = truth.copy()
    estimate[:, :2, 3] += rng.normal(0.0, 0.1, (len(truth), 2))
    stamps = np.arange(len(truth)) * 0.1
    reference, other = (PoseTrajectory3D(poses_se3=list(poses), timestamps=stamps) for poses in (truth, estimate))
    other.align(reference)
    ape = metrics.APE(metrics.PoseRelation.translation_part)
    ape.process_data((reference, other))
    assert ate_rmse(estimate[:, :3, 3], truth[:, :3, 3]) == pytest.approx(
        ape.get_statistic(metrics.StatisticsType.rmse), abs=1e-9
    )


def test_alignment_undoes_a_motion_and_never_mirrors(rng):
    points = rng.normal(size=(20, 3))
    T = moved(np.eye(4), rng)
    np.testing.assert_allclose(align(points, points @ T[:3, :3].T + T[:3, 3]), T, atol=1e-9)
    assert np.linalg.det(align(points, points * [1, 1, -1])[:3, :3]) == pytest.approx(1.0)


def test_relative_errors_do_not_see_the_world_frame_but_see_drift(rng):
    truth = random_walk(rng, 200)
    assert rpe_translation(moved(truth, rng), truth, 5.0) == pytest.approx(0.0, abs=1e-9)
    straight = np.tile(np.eye(4), (101, 1, 1))
    straight[:, 0, 3] = np.arange(101) * 0.1
    stretched = straight.copy()
    stretched[:, 0, 3] *= 1.02
    assert rpe_translation(stretched, straight, 4.95) == pytest.approx(0.02 * 5.0)
    assert rpe_translation(stretched, straight, 10.5) is None


def test_figures_that_cannot_exist_are_none():
    assert ate_rmse(np.zeros((2, 3)), np.zeros((2, 3))) is None
    assert rpe_translation(np.zeros((0, 4, 4)), np.zeros((0, 4, 4)), 1.0) is None


@pytest.mark.parametrize("step_m", [0.2, 0.5])
def test_figures_of_an_even_walk_do_not_depend_on_where_the_house_lies(step_m, rng):
    """Frames at even distances are exactly at the limits, where the last digit of a coordinate must not decide."""
    truth = np.tile(np.eye(4), (60, 1, 1))
    truth[:, 0, 3] = step_m * np.arange(60)
    estimate = truth.copy()
    estimate[:, :3, 3] += np.cumsum(rng.normal(0.0, 0.02, (60, 3)), axis=0)
    shifted = [truth + np.eye(4)[[0]].T * np.eye(4)[3] * 0.1 * k for k in range(8)]
    assert len({round(rpe_translation(estimate, each, 8.0), 12) for each in shifted}) == 1
    assert len({len(pairs_within(each, 1.0)[0]) for each in shifted}) == 1
