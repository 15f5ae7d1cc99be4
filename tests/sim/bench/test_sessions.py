"""Sessions start along the walk of the second day, where enough of the walk follows."""

from dataclasses import replace

import numpy as np
import pytest

from lexis.types import Observation
from sim.bench.sessions import Day, starts

STILL = Observation(0, 0.0, np.zeros((1, 1, 3), np.uint8), np.eye(4), np.eye(6))


def walk(length_m, step_m=0.5):
    """A day with a straight walk, of which only the odometry is known."""
    poses = np.tile(np.eye(4), (round(length_m / step_m) + 1, 1, 1))
    poses[:, 0, 3] = step_m * np.arange(len(poses))
    seen = tuple(replace(STILL, index=i, stamp=0.1 * i, T_O_B=pose) for i, pose in enumerate(poses))
    day = object.__new__(Day)
    object.__setattr__(day, "observations", seen)
    return day


@pytest.mark.parametrize(("length_m", "at_m"), [(40.0, [0, 10, 20]), (26.0, [0, 10]), (20.0, [0]), (14.0, []), (0.0, [])])
def test_enough_of_the_walk_follows_every_start(length_m, at_m):
    day = walk(length_m)
    assert [day.observations[i].T_O_B[0, 3] for i in starts(day, every_m=10.0, length_m=15.0)] == at_m
