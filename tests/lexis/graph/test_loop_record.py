"""The record of loops: what is added comes out in the order of the keyframes, and no change touches another keyframe."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from lexis.graph.loop_record import LoopRecord
from lexis.types import LoopDecision, LoopEdge

OUTCOMES = st.sampled_from(["accepted", "unconfirmed", "unsupported", "far from the estimate"])


@st.composite
def recorded(draw):
    """A record of a few keyframes, each with a decision on each candidate, and what was added to it."""
    record, added = LoopRecord(), {}
    for query in draw(st.lists(st.integers(5, 40), unique=True, max_size=6).map(sorted)):
        parts = draw(st.lists(st.lists(st.integers(0, 4), unique=True, max_size=3), min_size=1, max_size=2))
        added[query] = [(match, draw(OUTCOMES)) for part in parts for match in part]
        done = iter(added[query])
        for part in parts:
            record.add(query, part, [LoopDecision(query, *next(done)) for _ in part])
    return record, added


def of(record):
    """The record as plain data: candidates and decisions of each keyframe."""
    found = {query: [] for query, _ in record.candidates}
    for decision in record.decisions:
        found[decision.query].append((decision.match, decision.outcome))
    for query, candidates in record.candidates:
        assert [match for match, _ in found[query]] == list(candidates)
    return found


@given(recorded())
def test_a_record_holds_what_was_added(case):
    record, added = case
    assert of(record) == added and list(of(record)) == list(added)


@given(recorded())
def test_a_resumed_record_is_that_of_the_map(case):
    record, _ = case
    again = LoopRecord()
    again.resume(record.candidates, record.decisions)
    assert (again.candidates, again.decisions) == (record.candidates, record.decisions)


@given(recorded(), st.sets(st.integers(5, 40)))
def test_what_is_forgotten_is_gone_and_the_rest_stays(case, queries):
    record, added = case
    record.forget(queries)
    assert of(record) == {query: found for query, found in added.items() if query not in queries}


@given(recorded(), st.sets(st.tuples(st.integers(5, 40), st.integers(0, 4))))
def test_candidates_of_accepted_edges_are_accepted_and_others_stay(case, pairs):
    record, added = case
    record.accept([LoopEdge(query, match, np.eye(4), np.eye(6), 20) for query, match in pairs])
    assert of(record) == {
        query: [(match, "accepted" if (query, match) in pairs else outcome) for match, outcome in found]
        for query, found in added.items()
    }
