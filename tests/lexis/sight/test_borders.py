"""The label changes in the doorway beside the border, and nowhere else."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lexis.floors import NO_FLOOR
from lexis.sight.borders import borders_in_passages
from lexis.sight.passages import Passages


def doors(*x, floor=0):
    """Passages of 0.8 m across the x axis."""
    ends = np.array([[[at, -0.4], [at, 0.4]] for at in x], float).reshape(-1, 2, 2)
    return Passages(np.full(len(x), floor), ends)


def move(labels, found, spacing_m=0.5, border_m=0.75, floors=None, sessions=None):
    """Labels of keyframes on the x axis, from x = 0."""
    n = len(labels)
    positions = spacing_m * np.arange(n)[:, None] * [1.0, 0.0, 0.0]
    floors, sessions = (np.zeros(n, int) if each is None else np.array(each) for each in (floors, sessions))
    return borders_in_passages(np.array(labels, int), floors, positions, sessions, found, border_m).tolist()


@pytest.mark.parametrize(
    ("door_m", "expected"),
    [
        (1.75, [0, 0, 0, 0, 1, 1, 1, 1]),  # the border is in the door
        (1.25, [0, 0, 0, 1, 1, 1, 1, 1]),
        (2.25, [0, 0, 0, 0, 0, 1, 1, 1]),
        (2.75, [0, 0, 0, 0, 1, 1, 1, 1]),  # too far away
        (0.75, [0, 0, 0, 0, 1, 1, 1, 1]),
    ],
)
def test_a_border_moves_to_a_door_that_is_near(door_m, expected):
    labels = [0, 0, 0, 0, 1, 1, 1, 1]
    assert move(labels, doors(door_m)) == expected
    assert move(labels, doors(door_m), border_m=0.0) == labels


def test_a_border_moves_to_the_nearer_of_two_doors():
    assert move([0, 0, 0, 0, 1, 1, 1, 1], doors(0.75, 2.25), border_m=5.0) == [0, 0, 0, 0, 0, 1, 1, 1]


def test_a_border_stays_if_the_label_changes_again_before_the_door():
    labels = [0, 0, 0, 1, 2, 2, 2]
    assert move(labels, doors(2.25), border_m=1.0) == [0, 0, 0, 1, 1, 2, 2]  # only the second one moves


@pytest.mark.parametrize(
    "changed", [{"floors": [0, 0, 0, 1, 1, 1]}, {"floors": [NO_FLOOR] * 6}, {"sessions": [0, 0, 0, 1, 1, 1]}]
)
def test_borders_stay_on_stairs_and_between_floors_and_sessions(changed):
    labels = [0, 0, 0, 1, 1, 1]
    assert move(labels, doors(1.75)) == [0, 0, 0, 0, 1, 1]
    assert move(labels, doors(1.75), **changed) == labels


def test_a_door_on_another_floor_moves_nothing():
    labels = [0, 0, 0, 1, 1, 1]
    assert move(labels, doors(1.75, floor=1)) == labels


@pytest.mark.parametrize("n", [0, 1, 2])
def test_few_keyframes_have_their_labels(n):
    assert move(list(range(n)), doors(0.2)) == list(range(n))


@given(seed=st.integers(0, 2**32 - 1))
def test_the_direction_of_the_walk_and_the_frame_do_not_matter(seed):
    rng = np.random.default_rng(seed)
    n = int(rng.integers(2, 30))
    x = np.cumsum(rng.uniform(0.2, 0.8, n))
    labels, nothing = np.repeat(rng.integers(0, 3, n), 3)[:n], np.zeros(n, int)
    found = doors(*rng.uniform(0.0, x[-1], 4))
    there, back = x[:, None] * [1.0, 0.0, 0.0], x[::-1, None] * [1.0, 0.0, 0.0]
    forward = borders_in_passages(labels, nothing, there, nothing, found, 0.75)
    backward = borders_in_passages(labels[::-1], nothing, back, nothing, found, 0.75)
    np.testing.assert_array_equal(forward, backward[::-1])
    changed = np.flatnonzero(forward != labels)
    if len(changed):  # every moved label is that of a keyframe at most a few steps away
        near = np.abs(x[changed, None] - x) <= 1.6
        assert (near & (labels == forward[changed][:, None])).any(axis=1).all()
