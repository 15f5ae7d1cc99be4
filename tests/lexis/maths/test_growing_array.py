"""An array that grows row by row equals the stacked rows, which nobody but the array itself can change."""

import numpy as np
import pytest

from lexis.maths.growing_array import GrowingArray


@pytest.mark.parametrize("count", [0, 1, 64, 65, 200])
@pytest.mark.parametrize("shape", [(), (4, 4)])
def test_its_rows_are_those_that_were_appended(count, shape):
    rows = np.random.default_rng(1).standard_normal((count, *shape))
    growing = GrowingArray(shape)
    for row in rows:
        growing.append(row)
    np.testing.assert_array_equal(growing.rows, rows)


def test_appended_rows_do_not_change_earlier_results():
    growing = GrowingArray(())
    growing.append(1.0)
    before = growing.rows
    for row in range(200):
        growing.append(row)
    assert before.tolist() == [1.0]
    growing.replace(np.array([0, 200]), np.array([3.0, 4.0]))
    assert growing.rows.tolist() == [3.0, *range(199), 4.0]
    with pytest.raises(ValueError, match="read-only"):
        before[0] = 9.0
