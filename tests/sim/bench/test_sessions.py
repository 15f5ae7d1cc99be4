"""Sessions start along the walk of the second day, where enough of the walk follows."""

from dataclasses import replace

import numpy as np
import pytest

from lexis.types import Observation
from sim.bench.sessions import NEAR_M, Day, SessionsRow, Start, return_to, starts, summary, walked_day
from worlds.presets import sample_from_rooms

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


def test_a_session_is_joined_to_its_own_house_where_the_robot_truly_is_and_to_no_twin():
    house = sample_from_rooms(("kitchen", "bedroom"), seed=21)
    first, second = walked_day(house, 1), walked_day(house, 2)
    at = starts(second, every_m=10.0, length_m=15.0)[0]
    (own, joined), (twin, apart) = (return_to(first, second, at, 15.0, twin=twin) for twin in (False, True))
    assert joined.joined_m <= NEAR_M and joined.error_m < 0.3 and apart == Start(None, None)
    assert len(own.keyframes) == len(twin.keyframes) > len(first.map.keyframes)


def test_the_summary_counts_same_houses_and_twins_apart():
    same = [Start(2.0, 0.1), Start(12.0, 1.4), Start(4.0, 0.2)]
    found = summary([(1, False, same[:2]), (1, True, [Start(None, None)]), (2, False, same[2:])])
    assert found == {
        "the same": SessionsRow(starts=3, joined=3, near=2, wrong=1, median_m=4.0, largest_error_m=1.4),
        "a twin": SessionsRow(starts=1, joined=0, near=0, wrong=0, median_m=None, largest_error_m=None),
    }
