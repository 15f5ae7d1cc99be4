"""`FeatureInput`: what the harness gives to a SLAM in a run of fidelity "features", in place of images."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from lexis.config import VerificationConfig
from lexis.perception import Encoder
from lexis.types import NO_FEATURES, NO_LANDMARKS, Camera, Keyframe, LoopEdge, Poses
from lexis.verification import Verifier
from sim.errors import SimError
from sim.feature_sensor.covisibility_verifier import CovisibilityVerifier
from sim.feature_sensor.model import FeatureModel
from sim.feature_sensor.oracle import Oracle

_NO_GATES = VerificationConfig(gate_m=1e9, gate_rad=4.0, uncertain_gate_m=1e9, max_edges=10**9)
"""Settings with which a verifier compares no loop with an estimate of the poses."""

_BLANK = Keyframe(0, 0, 0.0, np.eye(4), np.eye(6), np.zeros(1, np.float32), NO_FEATURES, NO_LANDMARKS)
"""A keyframe without content."""


@dataclass(frozen=True, eq=False)
class FeatureInput:
    """What the harness gives to a SLAM in a run of fidelity "features": the feature model and a loop verifier.

    A run of this fidelity has no images, so the SLAM can neither encode images nor compare them to verify loops.
    """

    model: FeatureModel
    source: str
    """File or package that the model was read from, for error messages."""
    oracle: bool
    """Whether the embeddings are the oracle's, which contain the truth, instead of imitating the encoder of `model`."""
    verifier: Verifier
    """Verifier of the loop closures of LEXIS's pose graph. `verify` asks it about observations, without a pose graph."""
    camera: Camera
    is_delivered: Callable[[int], bool]
    """Tells by its index whether the SLAM has got an observation, so that `verify` says nothing about later ones."""
    original: Callable[[int], int] = int
    """Maps an index of an observation that the SLAM gets to the index in the run. They are equal unless a law changes the
    observations, such as by giving every frame twice."""

    def verify(self, query: int, matches: Sequence[int]) -> tuple[LoopEdge, ...]:
        """Return the loop closures that a comparison of images would give between an observation and earlier ones.

        Some true loops are missing, and some of those returned are false, as with real images. A SLAM has to recognise
        false ones by its own estimate of the poses. Equal questions have equal answers in all runs of a scenario.

        Args:
            query: index of an observation.
            matches: indices of the observations with which it is compared.

        Returns:
            Edges whose `query` and `match` are indices of observations.

        Raises `SimError` for an index of an observation that the SLAM has not got, and for a match that is the query itself.
        """
        if query in matches or not all(index >= 0 and self.is_delivered(index) for index in (query, *matches)):
            raise SimError(
                f"verify: observation {query} is to be compared with {list(matches)!r:.60}; valid: indices of different "
                "observations that were delivered"
            )
        asked = {self.original(match): match for match in matches}
        graph = _Unestimated({**asked, self.original(query): query})
        edges = self.verifier(graph.keyframes[self.original(query)], list(asked), graph, self.camera, _NO_GATES).edges
        return tuple(
            replace(edge, query=query, match=match)
            for edge in edges
            for match in matches
            if self.original(match) == edge.match
        )

    def renumbered(self, original: Callable[[int], int], is_delivered: Callable[[int], bool]) -> "FeatureInput":
        """Return this input for a SLAM that gets observations under other indices.

        `original` maps an index that the SLAM gets to the index in the run, and `is_delivered` is told such an index.
        """
        if not isinstance(self.verifier, CovisibilityVerifier):
            raise SimError("feature input: its verifier cannot be renumbered; valid: the verifier of the feature sensor")
        return replace(self, verifier=self.verifier.renumbered(original), is_delivered=is_delivered, original=original)

    def check(self, encoder: Encoder) -> None:
        """Raise `SimError` unless the embeddings of the run simulate `encoder`."""
        if self.oracle != isinstance(encoder, Oracle):
            raise SimError(f"encoder {encoder.name!r} does not fit the run; valid: the encoder that the scenario names")
        if not self.oracle:
            self.model.check(encoder, self.source)


class _Unestimated:
    """A `PoseEstimate` without an estimate: all poses are equal. Its keyframes are observations without content.

    The id of a keyframe is the index of its observation in the run, so that a verifier that draws random numbers for ids
    draws the same ones however a SLAM numbers the observations.
    """

    is_split = False

    def __init__(self, given: Mapping[int, int]) -> None:
        """`given` maps the index in the run of each observation that is compared to the index that the SLAM gets."""
        count = max(given) + 1
        self.keyframes = [_BLANK] * count
        for id, index in given.items():
            self.keyframes[id] = replace(_BLANK, id=id, observation_index=index, stamp=float(id))
        self.T_W_B: Poses = np.broadcast_to(np.eye(4), (count, 4, 4))
        self.sessions = np.zeros(count, np.int64)

    def path_between(self, first: int, second: int) -> float:
        """Return an unknown length."""
        return math.inf
