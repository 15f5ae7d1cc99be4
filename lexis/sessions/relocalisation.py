"""Relocalisation: where a session lies in the rest of the map (beyond the paper).

Until a session is joined to another component of the map, nothing is known about their relative pose. For each keyframe:

1. Propose the most similar keyframes of the other components as loop candidates (`candidates_elsewhere`).
2. Verify them by PnP, at any distance (`at_any_distance`), because there is no estimate to compare them with. Uncertain
   loops are refused, because they may only confirm an estimate.
3. Each edge implies a relative pose of the components. Join them when edges of several keyframes imply the same one, and
   hardly any keyframe implies another one alone (`Relocaliser.agreed`). One keyframe is never trusted, because repeated
   objects look alike. Nor are many keyframes in one of two rooms that look alike, since each of them has edges to both.
"""

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np
from jaxtyping import Bool, Int

from lexis.config import SessionConfig, VerificationConfig
from lexis.graph.far_loops import shifts_of
from lexis.graph.pose_graph import PoseGraph
from lexis.maths.ties import reaches
from lexis.place_recognition import most_similar_keyframes
from lexis.types import Keyframe, LoopArrays, LoopDecision, LoopEdge, LoopOutcome
from lexis.verification import within_drift

_ANY_M, _ANY_RAD = 1e9, 4.0
"""Tolerances that admit every pose [m, rad]."""
_ALL = 1_000_000
"""A number of edges that no keyframe has."""
_TELLING = 3
"""Least number of keyframes that must have edges for one of two relative poses, and not for the other one, before the former
is believed. None of 139 sessions in three offices is joined in the wrong room, and 133 are joined within 10 m of walk
(`lexis-sim bench sessions --preset uh2-office --houses 3 --seed 300`). Without this condition, 4 are joined in the wrong
room; with 5 instead of 3, about 8 fewer are joined within 10 m."""


def candidates_elsewhere(query: Keyframe, graph: PoseGraph, config: SessionConfig) -> tuple[int, ...]:
    """Return the ids of the active keyframes most similar to the query among those of other components, best first."""
    components = graph.components
    elsewhere = graph.active[components[graph.active] != components[query.id]]
    elsewhere = elsewhere[elsewhere < query.id]
    return most_similar_keyframes(query, elsewhere, graph, config.candidates)


def at_any_distance(config: VerificationConfig) -> VerificationConfig:
    """Return settings with which sure loops are verified at any distance from the current estimate.

    Uncertain loops are refused, as are those with inliers in fewer than `min_cells` cells. A keyframe may have any number of
    loops, and they may contradict each other, because `Relocaliser` compares the loops of several keyframes itself.
    """
    limits = replace(config, gate_m=_ANY_M, gate_rad=_ANY_RAD, uncertain_gate_m=0.0)
    return replace(limits, max_contradiction=None, max_edges=_ALL)


