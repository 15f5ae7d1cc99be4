"""The benchmark of growth times every keyframe once and knows the size of the map."""

from itertools import pairwise

import numpy as np

from lexis.map.arrays import pack
from sim.bench.scale import bytes_per_keyframe, measure_scale


def test_portions_cover_the_walk_and_the_size_is_that_of_the_map():
    portions, finished = measure_scale(rooms=3, length_m=30.0, seed=302)
    assert portions[0].first == 0 and portions[-1].last == len(finished.keyframes) - 1
    assert all(before.last == after.first for before, after in pairwise(portions))
    assert all(portion.keyframe_ms > 0 for portion in portions)
    stored = sum(np.asarray(array).nbytes for array in pack(finished, features=True).values())
    assert bytes_per_keyframe(finished) * len(finished.keyframes) == stored
