from dataclasses import replace

import numpy as np
import pytest
from helpers.box_room import FORWARD_CAMERA

from lexis.config import Config, LabelConfig, SegmentationConfig, SightConfig
from lexis.maths import se3
from lexis.room_labels import similarities
from lexis.semantics import Views, derive
from lexis.sight.visible_space import VisibleSpace

NAMES = ("kitchen", "office", "stairs")
TEXT = np.eye(3, dtype=np.float32)


def views(embeddings, T, sessions=None):
    """Views of cameras that only know their own places; without `sessions`, all are of one session."""
    alone = VisibleSpace(np.zeros((1, 3)), np.ones(1))
    camera = replace(FORWARD_CAMERA, T_B_C=np.eye(4))
    return Views(
        similarities(embeddings[:, None], TEXT),
        [(alone,)] * len(T),
        T,
        camera,
        np.zeros(len(T), int) if sessions is None else sessions,
    )


@pytest.fixture
def walk(rng):
    """Ten keyframes in a kitchen, then ten in an office, about half a metre apart; every image is slightly ambiguous."""
    T = np.tile(np.eye(4), (20, 1, 1))
    steps = np.arange(20) - 9.5
    T[:, 0, 3] = 0.5 * steps - 1e-4 * steps**3  # closer away from the door: no two neighbours are equally near
    embeddings = np.repeat(TEXT[:2], 10, axis=0) + rng.uniform(0.0, 0.3, (20, 3)).astype(np.float32)
    return embeddings / np.linalg.norm(embeddings, axis=1, keepdims=True), T


def test_a_clear_walk_gives_its_two_rooms(walk):
    result = derive(views(*walk), NAMES, Config())
    assert [(room.label, room.keyframes) for room in result.rooms] == [
        ("kitchen", tuple(range(10))),
        ("office", tuple(range(10, 20))),
    ]
    np.testing.assert_array_equal(result.labels, np.repeat([0, 1], 10))
    np.testing.assert_allclose(result.similarities, walk[0] @ TEXT.T, atol=1e-6)


def test_labels_that_are_given_are_not_corrected_by_sight(walk):
    given = np.repeat([0, 1], 10)
    given[5] = 1  # one keyframe of an office in the kitchen
    config = Config(segmentation=SegmentationConfig(method="sight"))
    np.testing.assert_array_equal(derive(views(*walk), NAMES, config, given).labels, given)
    image = Config(segmentation=SegmentationConfig(method="sight"), labels=LabelConfig(method="image"))
    found = derive(views(*walk), NAMES, image)
    np.testing.assert_array_equal(found.labels, found.baseline_labels)
    found.labels[:] = 2  # a caller may change the labels of a map
    assert 2 not in found.baseline_labels


def test_labels_that_are_given_are_not_corrected_however_easily_rooms_merge(walk):
    """All keyframes see each other, and no odds are too large for rooms to merge."""
    given = np.repeat([0, 1], 10)
    config = Config(
        segmentation=SegmentationConfig(method="sight"), sight=SightConfig(near_m=20.0, merge_cut=0.01, merge_log_odds=100.0)
    )
    assert len(derive(views(*walk), NAMES, config).rooms) == 1
    found = derive(views(*walk), NAMES, config, given)
    np.testing.assert_array_equal(found.labels, given)
    assert [room.label for room in found.rooms] == ["kitchen", "office"]


def test_a_corrected_label_is_as_probable_as_the_label_in_whose_place_it_is(walk):
    sight = SightConfig(near_m=20.0, merge_cut=0.01, merge_log_odds=100.0, own_weight=10.0)
    usual, after = (
        derive(views(*walk), NAMES, Config(segmentation=SegmentationConfig(method=method), sight=sight))
        for method in ("distance", "sight")
    )
    assert len(after.rooms) == 1 and (after.labels != usual.labels).any()
    each = np.arange(20)
    np.testing.assert_array_equal(after.probabilities[each, after.labels], usual.probabilities[each, usual.labels])
    np.testing.assert_array_equal(after.probabilities[each, usual.labels], usual.probabilities[each, after.labels])
    np.testing.assert_allclose(after.probabilities.sum(axis=1), 1.0)


def test_the_meaning_does_not_depend_on_where_the_world_s_origin_lies(walk):
    embeddings, T = walk
    elsewhere = se3.exp(np.array([0.0, 0.0, 2.0, 30.0, -20.0, 5.0]))
    here, there = (derive(views(embeddings, poses), NAMES, Config()) for poses in (T, elsewhere @ T))
    np.testing.assert_array_equal(here.labels, there.labels)
    np.testing.assert_array_equal(here.floors, there.floors)
    assert [room.keyframes for room in here.rooms] == [room.keyframes for room in there.rooms]


@pytest.mark.parametrize("method", ["sight", "distance"])
def test_offices_of_two_sessions_are_not_one_because_nobody_walked_from_one_to_the_other(method):
    """Two offices 20 m apart, of which the second is 0.9 m higher."""
    T = np.tile(np.eye(4), (20, 1, 1))
    T[:, 0, 3] = 0.5 * np.arange(20) + np.repeat([0.0, 20.0], 10)
    T[10:, 2, 3] = 0.9
    seen = views(np.tile(TEXT[1], (20, 1)), T, np.repeat([3, 5], 10))
    config = Config(segmentation=SegmentationConfig(method=method))
    found = [(room.label, room.keyframes, room.floor) for room in derive(seen, NAMES, config).rooms]
    assert found == [("office", tuple(range(10)), 0), ("office", tuple(range(10, 20)), 0)]


def test_stairs_separate_floors_under_the_name_that_the_settings_give_them():
    """Six keyframes in a kitchen, ten on stairs up 3 m, and six in an office."""
    T = np.tile(np.eye(4), (22, 1, 1))
    T[:, 0, 3], T[:, 2, 3] = 0.5 * np.arange(22), np.interp(np.arange(22), [5, 16], [0.0, 3.0])
    seen = views(np.repeat(TEXT[:2], 11, axis=0), T)
    config = Config(labels=LabelConfig(stairs_name="staircase"))
    usual = derive(seen, NAMES, Config()).floors
    assert set(usual.tolist()) == {-1, 0, 1}
    np.testing.assert_array_equal(derive(seen, (*NAMES[:2], "staircase"), config).floors, usual)
    assert set(derive(seen, NAMES, config).floors.tolist()) != {-1, 0, 1}
