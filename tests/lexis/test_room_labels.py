"""Labels: Eq. 1 of the paper, votes compared with a literal implementation of the paper's text, and invariances."""

from collections import Counter

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lexis.config import LabelConfig
from lexis.room_labels import Refined, label_keyframes, most_similar, propagate, similarities

NAMES = ("kitchen", "office", "corridor")


def walk(rng, n):
    """A path on one floor with steps of half a metre."""
    heading = np.cumsum(rng.normal(0.0, 0.5, n))
    steps = 0.5 * np.stack([np.cos(heading), np.sin(heading), np.zeros(n)], axis=1)
    return np.cumsum(steps, axis=0)


def test_similarity_is_the_cosine(rng):
    a, b = rng.normal(size=(7, 4)), rng.normal(size=(3, 4))
    expected = [[x @ y / (np.linalg.norm(x) * np.linalg.norm(y)) for y in b] for x in a]
    np.testing.assert_allclose(similarities(a, b), expected)
    np.testing.assert_allclose(similarities(3 * a, 0.2 * b), similarities(a, b))


def test_an_image_by_itself_has_the_label_that_it_has_among_others(rng):
    images, text = rng.normal(size=(30, 4)), rng.normal(size=(3, 4))
    labels = label_keyframes(similarities(images, text), walk(rng, 30), NAMES, LabelConfig())
    assert [most_similar(similarities(image, text)) for image in images] == labels.baseline.tolist()


def slow_pass(labels, scores, positions, neighbours):
    """One voting pass, node by node, as the paper describes it."""
    result = []
    for i, label in enumerate(labels):
        by_distance = sorted(
            (j for j in range(len(labels)) if j != i), key=lambda j: np.linalg.norm(positions[j] - positions[i])
        )
        nearest = by_distance[:neighbours]
        votes = Counter(labels[j] for j in nearest)
        most = [room for room, count in votes.items() if count == max(votes.values())]
        result.append(
            label if label in most or not most else max(most, key=lambda room: sum(scores[j][room] for j in nearest))
        )
    return result


@given(seed=st.integers(0, 2**32 - 1), n=st.integers(1, 40), c=st.integers(1, 8))
def test_a_pass_is_the_vote_of_the_nearest(seed, n, c):
    rng = np.random.default_rng(seed)
    scores, positions = rng.normal(size=(n, 3)), rng.normal(size=(n, 3))
    labels = rng.integers(0, 3, n)
    assert propagate(labels, scores, positions, c).tolist() == slow_pass(labels.tolist(), scores, positions, c)


def test_a_pass_does_not_depend_on_the_order_of_nodes(rng):
    scores, positions, labels = rng.normal(size=(50, 3)), rng.normal(size=(50, 3)), rng.integers(0, 3, 50)
    order = rng.permutation(50)
    shuffled = propagate(labels[order], scores[order], positions[order], 5)
    np.testing.assert_array_equal(shuffled, propagate(labels, scores, positions, 5)[order])


def test_refinement_is_one_pass_from_the_images_labels(rng):
    scores, positions = rng.normal(size=(25, 3)), walk(rng, 25)
    refined = label_keyframes(scores, positions, NAMES, LabelConfig(neighbours=5)).refined
    np.testing.assert_array_equal(refined, propagate(scores.argmax(axis=1), scores, positions, 5))


def test_a_wrong_image_inside_a_room_is_outvoted(rng):
    positions, truth = walk(rng, 60), np.repeat([0, 2, 1], 20)
    scores = np.eye(3)[truth] + rng.normal(0.0, 0.1, (60, 3))
    wrong = [5, 11, 30, 50]
    scores[wrong] = np.eye(3)[(truth[wrong] + 1) % 3]
    labels = label_keyframes(scores, positions, NAMES, LabelConfig())
    assert (labels.baseline[wrong] != truth[wrong]).all()
    assert (labels.refined[wrong] == truth[wrong]).all()


@given(seed=st.integers(0, 2**32 - 1))
def test_labels_do_not_depend_on_where_the_world_frame_is_or_how_rooms_are_ordered(seed):
    rng = np.random.default_rng(seed)
    scores, positions = rng.normal(size=(40, 3)), walk(rng, 40)
    expected = label_keyframes(scores, positions, NAMES, LabelConfig())
    yaw, order = rng.uniform(-np.pi, np.pi), rng.permutation(3)
    turn = np.array([[np.cos(yaw), -np.sin(yaw), 0.0], [np.sin(yaw), np.cos(yaw), 0.0], [0.0, 0.0, 1.0]])
    moved = label_keyframes(
        scores[:, order], positions @ turn.T + [3.0, -1.0, 2.0], tuple(NAMES[i] for i in order), LabelConfig()
    )
    np.testing.assert_array_equal(order[moved.refined], expected.refined)
    np.testing.assert_array_equal(order[moved.baseline], expected.baseline)


