"""A robot is surely inside a room away from other rooms, and where images are sure of the label."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.map_builder import build_map, corridor_with_offices, random_pose, with_retired, with_retired_copies
from scipy.special import softmax

from lexis.planning import arrivals, path_end
from lexis.planning.arrivals import (
    BEHIND_DOORWAY_M,
    DIVIDED_M,
    IN_DOORWAY_M,
    INSIDE_M,
    NEAR_M,
    SURE,
    VERY_SURE,
    surely_inside,
)
from lexis.planning.evidence import evidence_at
from lexis.sight.passages import Passages
from lexis.types import NO_LANDMARKS

NO_DOORWAYS = Passages(np.zeros(0, int), np.zeros((0, 2, 2)))


def inside(lexis_map, room, clear=None, doorways=NO_DOORWAYS):
    """The keyframes that are surely inside; without `clear`, the evidence of the room itself is the clearest."""
    evidence = path_end(lexis_map, room).evidence if clear is None else clear
    return surely_inside(lexis_map, room, evidence, doorways).tolist()


def along_x(rng, x, labels, similarities=None):
    """A walk along x (n,) through a kitchen and an office, labelled 0 and 1, whose images show only their own places."""
    names = ("kitchen", "office")
    rooms = [(name, np.flatnonzero(labels == i).tolist()) for i, name in enumerate(names)]
    lexis_map = build_map(x[:, None] * [1.0, 0.0, 0.0], labels, rooms, names, rng)
    keyframes = tuple(replace(k, landmarks=NO_LANDMARKS) for k in lexis_map.keyframes)
    clear = np.where(labels[:, None] == [0, 1], 0.6, 0.1)
    images = clear if similarities is None else similarities
    return replace(lexis_map, keyframes=keyframes, similarities=images, probabilities=softmax(images / 0.05, axis=1))


def office_with(lexis_map, probability):
    """A map of a kitchen and an office whose images are equally sure of the office everywhere."""
    return replace(lexis_map, probabilities=np.tile([1.0 - probability, probability], (len(lexis_map.keyframes), 1)))


def doorway(x):
    """A narrow passage across the x axis."""
    return Passages(np.zeros(1, int), np.array([[[x, -0.5], [x, 0.5]]]))


def test_a_robot_is_surely_inside_as_far_from_other_rooms_as_needed(rng):
    x = np.arange(-3.0, 3.1, 0.1)
    lexis_map = along_x(rng, x, (x > -0.01).astype(int))
    found = x[inside(lexis_map, lexis_map.rooms[1])]
    assert INSIDE_M - 0.11 <= found.min() <= INSIDE_M + 0.5 and found.max() == x.max()


@pytest.mark.parametrize(("probability", "from_m"), [(VERY_SURE + 0.001, INSIDE_M), (SURE + 0.001, NEAR_M)])
def test_near_other_rooms_the_images_have_to_be_more_sure(rng, probability, from_m):
    x = np.arange(-3.0, 5.1, 0.1)
    lexis_map = office_with(along_x(rng, x, (x > -0.01).astype(int)), probability)
    found = x[inside(lexis_map, lexis_map.rooms[1], clear=0.01)]
    assert from_m - 0.11 <= found.min() <= from_m + 0.01
    np.testing.assert_array_equal(found, x[x >= found.min()])


def test_behind_a_doorway_a_robot_that_is_surely_inside_stays_so_farther_inside(rng):
    """The images are a little less sure than they have to be without a doorway."""
    x = np.arange(-3.0, 5.1, 0.1)
    lexis_map = office_with(along_x(rng, x, (x > 0.0).astype(int)), VERY_SURE - 0.001)
    found = x[inside(lexis_map, lexis_map.rooms[1], clear=0.01, doorways=doorway(0.05))]
    assert found.min() < INSIDE_M
    np.testing.assert_array_equal(found, x[x >= found.min()])


def test_behind_a_doorway_a_robot_is_surely_inside_sooner(rng):
    x = np.arange(-3.0, 3.1, 0.1)
    lexis_map = along_x(rng, x, (x > 0.0).astype(int))
    found = x[inside(lexis_map, lexis_map.rooms[1], doorways=doorway(0.05))]
    assert BEHIND_DOORWAY_M <= found.min() - 0.05 <= BEHIND_DOORWAY_M + 0.1 and found.max() == x.max()


def test_behind_a_doorway_the_evidence_does_not_count(rng):
    x = np.arange(-3.0, 5.1, 0.1)
    lexis_map = along_x(rng, x, (x > 0.0).astype(int))
    found = x[inside(lexis_map, lexis_map.rooms[1], clear=1e3, doorways=doorway(0.05))]
    assert found.min() < INSIDE_M and NEAR_M - 0.21 <= found.max() <= NEAR_M


def test_a_doorway_on_one_side_does_not_help_near_an_open_boundary_on_the_other_side(rng):
    x = np.arange(-3.0, 5.1, 0.1)
    lexis_map = office_with(along_x(rng, x, ((x > 0.0) & (x < 2.25)).astype(int)), VERY_SURE - 0.001)
    found = x[inside(lexis_map, lexis_map.rooms[1], clear=0.01, doorways=doorway(0.05))]
    assert found.min() < INSIDE_M and found.max() == pytest.approx(2.25 - DIVIDED_M, abs=0.11)


def test_a_label_without_any_doubt_is_sure_enough_behind_a_doorway(rng):
    x = np.arange(-3.0, 3.1, 0.1)
    lexis_map = along_x(rng, x, (x > 0.0).astype(int))
    found = [
        inside(office_with(lexis_map, 1.0 - doubt), lexis_map.rooms[1], doorways=doorway(0.05)) for doubt in (1e-3, 1e-9)
    ]
    assert found[0] == found[1] and x[found[0]].min() < INSIDE_M


def test_a_doorway_makes_no_difference_to_a_method_that_states_no_probability(rng):
    x = np.arange(-3.0, 3.1, 0.1)
    labels = (x > 0.0).astype(int)
    lexis_map = replace(along_x(rng, x, labels), probabilities=np.eye(2)[labels])
    office = lexis_map.rooms[1]
    assert inside(lexis_map, office, doorways=doorway(0.05)) == inside(lexis_map, office)


@pytest.mark.parametrize("door_x", [-0.95, 0.95, 5.0])
def test_a_doorway_that_does_not_divide_the_rooms_makes_a_difference_only_in_the_doorway(rng, door_x):
    x = np.arange(-3.0, 3.1, 0.1)
    lexis_map = along_x(rng, x, (x > 0.0).astype(int))
    office = lexis_map.rooms[1]
    expected = [k for k in inside(lexis_map, office) if abs(x[k] - door_x) > IN_DOORWAY_M]
    assert inside(lexis_map, office, doorways=doorway(door_x)) == expected


def test_a_robot_in_a_doorway_is_not_surely_inside_though_all_labels_near_it_are_those_of_the_room(rng):
    """The labels change one metre behind the doorway, at x = 0."""
    x = np.arange(-3.0, 3.1, 0.1)
    lexis_map = along_x(rng, x, (x > -0.01).astype(int))
    found = x[inside(lexis_map, lexis_map.rooms[1], doorways=doorway(1.05))]
    assert found.min() < 1.0 and (np.abs(found - 1.05) > IN_DOORWAY_M).all()


def test_the_nearest_other_label_counts_and_not_the_nearest_other_room(rng):
    """Where a wall divides an office into two rooms, a robot is surely in an office on both sides of it."""
    x = np.arange(-3.0, 3.1, 0.1)
    lexis_map = along_x(rng, x, (x > -2.0).astype(int))
    kitchen, office = lexis_map.rooms
    halves = [[k for k in office.keyframes if (x[k] > 0.5) == right] for right in (False, True)]
    rooms = (kitchen, *(replace(office, id=1 + i, keyframes=tuple(half)) for i, half in enumerate(halves)))
    divided = replace(lexis_map, rooms=rooms)
    both = [k for room in divided.rooms[1:] for k in inside(divided, room)]
    assert both == inside(lexis_map, office)


def test_a_robot_is_not_surely_inside_where_images_show_another_room(rng):
    """The images near x = 2 show a kitchen, though the keyframes there have the label of the office."""
    x = np.arange(-3.0, 5.1, 0.1)
    labels = (x > -0.01).astype(int)
    similarities = np.where(labels[:, None] == [0, 1], 0.6, 0.1)
    misled = np.flatnonzero(np.abs(x - 2.0) < 0.5)
    similarities[misled] = [0.6, 0.1]
    lexis_map = along_x(rng, x, labels, similarities)
    found = x[inside(lexis_map, lexis_map.rooms[1], clear=0.0)]
    assert not ((found > 1.5) & (found < 2.5)).any() and (found > 3.5).any()


def test_a_robot_is_not_surely_inside_at_a_keyframe_whose_own_images_are_unsure(rng):
    """One keyframe among many is a little less sure of the office than `SURE`."""
    x = np.arange(-3.0, 5.1, 0.1)
    lexis_map = along_x(rng, x, (x > -0.01).astype(int))
    unsure = int(np.argmin(np.abs(x - 2.5)))
    probabilities = lexis_map.probabilities.copy()
    probabilities[unsure] = [1.001 - arrivals.SURE, arrivals.SURE - 0.001]
    found = inside(replace(lexis_map, probabilities=probabilities), lexis_map.rooms[1])
    assert set(inside(lexis_map, lexis_map.rooms[1])) - set(found) == {unsure}


def least_share(lexis_map, room, keyframe):
    """The least evidence, as a share of the clearest, with which a keyframe is surely inside: found by bisection."""
    low, high = 0.01, 2.0
    own = float(evidence_at(lexis_map, room.label, np.array([keyframe]))[0])
    for _ in range(20):
        share = (low + high) / 2
        low, high = (low, share) if keyframe in inside(lexis_map, room, own / share) else (share, high)
    return high


def test_the_evidence_has_to_be_a_share_of_the_clearest(rng):
    x = np.arange(-3.0, 3.01, 0.25)
    lexis_map = along_x(rng, x, (x > -0.01).astype(int))
    office = lexis_map.rooms[1]
    shares = [least_share(lexis_map, office, int(np.flatnonzero(x == at)[0])) for at in (0.75, 1.0, 2.0)]
    assert shares == pytest.approx([arrivals.CLEAR] * 3, abs=1e-4)


def test_nowhere_is_sure_in_a_room_that_is_one_keyframe_wide(rng):
    x = np.arange(0.0, 4.1, 0.5)
    lexis_map = along_x(rng, x, (x == 2.0).astype(int))
    assert inside(lexis_map, lexis_map.rooms[1]) == []


def test_a_map_of_one_room_has_no_boundary(rng):
    x = np.arange(0.0, 4.1, 0.5)
    everywhere = list(range(len(x)))
    lexis_map = build_map(x[:, None] * [1.0, 0.0, 0.0], [0] * len(x), [("kitchen", everywhere)], ("kitchen", "office"), rng)
    assert inside(lexis_map, lexis_map.rooms[0]) == everywhere


def test_arrivals_do_not_depend_on_the_frame_of_the_map(rng):
    lexis_map = corridor_with_offices(rng)
    T_V_W = random_pose(rng, (3.0, -7.0, 1.0))
    moved = replace(lexis_map, T_W_B=T_V_W @ lexis_map.T_W_B)
    for room in lexis_map.rooms:
        assert inside(moved, room) == inside(lexis_map, room) != []


def test_further_visits_whose_keyframes_have_retired_change_nothing(rng):
    x = np.arange(-3.0, 3.1, 0.1)
    once = along_x(rng, x, (x > 0.0).astype(int))
    often = with_retired_copies(once, 50, 20)  # of a keyframe at which a robot is surely inside
    assert len(often.rooms[1].keyframes) == len(once.rooms[1].keyframes) + 20
    assert inside(often, often.rooms[1]) == inside(once, once.rooms[1])
    assert path_end(often, often.rooms[1]).keyframe == path_end(once, once.rooms[1]).keyframe


def test_a_path_may_end_in_a_room_whose_keyframes_have_all_retired(rng):
    lexis_map = corridor_with_offices(rng)
    retired = with_retired(lexis_map, dict.fromkeys(range(30, 40), 29))
    assert set(inside(retired, retired.rooms[2], clear=-10.0)) == set(inside(lexis_map, lexis_map.rooms[2], clear=-10.0))
