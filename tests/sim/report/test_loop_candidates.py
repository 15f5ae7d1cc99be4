"""The report counts every loop candidate once, and lists those that became false loops and those that were missed."""

from dataclasses import replace

import numpy as np
import pytest

from sim.errors import SimError
from sim.report import ReportData, render_report
from sim.report.data import CandidateMark, KeyframeTable, LoopMark
from sim.report.loop_candidates import candidate_lists, reason_counts

ROWS = 40


def mark(query, match, reason, revisit, accepted=False, **figures):
    return CandidateMark(query, match, accepted, reason, figures, 0.25 if revisit else 7.5, revisit)


MARKS = (
    mark(20, 1, "accepted", True, accepted=True, inliers=30.0),
    mark(21, 9, "accepted", False, accepted=True, inliers=16.0),
    mark(22, 2, "few matches", True, matches=4.0),
    mark(20, 2, "few matches", True, matches=5.0),
    mark(23, 8, "few matches", False),
    mark(24, 8, "few <b>inliers</b>", False, inliers=3.0),
)
LOOPS = (LoopMark(20, 1, True, 1.0), LoopMark(21, 9, False, 0.5))


@pytest.fixture
def data():
    poses, labels = np.tile(np.eye(4), (ROWS, 1, 1)), np.zeros(ROWS, int)
    rooms = ("kitchen",) * ROWS
    table = KeyframeTable(np.arange(float(ROWS)), poses, poses, poses, labels, labels, labels, labels, rooms, rooms)
    return ReportData({"seed": 1}, ("kitchen",), (), table, LOOPS, candidates=MARKS)


def test_every_candidate_is_counted_once(data):
    rows = [(row.reason, row.revisits, row.others) for row in reason_counts(data)]
    assert rows == [("accepted", 1, 1), ("few matches", 2, 1), ("few <b>inliers</b>", 0, 1)]
    assert sum(row.revisits + row.others for row in reason_counts(data)) == len(MARKS)


def test_false_loops_and_missed_revisits_are_listed(data):
    """The candidate (20, 2) is not missed, because keyframe 20 has a true loop edge to another one."""
    false, missed = candidate_lists(data)
    assert [(m.query, m.match) for m in false.shown] == [(21, 9)] and false.figures == ("inliers",)
    assert [(m.query, m.match) for m in missed.shown] == [(22, 2)] and missed.figures == ("matches",)


def test_long_lists_are_cut_and_say_so(data):
    many = tuple(mark(30, i, "few matches", True, matches=float(i)) for i in range(20))
    (missed,) = candidate_lists(replace(data, loops=(), candidates=many))
    assert [m.match for m in missed.shown] == list(range(8, 20)) and missed.more == 8
    assert "8 more are not shown" in render_report(replace(data, loops=(), candidates=many))


def test_the_page_shows_them_and_escapes_reasons(data):
    page = render_report(data)
    assert 'id="candidate-reasons"' in page and "Missed revisits" in page and "False loops" in page
    assert "few &lt;b&gt;inliers" in page and "<b>inliers" not in page
    assert "loop-candidates" not in render_report(replace(data, candidates=()))


def test_candidates_of_keyframes_that_do_not_exist_are_refused(data):
    with pytest.raises(SimError, match="must name keyframes"):
        replace(data, candidates=(mark(ROWS, 1, "accepted", True),))
