"""Patch features are unit vectors, and change where the image has changed."""

import numpy as np
from helpers.textured import textured

from sim.baselines.places.patches import patch_features


def test_features_are_unit_vectors_that_differ_between_cells():
    cells = patch_features(textured(1)).astype(np.float64)
    np.testing.assert_allclose(np.linalg.norm(cells, axis=1), 1.0, atol=2e-3)
    assert np.linalg.norm(cells - cells.mean(axis=0), axis=1).min() > 0.1


def test_cells_lie_in_rows_like_the_pixels():
    before = textured(1)
    for row, column in ((0, 0), (0, 9), (7, 0), (4, 6)):
        after = before.copy()
        part = slice(30 * row, 30 * row + 30), slice(32 * column, 32 * column + 32)
        after[part] = textured(2)[part]
        change = np.linalg.norm(patch_features(after).astype(float) - patch_features(before), axis=1)
        assert change.argmax() == 10 * row + column
