"""Conventions that are mistaken are told, and what is right or wrong in other ways is not."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from lexis.maths.se3 import between, inverse
from sim.bench.planted_bugs import floors, no_bug, planted
from sim.harness import EstimatedLoops, Scenario
from sim.harness.diagnosis.usual_mistakes import usual_mistakes
from worlds.presets import sample_from_rooms

TALL = Scenario(
    house=sample_from_rooms(("kitchen", "bedroom"), seed=4, storeys=2),
    seed=5,
    frame_rate_hz=2.0,
    fidelity="features",
    encoder="oracle",
)


def reordered(run):
    """A SLAM that writes its quaternions as w x y z, which are read as x y z w."""
    estimate = no_bug(run)
    poses = estimate.T_W_B.copy()
    quaternions = np.roll(Rotation.from_matrix(poses[:, :3, :3]).as_quat(), 1, axis=1)
    poses[:, :3, :3] = Rotation.from_quat(quaternions).as_matrix()
    return replace(estimate, T_W_B=poses)


def turned(run):
    """A SLAM whose world has another heading, and whose rotations are wrong in the last two thirds of the walk."""
    estimate = no_bug(run)
    turn = np.eye(4)
    turn[:3, :3] = Rotation.from_euler("z", 2.0).as_matrix()
    poses = turn @ estimate.T_W_B
    poses[len(poses) // 3 :] = poses[len(poses) // 3 :] @ turn
    return replace(estimate, T_W_B=poses)


def of_camera(run):
    """A SLAM that returns the poses of its camera."""
    estimate = no_bug(run)
    return replace(estimate, T_W_B=estimate.T_W_B @ run.session.camera.T_B_C)


def inverted(run):
    estimate = no_bug(run)
    return replace(estimate, T_W_B=inverse(estimate.T_W_B))


def without_rotations(run):
    estimate = no_bug(run)
    poses = estimate.T_W_B.copy()
    poses[:, :3, :3] = np.eye(3)
    return replace(estimate, T_W_B=poses)


def with_loops(run, turned_round):
    """A SLAM with true loops, whose relative poses lead from the earlier to the later frame, or the wrong way round."""
    estimate = no_bug(run)
    query = np.arange(20, len(estimate.frames), 9)
    truth = between(run.true_poses[query - 20], run.true_poses[query])
    return replace(estimate, loops=EstimatedLoops(query, query - 20, inverse(truth) if turned_round else truth))


def delayed(run, frames):
    """A SLAM whose poses are those of earlier frames, or of later ones if `frames` is negative."""
    estimate = no_bug(run)
    last = len(estimate.frames) - 1
    return replace(estimate, T_W_B=estimate.T_W_B[np.clip(np.arange(last + 1) - frames, 0, last)])


def from_one(run):
    return replace(no_bug(run), floors=run.true_floors + 1)


@pytest.mark.parametrize(
    ("bug", "told"),
    [
        (no_bug, []),
        (floors, []),
        (turned, []),
        (from_one, ["Every floor is 1 too high"]),
        (partial(delayed, frames=1), ["The poses seem to be 0.5 s too late"]),
        (partial(delayed, frames=-3), ["The poses seem to be 1.5 s too early"]),
        (reordered, ["The quaternions seem to be written as qw qx qy qz"]),
        (of_camera, ["The poses seem to be those of the camera"]),
        (inverted, ["The poses seem to be inverted"]),
        (without_rotations, ["All rotations are equal"]),
        (partial(with_loops, turned_round=False), []),
        (partial(with_loops, turned_round=True), ["The relative poses of the loops seem to be inverted"]),
    ],
)
def test_only_a_mistaken_convention_is_told(bug, told):
    found = list(usual_mistakes(planted(bug)(TALL, None)))
    assert len(found) == len(told) and all(text.startswith(start) for text, start in zip(found, told, strict=True))
