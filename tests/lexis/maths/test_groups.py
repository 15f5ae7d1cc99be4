"""Groups of joined items: equal to those of a union of sets, and numbered by their first items."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from lexis.maths.groups import groups_of


@given(st.integers(1, 12), st.data())
def test_groups_are_the_unions_of_overlapping_pairs_in_the_order_of_their_first_items(count, data):
    item = st.integers(0, count - 1)
    pairs = np.array(data.draw(st.lists(st.tuples(item, item))), int).reshape(-1, 2)
    sets = [{i} for i in range(count)]
    for a, b in pairs.tolist():
        joined = sets[a] | sets[b]
        for i in joined:
            sets[i] = joined
    first = [min(each) for each in sets]
    numbers = {item: number for number, item in enumerate(sorted(set(first)))}
    assert groups_of(pairs, count).tolist() == [numbers[item] for item in first]