def test_climbing_alone_decides_on_stairs(rng):
    """A level walk, a climb of 12 steps, a level walk. Images suggest stairs only at the foot, where there are none."""
    names = (*NAMES, "stairs")
    positions = np.zeros((52, 3))
    positions[:, 0] = 0.4 * np.arange(52)
    positions[:, 2] = np.interp(np.arange(52), [20, 32], [0.0, 2.9])
    scores = np.tile([0.1, 0.2, 0.5, 0.0], (52, 1))
    scores[12:18, 3] = 0.9
    labels = label_keyframes(scores, positions, names, LabelConfig())
    assert (labels.baseline[12:18] == 3).all()
    climbing = labels.refined == 3
    assert climbing[21:32].all() and not climbing[:19].any() and not climbing[34:].any()
    assert (labels.refined[~climbing] == 2).all()


def test_the_case_of_the_name_of_the_stairs_makes_no_difference(rng):
    similarities, positions = rng.uniform(size=(40, 4)), np.zeros((40, 3))
    positions[:, 0] = 0.25 * np.arange(40)
    positions[15:, 2] = np.minimum(0.2 * np.arange(25), 3.0)
    plain, *others = (
        label_keyframes(similarities, positions, (stairs, *NAMES), LabelConfig(method="vote"))
        for stairs in ("stairs", "Stairs", "STAIRS")
    )
    assert (plain.refined == 0).any() and all(np.array_equal(other.refined, plain.refined) for other in others)


def test_stairs_are_not_sought_where_nobody_named_them(rng):
    positions = np.zeros((30, 3))
    positions[:, 2] = 0.3 * np.arange(30)
    scores = np.tile([0.1, 0.2, 0.5], (30, 1))
    assert (label_keyframes(scores, positions, NAMES, LabelConfig()).refined == 2).all()


@pytest.mark.parametrize("n", [0, 1, 2])
@pytest.mark.parametrize("names", [NAMES, (*NAMES, "stairs"), ("stairs",)])
def test_a_map_of_few_keyframes_has_labels(n, names):
    labels = label_keyframes(np.ones((n, len(names))), np.zeros((n, 3)), names, LabelConfig())
    assert labels.refined.shape == labels.baseline.shape == (n,)


def test_keyframes_at_one_place_vote_too():
    scores = np.eye(3)[[0, 0, 0, 1]]
    assert propagate(np.array([0, 0, 0, 1]), scores, np.zeros((4, 3)), 2).tolist() == [0, 0, 0, 0]


def test_without_refinement_every_keyframe_keeps_its_images_label(rng):
    scores, positions = rng.normal(size=(30, 3)), walk(rng, 30)
    labels = label_keyframes(scores, positions, NAMES, LabelConfig(method="image"))
    np.testing.assert_array_equal(labels.refined, labels.baseline)


@pytest.mark.parametrize("method", ["vote", "image"])
def test_methods_that_state_no_probability_are_certain_of_their_label(rng, method):
    scores, positions = rng.normal(size=(30, 3)), walk(rng, 30)
    labels = label_keyframes(scores, positions, NAMES, LabelConfig(method=method))
    np.testing.assert_array_equal(labels.probabilities, np.eye(3)[labels.refined])


def test_a_keyframe_on_a_climb_is_certainly_on_stairs_and_others_keep_the_probabilities_of_their_images(rng):
    names, positions = (*NAMES, "stairs"), np.zeros((52, 3))
    positions[:, 0] = 0.4 * np.arange(52)
    positions[:, 2] = np.interp(np.arange(52), [20, 32], [0.0, 2.9])

    def refine(scores, keyframes):
        return Refined(np.zeros(len(keyframes), int), np.tile([0.7, 0.2, 0.1, 0.0], (len(keyframes), 1)))

    labels = label_keyframes(rng.normal(size=(52, 4)), positions, names, LabelConfig(), refine)
    climbs = labels.refined == 3
    assert climbs.any() and (labels.probabilities[climbs] == [0.0, 0.0, 0.0, 1.0]).all()
    assert (labels.probabilities[~climbs] == [0.7, 0.2, 0.1, 0.0]).all()