class Relocaliser:
    """Collects loop edges between components, and returns edges that agree as soon as there are enough of them."""

    def __init__(self, config: SessionConfig, tolerances: VerificationConfig) -> None:
        """Begin without edges. `tolerances` has the limits of `lexis.verification.within_drift` within which edges agree."""
        self._config, self._tolerances = config, tolerances
        self._edges: list[LoopEdge] = []

    def agreed(self, edges: Sequence[LoopEdge], graph: PoseGraph) -> tuple[LoopEdge, ...]:
        """Add the edges of a new keyframe, and return the edges that agree with one of them; none if there are too few.

        Edges count as long as the path from their query to the new keyframe is at most `window_m` long, because odometry
        drifts. The edges that agree must come from at least `agreeing` keyframes, which span at least `span_m` of the path.
        These must be more than half of all keyframes with edges between the same two components. If the edges of several
        keyframes agree on another relative pose, the keyframes that only have edges for the former must be at least
        `_TELLING`, and at least twice as many as those that only have edges for the latter.
        """
        self._edges = [edge for edge in (*self._edges, *edges) if self._is_recent(edge, graph)]
        components = graph.components
        for edge in edges:
            known = [other for other in self._edges if _ends(other, components) == _ends(edge, components)]
            found, rivals = self._divided(edge, known, graph)
            if self._suffice(found, graph) and self._prevail(found, rivals, graph):
                return tuple(found)
        return ()

    def _is_recent(self, edge: LoopEdge, graph: PoseGraph) -> bool:
        """Whether the query of an edge is in the current session and on the last part of the path."""
        path_m = graph.path_between(edge.query, len(graph.keyframes) - 1)
        return edge.query >= graph.session_start and path_m <= self._config.window_m

    def _suffice(self, found: Sequence[LoopEdge], graph: PoseGraph) -> bool:
        """Whether edges that agree come from enough keyframes, on a piece of the path that is long enough."""
        queries = queries_of(found)
        long_enough = reaches(graph.path_between(min(queries), max(queries)), self._config.span_m)
        return len(queries) >= self._config.agreeing and bool(long_enough)

    def _prevail(self, found: Sequence[LoopEdge], rivals: Sequence[LoopEdge], graph: PoseGraph) -> bool:
        """Whether the keyframes with edges that agree outweigh those with `rivals`, the edges that contradict them."""
        ours = queries_of(found)
        if len(ours) <= len(queries_of(rivals) - ours):
            return False
        left = list(rivals)
        while left:
            agreeing, left = self._divided(left[0], left, graph)
            theirs = queries_of(agreeing)
            if len(theirs) > 1 and len(ours - theirs) < max(_TELLING, 2 * len(theirs - ours)):
                return False
        return True

    def _divided(self, edge: LoopEdge, edges: Sequence[LoopEdge], graph: PoseGraph) -> tuple[list[LoopEdge], list[LoopEdge]]:
        """Divide edges into those that imply the same relative pose of the components as `edge`, and the others."""
        fits = agree(edge, edges, graph, self._tolerances)
        same, others = ([edges[i] for i in np.flatnonzero(chosen).tolist()] for chosen in (fits, ~fits))
        return same, others


def without_support(decisions: Sequence[LoopDecision]) -> list[LoopDecision]:
    """Return the decisions on candidates in other components, as long as their edges join nothing.

    They say "unsupported" instead of "accepted", and have no misfits, because no estimate relates the components.
    """
    outcomes: dict[LoopOutcome, LoopOutcome] = {"accepted": "unsupported"}
    return [
        replace(decision, outcome=outcomes.get(decision.outcome, decision.outcome), misfit_m=None, misfit_rad=None)
        for decision in decisions
    ]


def queries_of(edges: Iterable[LoopEdge]) -> set[int]:
    """Return the ids of the later keyframes of some edges."""
    return {edge.query for edge in edges}


def _ends(edge: LoopEdge, components: Int[np.ndarray, "n"]) -> tuple[int, int]:
    """Return the components that an edge connects, given the component of every keyframe."""
    return int(components[edge.query]), int(components[edge.match])


def agree(
    edge: LoopEdge, others: Sequence[LoopEdge], graph: PoseGraph, config: VerificationConfig
) -> Bool[np.ndarray, "others"]:
    """Whether other edges shift their queries as `edge` shifts its own, within the accuracy of odometry; see `shifts_of`.

    The limits are those for loops within a component. They grow with the path between the queries of the two edges, as drift
    does.
    """
    rows = LoopArrays.of(others)
    measured = graph.T_W_B[rows.match] @ rows.T_match_query
    predicted = shifts_of([edge], graph.T_W_B) @ graph.T_W_B[rows.query]
    path_m = np.abs(graph.path_m[rows.query] - graph.path_m[edge.query])
    itself = np.array([other is edge for other in others], bool)  # its rounding errors may exceed tolerances of 0
    return np.asarray(itself | within_drift(measured, predicted, path_m, config))
