import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from lexis.maths.stretches import consecutive_pairs, stretches_of


@given(values=st.lists(st.integers(0, 2)).map(lambda values: np.array(values, int)))
def test_consecutive_pairs_are_those_inside_the_stretches(values):
    inside = [(i, i + 1) for run in stretches_of(values) for i in range(run.start, run.stop - 1)]
    assert list(map(tuple, consecutive_pairs(values).tolist())) == inside
