"""`LoopRecord`: what LEXIS has proposed and decided about loops, for each keyframe that sought some.

The record ends up in the map (`LexisMap.candidates` and `LexisMap.decisions`). It says why a loop is missing; no later stage
depends on it.
"""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from itertools import chain, groupby

from lexis.types import LoopDecision, LoopEdge


class LoopRecord:
    """The loop candidates of each keyframe, and the decisions on them, in the order of the keyframes."""

    def __init__(self) -> None:
        """Begin an empty record."""
        self._candidates: dict[int, tuple[int, ...]] = {}
        self._decisions: dict[int, tuple[LoopDecision, ...]] = {}

    @property
    def candidates(self) -> tuple[tuple[int, tuple[int, ...]], ...]:
        """Pairs of a keyframe's id and the ids of its candidates, as in `LexisMap.candidates`."""
        return tuple(self._candidates.items())

    @property
    def decisions(self) -> tuple[LoopDecision, ...]:
        """What became of the candidates, as in `LexisMap.decisions`."""
        return tuple(chain.from_iterable(self._decisions.values()))

    def resume(self, candidates: Iterable[tuple[int, tuple[int, ...]]], decisions: Iterable[LoopDecision]) -> None:
        """Fill an empty record with the candidates and decisions of an earlier map."""
        self._candidates = dict(candidates)
        for query, own in groupby(decisions, key=lambda decision: decision.query):
            self._decisions[query] = (*self._decisions.get(query, ()), *own)

    def add(self, query: int, candidates: Sequence[int], decisions: Sequence[LoopDecision]) -> None:
        """Add candidates of the keyframe `query`, and decisions on them, to those that it may already have."""
        self._candidates[query] = (*self._candidates.get(query, ()), *candidates)
        if decisions:
            self._decisions[query] = (*self._decisions.get(query, ()), *decisions)

    def accept(self, edges: Sequence[LoopEdge]) -> None:
        """Change the decisions on the candidates of these edges to "accepted", if there are any."""
        for query in {edge.query for edge in edges} & self._decisions.keys():
            own = [edge for edge in edges if edge.query == query]
            self._decisions[query] = accepted(self._decisions[query], own)

    def forget(self, queries: Iterable[int]) -> None:
        """Drop the candidates of these keyframes, and the decisions on them."""
        for query in queries:
            self._candidates.pop(query, None)
            self._decisions.pop(query, None)


def accepted(decisions: Sequence[LoopDecision], edges: Sequence[LoopEdge]) -> tuple[LoopDecision, ...]:
    """Return decisions in which the candidates of these edges are accepted, whatever was decided before."""
    joining = {(edge.query, edge.match) for edge in edges}
    return tuple(
        replace(decision, outcome="accepted") if (decision.query, decision.match) in joining else decision
        for decision in decisions
    )
