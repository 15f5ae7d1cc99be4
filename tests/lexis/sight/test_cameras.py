"""Joining the cameras of a rig changes nothing if there is one camera."""

import numpy as np
from scipy.sparse import csr_array

from lexis.sight.cameras import largest, mean


def test_one_camera_is_left_as_it_is(rng):
    array, matrix = rng.normal(size=(4, 3)), csr_array(rng.random((4, 4)))
    assert mean([array]) is array and mean([matrix]) is matrix and largest([matrix]) is matrix


def test_means_and_largest_entries_are_those_of_dense_matrices(rng):
    dense = np.where(rng.random((3, 6, 6)) < 0.5, rng.random((3, 6, 6)), 0.0)
    matrices = [csr_array(each) for each in dense]
    np.testing.assert_allclose(mean(matrices).toarray(), dense.mean(axis=0))
    np.testing.assert_allclose(mean(list(dense)), dense.mean(axis=0))
    np.testing.assert_array_equal(largest(matrices).toarray(), dense.max(axis=0))
