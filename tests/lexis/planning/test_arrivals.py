"""The doubt that a robot is inside a room: none deep inside, more at the boundary and where images show another room."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.map_builder import build_map, corridor_with_offices, random_pose
from scipy.special import expit, logit, softmax

from lexis.planning import path_end
from lexis.planning.arrivals import CLEAR_SHARE, LEAST_SHARE, NEAR_M, SURE_LOG_ODDS, UNCLEAR_M, UNSURE_M, arrivals
from lexis.types import NO_LANDMARKS


def doubts(lexis_map, room, clearest=None):
    """The doubt at every possible end by keyframe; without `clearest`, the evidence of the room itself is the clearest."""
    innermost = path_end(lexis_map, room)
    found = arrivals(lexis_map, innermost, innermost.evidence if clearest is None else clearest)
    assert all(arrival.room is room for arrival in found)
    return {arrival.keyframe: arrival.doubt_m for arrival in found}


def along_x(rng, x, labels, similarities=None):
    """A walk along x (n,) through a kitchen and an office, labelled 0 and 1, whose images show only their own places."""
    names = ("kitchen", "office")
    rooms = [(name, np.flatnonzero(labels == i).tolist()) for i, name in enumerate(names)]
    lexis_map = build_map(x[:, None] * [1.0, 0.0, 0.0], labels, rooms, names, rng)
    keyframes = tuple(replace(k, landmarks=NO_LANDMARKS) for k in lexis_map.keyframes)
    clear = np.where(labels[:, None] == [0, 1], 0.6, 0.1)
    images = clear if similarities is None else similarities
    return replace(lexis_map, keyframes=keyframes, similarities=images, probabilities=softmax(images / 0.05, axis=1))


def kitchen_and_office(rng, spacing=0.1):
    x = np.arange(-3.0, 5.05, spacing)
    return x, along_x(rng, x, (x > -0.01).astype(int))


def test_the_doubt_falls_away_from_other_rooms_and_ends_inside(rng):
    x, lexis_map = kitchen_and_office(rng)
    found = doubts(lexis_map, lexis_map.rooms[1])
    at, metres = x[list(found)], np.array(list(found.values()))
    assert (np.diff(metres) <= 1e-6).all()
    assert metres[at < NEAR_M - 0.05].min() > 1.0 and metres[at > 2.0].max() == 0.0


def test_doubt_comes_from_other_labels_and_not_from_other_rooms_of_the_label(rng):
    """Where a wall divides an office into two rooms, a robot is surely in an office on both sides of it."""
    x = np.arange(-3.0, 3.1, 0.1)
    lexis_map = along_x(rng, x, (x > -2.0).astype(int))
    kitchen, office = lexis_map.rooms
    halves = [[k for k in office.keyframes if (x[k] > 0.5) == right] for right in (False, True)]
    rooms = (kitchen, *(replace(office, id=1 + i, keyframes=tuple(half)) for i, half in enumerate(halves)))
    divided, clearest = replace(lexis_map, rooms=rooms), path_end(lexis_map, office).evidence
    both = {k: doubt for room in divided.rooms[1:] for k, doubt in doubts(divided, room, clearest).items()}
    assert both == doubts(lexis_map, office)


def test_a_path_does_not_end_where_images_show_another_room(rng):
    """The images near x = 2 show a kitchen, though the keyframes there have the label of the office."""
    x = np.arange(-3.0, 5.1, 0.1)
    labels = (x > -0.01).astype(int)
    similarities = np.where(labels[:, None] == [0, 1], 0.6, 0.1)
    similarities[np.abs(x - 2.0) < 0.5] = [0.6, 0.1]
    lexis_map = along_x(rng, x, labels, similarities)
    at = x[list(doubts(lexis_map, lexis_map.rooms[1]))]
    assert not ((at > 1.5) & (at < 2.5)).any() and (at > 3.5).any()


def test_one_unsure_label_raises_the_doubt_nearby_by_the_log_odds_that_are_missing(rng):
    x, lexis_map = kitchen_and_office(rng)
    office, unsure, missing = lexis_map.rooms[1], int(np.argmin(np.abs(x - 3.5))), 1.5
    probabilities = lexis_map.probabilities.copy()
    probabilities[unsure, 1] = expit(SURE_LOG_ODDS - missing)
    found, before = (doubts(m, office) for m in (replace(lexis_map, probabilities=probabilities), lexis_map))
    own = path_end(lexis_map, office).keyframe
    near = {k for k in found if abs(x[k] - x[unsure]) < NEAR_M + 0.01} - {own}
    assert unsure in near and set(found) == set(before)
    assert {k: found[k] - before[k] for k in found} == pytest.approx(
        {k: UNSURE_M * missing if k in near else 0.0 for k in found}
    )


@pytest.mark.parametrize(("factor", "found"), [(0.9, False), (1.1, True)])
def test_the_evidence_has_to_be_a_share_of_the_clearest(rng, factor, found):
    """The innermost keyframe remains, so that every room has an end."""
    _, lexis_map = kitchen_and_office(rng, spacing=0.25)
    office = lexis_map.rooms[1]
    innermost = path_end(lexis_map, office)
    ends = doubts(lexis_map, office, innermost.evidence / (factor * LEAST_SHARE))
    assert innermost.keyframe in ends and (len(ends) > 1) == found


def test_unclear_evidence_is_doubt_in_proportion_to_the_share_that_is_missing(rng):
    x, lexis_map = kitchen_and_office(rng)
    office = lexis_map.rooms[1]
    share, evidence = 0.6, path_end(lexis_map, office).evidence
    found = doubts(lexis_map, office, evidence / share)
    deep = [doubt for k, doubt in found.items() if x[k] > 2.5]
    assert len(deep) > 20
    assert deep == pytest.approx([UNCLEAR_M * (CLEAR_SHARE - share)] * len(deep), abs=1e-6)


def test_where_no_label_is_sure_there_is_doubt_everywhere_but_at_the_innermost_keyframe(rng):
    x, lexis_map = kitchen_and_office(rng)
    office, unsure = lexis_map.rooms[1], np.full_like(lexis_map.probabilities, 0.1)
    unsure[np.arange(len(x)), lexis_map.labels] = 0.9
    found = doubts(replace(lexis_map, probabilities=unsure), office)
    others = np.array([doubt for keyframe, doubt in found.items() if keyframe != path_end(lexis_map, office).keyframe])
    assert len(others) == len(found) - 1 > 20
    assert found[path_end(lexis_map, office).keyframe] == 0.0
    assert others.min() == pytest.approx(UNSURE_M * (SURE_LOG_ODDS - logit(0.9)), abs=1e-6)


def test_a_room_without_evidence_has_one_end(rng):
    lexis_map = corridor_with_offices(rng)
    room, similarities = lexis_map.rooms[1], lexis_map.similarities.copy()
    similarities[list(room.keyframes), 2] = 0.9  # looks like a kitchen
    misread = replace(lexis_map, similarities=similarities)
    innermost = path_end(misread, room)
    assert innermost.evidence < 0.0 and doubts(misread, room) == {innermost.keyframe: 0.0}


def test_a_map_of_one_room_has_no_boundary(rng):
    x = np.arange(0.0, 4.1, 0.5)
    everywhere = list(range(len(x)))
    lexis_map = build_map(x[:, None] * [1.0, 0.0, 0.0], [0] * len(x), [("kitchen", everywhere)], ("kitchen", "office"), rng)
    assert doubts(lexis_map, lexis_map.rooms[0]) == dict.fromkeys(everywhere, 0.0)


def test_arrivals_do_not_depend_on_the_frame_of_the_map(rng):
    lexis_map = corridor_with_offices(rng)
    T_V_W = random_pose(rng, (3.0, -7.0, 1.0))
    moved = replace(lexis_map, T_W_B=T_V_W @ lexis_map.T_W_B)
    for room in lexis_map.rooms:
        assert doubts(moved, room) == pytest.approx(doubts(lexis_map, room), abs=1e-5)
