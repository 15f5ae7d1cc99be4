"""Labels follow the images that show a place, and not the image that was taken there."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from scipy.sparse import csr_array

from lexis.config import SightConfig
from lexis.sight.pooled_labels import pool_labels

KITCHEN, OFFICE = [0.5, 0.1, 0.1], [0.1, 0.5, 0.1]


def random_views(seed, n):
    rng = np.random.default_rng(seed)
    sees = np.where(rng.random((n, n)) < 0.4, rng.random((n, n)), 0.0)
    return rng.uniform(-0.2, 0.6, (n, 3)), csr_array(sees)


def test_an_image_that_nobody_shares_keeps_its_label():
    labels, probabilities = pool_labels(np.array([[KITCHEN], [OFFICE]]), [csr_array((2, 2))], SightConfig())
    assert labels.tolist() == [0, 1]
    np.testing.assert_allclose(probabilities.sum(axis=1), 1.0)


def test_a_keyframe_that_looks_into_the_next_room_gets_the_label_of_its_own():
    # Keyframes 0 to 2 stand in the kitchen, 3 to 5 in the office; keyframe 2 stands in the door and looks into the office.
    sees = np.zeros((6, 6))
    sees[:3, :2], sees[3:, 2:] = 0.3, 0.3
    images = np.array([KITCHEN, KITCHEN, OFFICE, OFFICE, OFFICE, OFFICE])
    assert pool_labels(images[:, None], [csr_array(sees)], SightConfig())[0].tolist() == [0, 0, 0, 1, 1, 1]


@given(seed=st.integers(0, 2**32 - 1), n=st.integers(1, 20))
def test_labels_do_not_depend_on_the_order_of_keyframes_or_names(seed, n):
    similarities, sees = random_views(seed, n)
    rng = np.random.default_rng(seed)
    rows, names = rng.permutation(n), rng.permutation(3)
    labels, probabilities = pool_labels(similarities[:, None], [sees], SightConfig())
    moved_labels, moved = pool_labels(similarities[rows][:, None, names], [sees[rows][:, rows]], SightConfig())
    np.testing.assert_allclose(moved, probabilities[rows][:, names], atol=1e-9)
    np.testing.assert_array_equal(names[moved_labels], labels[rows])


@given(seed=st.integers(0, 2**32 - 1), n=st.integers(1, 20))
def test_probabilities_are_the_weighted_product_of_the_images_probabilities(seed, n):
    similarities, sees = random_views(seed, n)
    config = SightConfig()
    shares = np.exp(similarities.round(6) / config.temperature)
    evidence = np.log(shares / shares.sum(axis=1, keepdims=True) + config.least_probability)
    expected = np.exp(config.independence * (sees.toarray() + config.own_weight * np.eye(n)) @ evidence)
    probabilities = pool_labels(similarities[:, None], [sees], config).probabilities
    np.testing.assert_allclose(probabilities, expected / expected.sum(axis=1, keepdims=True), rtol=1e-6, atol=1e-12)


def test_a_name_that_is_excluded_is_never_a_label():
    similarities = np.array([[-np.inf, 0.1, 0.2], [-np.inf, 0.5, 0.2]])
    labels, probabilities = pool_labels(similarities[:, None], [csr_array(np.ones((2, 2)))], SightConfig())
    assert 0 not in labels.tolist()
    np.testing.assert_array_equal(probabilities[:, 0], 0.0)
    np.testing.assert_allclose(probabilities.sum(axis=1), 1.0)


def test_a_name_that_is_excluded_is_no_label_of_a_place_that_no_image_shows():
    similarities = np.array([[-np.inf, 0.1, 0.2], [-np.inf, 0.5, 0.2]])
    nowhere = [csr_array((2, 2))]
    labels, _ = pool_labels(similarities[:, None], nowhere, SightConfig(own_weight=0.0))
    assert labels.tolist() == [1, 1]


@given(seed=st.integers(0, 2**32 - 1), n=st.integers(1, 20))
def test_two_cameras_that_see_the_same_give_the_labels_of_one(seed, n):
    similarities, sees = random_views(seed, n)
    once = pool_labels(similarities[:, None], [sees], SightConfig())
    twice = pool_labels(np.stack([similarities, similarities], axis=1), [sees, sees], SightConfig())
    np.testing.assert_array_equal(once[0], twice[0])
    np.testing.assert_allclose(once[1], twice[1], atol=1e-9)


def test_a_second_camera_that_sees_the_own_room_outvotes_one_that_looks_into_the_next():
    sees = [csr_array(np.array([[0.1, 0.0], [0.4, 0.5]])), csr_array(np.array([[0.6, 0.0], [0.0, 0.5]]))]
    images = np.array([[OFFICE, KITCHEN], [OFFICE, OFFICE]])
    alone = pool_labels(images[:, :1], sees[:1], SightConfig())[0]
    assert (alone.tolist(), pool_labels(images, sees, SightConfig())[0].tolist()) == ([1, 1], [0, 1])
