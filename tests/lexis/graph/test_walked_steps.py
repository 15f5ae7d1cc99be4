"""The steps of a walk: a gap in the recording is measured in the plan, and none leads from one session to another."""

import numpy as np
import pytest

from lexis.graph.walked_steps import walked_pairs
from lexis.keyframes import MAX_STEP_M


@pytest.mark.parametrize(("step", "walked"), [
    ((MAX_STEP_M, 0.0, 0.0), True),
    ((MAX_STEP_M + 1e-12, 0.0, 0.0), True),
    ((MAX_STEP_M + 1e-3, 0.0, 0.0), False),
    ((0.6 * MAX_STEP_M, 0.9 * MAX_STEP_M, 0.0), False),
    ((0.0, 0.1, 4.0), True),
])  # fmt: skip
def test_a_gap_is_longer_than_the_largest_step_in_the_plan(step, walked):
    positions = np.cumsum([np.zeros(3), (0.5, 0.0, 0.0), step], axis=0)
    assert walked_pairs(positions, np.zeros(3, int)).tolist() == [[0, 1]] + [[1, 2]] * walked


def test_no_step_leads_from_one_session_to_the_next():
    assert walked_pairs(np.zeros((4, 3)), np.array([0, 0, 1, 1])).tolist() == [[0, 1], [2, 3]]
    assert walked_pairs(np.zeros((1, 3)), np.zeros(1, int)).shape == (0, 2)
