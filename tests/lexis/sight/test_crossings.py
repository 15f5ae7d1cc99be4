"""Lines between keyframes cross passages as lines in the plane do, and gaps in the recording cross none."""

import numpy as np
import shapely
from hypothesis import given
from hypothesis import strategies as st

from lexis.sight.crossings import crossed, distances_from_crossed, distances_from_nearest
from lexis.sight.passages import Passages


@given(seed=st.integers(0, 2**32 - 1))
def test_lines_cross_passages_as_in_the_plane(seed):
    rng = np.random.default_rng(seed)
    positions, ends = rng.uniform(0.0, 2.0, (12, 3)), rng.uniform(0.0, 2.0, (4, 2, 2))
    floors, floor = rng.integers(0, 2, 12), rng.integers(0, 2, 4)
    pairs = np.stack(np.meshgrid(np.arange(12), np.arange(12)), axis=-1).reshape(-1, 2)
    lines, passages = shapely.linestrings(positions[pairs][:, :, :2]), shapely.linestrings(ends)
    expected = shapely.crosses(lines[:, None], passages) & (floors[pairs[:, :1]] == floor)
    found = Passages(floor, ends)
    np.testing.assert_array_equal(crossed(found, floors, positions, pairs), expected.any(axis=1))
    away = shapely.distance(shapely.points(positions[pairs[:, :1], :2]), passages)
    nearest = np.where(expected, away, np.inf).min(axis=1)
    np.testing.assert_allclose(distances_from_crossed(found, floors, positions, pairs), nearest, atol=1e-9)
    away = shapely.distance(shapely.points(positions[:, None, :2]), passages)
    nearest = np.where(floors[:, None] == floor, away, np.inf).min(axis=1)
    np.testing.assert_allclose(distances_from_nearest(found, floors, positions), nearest, atol=1e-9)


def test_a_gap_in_the_recording_crosses_no_passage():
    found = Passages(np.zeros(1, int), np.array([[[0.0, -0.4], [0.0, 0.4]]]))
    for metres, is_crossed in ((2.9, True), (3.1, False)):
        positions = np.array([[-metres / 2, 0.0, 0.0], [metres / 2, 0.0, 0.0]])
        assert crossed(found, np.zeros(2, int), positions, np.array([[0, 1]])).tolist() == [is_crossed]
