"""Which keyframes may retire: those whose place earlier visits show, and never for the sake of neighbours on the path."""

import numpy as np
import pytest

from lexis.graph.thinning import STAYS, Retired, anchors
from lexis.maths import se3


def corridor(visits, turned=()):
    """Poses of visits of a corridor of 20 poses, 0.5 m apart; the camera looks back in the visits `turned`."""
    T = np.tile(np.eye(4), (visits, 20, 1, 1))
    T[:, :, 0, 3] = 0.5 * np.arange(20)
    T[list(turned)] = T[list(turned)] @ np.diag([-1.0, -1.0, 1.0, 1.0])
    T = T.reshape(-1, 4, 4)
    return T, 0.5 * np.arange(len(T)) + np.repeat(20.0 * np.arange(visits), 20)  # the ways between the visits, too


def to_the_visit_before(visits):
    return np.array([(20 + k, k) for k in range(20 * (visits - 1))], int).reshape(-1, 2)


def test_on_a_first_visit_all_stay():
    T, path_m = corridor(1)
    assert (anchors(T, path_m, to_the_visit_before(1), 1) == STAYS).all()


@pytest.mark.parametrize("copies", [1, 3, 5])
def test_later_visits_retire_but_their_ends(copies):
    found = anchors(*corridor(6), to_the_visit_before(6), copies)
    assert (found[:20] == STAYS).all() and found[-1] == STAYS
    retired = np.flatnonzero(found != STAYS)
    assert len(retired) > 40
    assert (found[found[retired]] == STAYS).all() and (found[retired] < retired).all()


def test_the_more_copies_are_wanted_the_more_stay():
    stay = [(anchors(*corridor(6), to_the_visit_before(6), copies) == STAYS).sum() for copies in (1, 3, 5, 9)]
    assert stay == sorted(stay) and stay[0] < stay[-1]


def test_the_anchor_is_the_nearest_keyframe_that_stays():
    T, path_m = corridor(2)
    found = anchors(T, path_m, to_the_visit_before(2), 1)
    retired = np.flatnonzero(found != STAYS)
    np.testing.assert_array_equal(found[retired], retired - 20)


def test_an_opposite_view_shows_another_place():
    found = anchors(*corridor(2, turned=[1]), to_the_visit_before(2), 1)
    assert (found == STAYS).all()


def test_without_a_loop_no_keyframe_is_known_to_be_at_the_place():
    assert (anchors(*corridor(6), np.zeros((0, 2), int), 1) == STAYS).all()


def test_only_relative_poses_matter(rng):
    T, path_m = corridor(4)
    moved = se3.exp(rng.normal(size=6)) @ T
    np.testing.assert_array_equal(
        anchors(T, path_m, to_the_visit_before(4), 2), anchors(moved, path_m, to_the_visit_before(4), 2)
    )


def test_who_was_anchored_to_a_keyframe_that_retires_follows_its_anchor(rng):
    T = se3.exp(rng.normal(size=(5, 6)))
    retired = Retired().joined_by(np.array([4]), np.array([2]), T).joined_by(np.array([2, 3]), np.array([0, 1]), T)
    assert dict(zip(retired.ids.tolist(), retired.anchors.tolist(), strict=True)) == {4: 0, 2: 0, 3: 1}
    ids, poses = retired.following(0, T)
    np.testing.assert_allclose(poses, T[ids], atol=1e-12)
    assert retired.following(1, T)[0].tolist() == [3]
