"""Loop edges as arrays, and back."""

import numpy as np
import pytest

from lexis.types import LoopArrays, LoopEdge
from tests.helpers.map_builder import random_pose


def random_edges(rng, count):
    return tuple(
        LoopEdge(int(query), int(match), random_pose(rng, (1.0, 2.0, 3.0)), np.diag(rng.uniform(0.1, 1.0, 6)), int(inliers))
        for query, match, inliers in rng.integers(0, 100, (count, 3))
    )


@pytest.mark.parametrize("count", [0, 1, 7])
def test_the_edges_of_arrays_are_those_that_were_stacked(rng, count):
    edges = random_edges(rng, count)
    arrays = LoopArrays.of(edges)
    assert arrays.T_match_query.shape == (count, 4, 4) and arrays.covariance.shape == (count, 6, 6)
    again = arrays.edges()
    assert [(e.query, e.match, e.inliers) for e in again] == [(e.query, e.match, e.inliers) for e in edges]
    assert all(type(number) is int for e in again for number in (e.query, e.match, e.inliers))
    for edge, other in zip(again, edges, strict=True):
        np.testing.assert_array_equal(edge.T_match_query, other.T_match_query)
        np.testing.assert_array_equal(edge.covariance, other.covariance)


def test_arrays_without_edges_have_integer_indices():
    arrays = LoopArrays.of(())
    assert {arrays.query.dtype.kind, arrays.match.dtype.kind, arrays.inliers.dtype.kind} == {"i"}
