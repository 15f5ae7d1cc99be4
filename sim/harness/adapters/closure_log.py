"""`ClosureLog`: all that LEXIS found out about loop closures during a run, including what its map no longer contains."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from lexis.config import PlaceRecognitionConfig, PoseGraphConfig, VerificationConfig
from lexis.graph.graph_optimisation import loop_weights
from lexis.graph.pose_estimate import PoseEstimate
from lexis.graph.pose_graph import PoseGraph
from lexis.place_recognition import PlaceRecogniser
from lexis.types import Camera, Keyframe, LexisMap, LoopDecision, LoopEdge, RoomInstance
from lexis.verification import Verification, Verifier


class ClosureLog:
    """Records the results of two stages of LEXIS: place recognition and verification.

    A keyframe that retires from the pose graph gives up its loop edges, candidates and decisions, which keeps the map small
    (see `lexis.graph.thinning`). The harness judges all that LEXIS did, at every keyframe, and needs this record for it.
    """

    def __init__(self, place_recogniser: PlaceRecogniser, verifier: Verifier) -> None:
        """Begin an empty record of these two stages."""
        self._propose, self._verify = place_recogniser, verifier
        self._candidates: list[tuple[int, tuple[int, ...]]] = []
        self._edges: list[LoopEdge] = []
        self._decisions: list[LoopDecision] = []

    def propose(
        self, query: Keyframe, label: str, rooms: Sequence[RoomInstance], graph: PoseGraph, config: PlaceRecognitionConfig
    ) -> tuple[int, ...]:
        """Propose loop candidates as the recorded stage does; see `lexis.place_recognition.propose`."""
        candidates = self._propose(query, label, rooms, graph, config)
        self._candidates.append((query.id, candidates))
        return candidates

    def verify(
        self, query: Keyframe, candidates: Sequence[int], graph: PoseEstimate, camera: Camera, config: VerificationConfig
    ) -> Verification:
        """Verify loop candidates as the recorded stage does; see `lexis.verification.verify`.

        Nothing is recorded while the graph has several components, because LEXIS then also verifies candidates to which it
        does not close loops. The harness runs single sessions only, whose graph is never split.
        """
        verified = self._verify(query, candidates, graph, camera, config)
        if not graph.is_split:
            self._edges += verified.edges
            self._decisions += verified.decisions
        return verified

    def completed(self, map: LexisMap, config: PoseGraphConfig) -> LexisMap:
        """Return the map together with what its retired keyframes have given up, in the order of the keyframes.

        The map has no weights of loops that were given up; these weights follow from the final poses.
        """
        retired = {keyframe.id for keyframe in map.keyframes if keyframe.anchor is not None}
        if not retired:
            return map
        kept = {(loop.query, loop.match) for loop in map.loops}
        given_up = [edge for edge in self._edges if edge.query in retired and (edge.query, edge.match) not in kept]
        loops = [*map.loops, *given_up]
        weights = np.append(map.loop_weights, loop_weights(map.T_W_B, given_up, config))
        order = np.argsort([loop.query for loop in loops], kind="stable")
        candidates = (*map.candidates, *(found for found in self._candidates if found[0] in retired))
        decisions = (*map.decisions, *(decision for decision in self._decisions if decision.query in retired))
        return replace(
            map,
            loops=tuple(loops[k] for k in order),
            loop_weights=weights[order],
            candidates=tuple(sorted(candidates, key=lambda found: found[0])),
            decisions=tuple(sorted(decisions, key=lambda decision: decision.query)),
        )
