"""Which keyframes may retire: those whose place earlier visits show, and never for the sake of neighbours on the path."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.map_builder import corridor_with_offices, with_rear_camera

from lexis.graph.thinning import STAYS, Retired, anchors, as_retired, fits, thinned_loops
from lexis.maths import se3
from lexis.types import LoopEdge


def corridor(visits, turned=()):
    """Poses of visits of a corridor of 20 poses, 0.5 m apart; the camera looks back in the visits `turned`."""
    T = np.tile(np.eye(4), (visits, 20, 1, 1))
    T[:, :, 0, 3] = 0.5 * np.arange(20)
    T[list(turned)] = T[list(turned)] @ np.diag([-1.0, -1.0, 1.0, 1.0])
    T = T.reshape(-1, 4, 4)
    return T, 0.5 * np.arange(len(T)) + np.repeat(20.0 * np.arange(visits), 20)  # the ways between the visits, too


def after_the_first(visits):
    """Whether each pose of `corridor` has a loop: those of all visits but the first."""
    return np.arange(20 * visits) >= 20


def test_on_a_first_visit_all_stay():
    T, path_m = corridor(1)
    assert (anchors(T, path_m, after_the_first(1), 1) == STAYS).all()


@pytest.mark.parametrize("copies", [1, 3, 5])
def test_later_visits_retire_but_their_ends(copies):
    found = anchors(*corridor(6), after_the_first(6), copies)
    assert (found[:20] == STAYS).all() and found[-1] == STAYS
    retired = np.flatnonzero(found != STAYS)
    assert len(retired) > 40
    assert (found[found[retired]] == STAYS).all() and (found[retired] < retired).all()


def test_the_more_copies_are_wanted_the_more_stay():
    stay = [(anchors(*corridor(6), after_the_first(6), copies) == STAYS).sum() for copies in (1, 3, 5, 9)]
    assert stay == sorted(stay) and stay[0] < stay[-1]


def test_the_anchor_is_the_nearest_keyframe_that_stays():
    T, path_m = corridor(2)
    found = anchors(T, path_m, after_the_first(2), 1)
    retired = np.flatnonzero(found != STAYS)
    np.testing.assert_array_equal(found[retired], retired - 20)


def test_an_opposite_view_shows_another_place():
    found = anchors(*corridor(2, turned=[1]), after_the_first(2), 1)
    assert (found == STAYS).all()


@pytest.mark.parametrize(("unlinked", "retire"), [([], True), ([47], True), (range(46, 50), True), (range(45, 55), False)])
def test_a_keyframe_without_a_loop_retires_only_between_near_ones_that_have_loops(unlinked, retire):
    linked = after_the_first(3)
    linked[list(unlinked)] = False
    found = anchors(*corridor(3), linked, 1)
    assert ((found[45:55] != STAYS) == retire).all() and (found[57:59] != STAYS).all()


def test_a_keyframe_at_a_new_place_keeps_those_before_and_after_it_unless_it_has_a_loop_itself():
    T, path_m = corridor(3)
    T[50, 1, 3] = 2.0  # two metres beside the corridor
    linked = after_the_first(3)
    assert np.flatnonzero(anchors(T, path_m, linked, 1)[45:55] == STAYS).tolist() == [5]
    linked[50] = False
    assert np.flatnonzero(anchors(T, path_m, linked, 1)[45:55] == STAYS).tolist() == [4, 5, 6]


def test_a_loop_fits_if_it_measured_nearly_the_current_pose_of_another_visit():
    T = np.tile(np.eye(4), (4, 1, 1))
    measured = se3.exp(np.array([[0, 0, 0, 0, 0, 0], [0, 0, 0, 0.2, 0, 0], [0, 0, 0, 0.4, 0, 0], [0, 0, 0.2, 0, 0, 0.0]]))
    assert fits(T, measured, np.full(4, 20.0)).tolist() == [True, True, False, False]
    assert not fits(T, measured, np.full(4, 5.0)).any()


def test_without_a_loop_no_keyframe_is_known_to_be_at_the_place():
    assert (anchors(*corridor(6), np.zeros(120, bool), 1) == STAYS).all()


def test_only_relative_poses_matter(rng):
    T, path_m = corridor(4)
    moved = se3.exp(rng.normal(size=6)) @ T
    np.testing.assert_array_equal(anchors(T, path_m, after_the_first(4), 2), anchors(moved, path_m, after_the_first(4), 2))


def test_who_was_anchored_to_a_keyframe_that_retires_follows_its_anchor(rng):
    T = se3.exp(rng.normal(size=(5, 6)))
    retired = Retired()
    assert retired.add_all(np.array([4]), np.array([2]), T) == {4: 2}
    assert retired.add_all(np.array([2, 3]), np.array([0, 1]), T) == {2: 0, 3: 1, 4: 0}
    assert dict(zip(retired.ids.tolist(), retired.anchors.tolist(), strict=True)) == {4: 0, 2: 0, 3: 1}
    ids, poses = retired.following(0, T)
    np.testing.assert_allclose(poses, T[ids], atol=1e-12)
    assert retired.following(1, T)[0].tolist() == [3]


def test_a_keyframe_that_retires_keeps_its_own_poses_and_shows_what_its_anchor_showed(rng):
    one, anchor = with_rear_camera(corridor_with_offices(rng), rng).keyframes[7:4:-2]
    gone = as_retired(one, anchor)
    assert gone.anchor == anchor.id and gone.embedding is anchor.embedding
    assert [view.embedding is own.embedding for view, own in zip(gone.others, anchor.others, strict=True)] == [True]
    assert not len(gone.points) and not any(len(view.features.keypoints) for view in gone.views)
    assert all(getattr(gone, name) is getattr(one, name) for name in ("T_O_B", "step_covariance", "stamp"))


def test_loops_from_retired_keyframes_go_but_the_first_one_between_two_sessions(rng):
    keyframes = list(corridor_with_offices(rng).keyframes)
    keyframes = [replace(each, session=int(each.id >= 20)) for each in keyframes]
    pairs = [(10, 1), (15, 1), (25, 3), (26, 3), (26, 21), (30, 4), (30, 25)]
    loops = [LoopEdge(query, match, np.eye(4), np.eye(6), 20) for query, match in pairs]
    assert thinned_loops(loops, keyframes) == loops
    for id in (10, 25, 26):
        keyframes[id] = as_retired(keyframes[id], keyframes[3])
    assert [(loop.query, loop.match) for loop in thinned_loops(loops, keyframes)] == [(15, 1), (25, 3), (30, 4), (30, 25)]
