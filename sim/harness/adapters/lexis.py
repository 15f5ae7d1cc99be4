"""The adapter that runs LEXIS as the SLAM under test."""

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from pathlib import Path

import numpy as np

from lexis.config import Config
from lexis.errors import LexisError
from lexis.map.folder import save_map
from lexis.perception import Encoder
from lexis.place_recognition import PlaceRecogniser, propose
from lexis.planning import PathPlanner
from lexis.semantics import Labeller
from lexis.settings import changed_settings
from lexis.slam import Slam
from lexis.types import Camera, LexisMap, LoopArrays, LoopDecision, Observation
from lexis.verification import Verifier, verify
from sim.feature_sensor.oracle import Oracle
from sim.fidelity import ORACLE
from sim.harness.adapters.closure_log import ClosureLog
from sim.harness.estimate import CandidateDecision, Estimate, EstimatedLoops
from sim.harness.feature_input import FeatureInput


class Lexis:
    """Runs `lexis.slam.Slam` for the harness, and keeps the finished map."""

    def __init__(
        self,
        encoder: str | Encoder = "mini",
        config: Config | None = None,
        loops: bool = True,
        refine: bool = True,
        *,
        place_recogniser: PlaceRecogniser = propose,
        verifier: Verifier | None = None,
        labeller: Labeller | None = None,
    ) -> None:
        """Prepare a run. An encoder that is given by name is loaded once, when it is first needed.

        Each of the last three arguments replaces a stage of `Slam`. Without a `verifier`, PnP verifies loops in runs on
        images, and the feature sensor verifies them in runs on percepts.
        """
        self._encoder, self.config = encoder, _switched(config or Config(), loops, refine)
        self._place_recogniser, self._verifier, self._labeller = place_recogniser, verifier, labeller
        self._slam: Slam | None = None
        self._log: ClosureLog | None = None
        self._map: LexisMap | None = None
        self._planner: PathPlanner | None = None

    @property
    def encoder(self) -> Encoder:
        """The vision-language model. The first access may load it, which takes seconds."""
        if isinstance(self._encoder, str):
            self._encoder = load(self._encoder)
        return self._encoder

    @property
    def settings(self) -> str:
        """The settings of LEXIS that differ from their defaults."""
        return ", ".join(changed_settings(self.config))

    def with_stages(
        self,
        encoder: str | Encoder | None = None,
        place_recogniser: PlaceRecogniser | None = None,
        verifier: Verifier | None = None,
        labeller: Labeller | None = None,
    ) -> "Lexis":
        """Return a LEXIS with the same settings that has not run yet; the arguments replace its encoder or stages."""
        return Lexis(
            encoder or self._encoder,
            self.config,
            place_recogniser=place_recogniser or self._place_recogniser,
            verifier=verifier or self._verifier,
            labeller=labeller or self._labeller,
        )

    @property
    def map(self) -> LexisMap:
        """The map of the latest run. Raises LexisError until this run is finished."""
        if self._map is None:
            raise LexisError("LEXIS has no map yet; valid: after finish()")
        return self._map

    def start(self, camera: Camera, room_names: Sequence[str]) -> None:
        """Begin a run on images."""
        self._start(camera, room_names, verify)

    def start_on_features(self, camera: Camera, room_names: Sequence[str], features: FeatureInput) -> None:
        """Begin a run on percepts of the feature sensor. Raises `SimError` if the percepts simulate another encoder."""
        features.check(self.encoder)
        self._start(camera, room_names, features.verifier)

    def _start(self, camera: Camera, room_names: Sequence[str], verifier: Verifier) -> None:
        self._map = self._planner = None
        self._log = ClosureLog(self._place_recogniser, self._verifier or verifier)
        stages = self._log.verify, self._log.propose, self._labeller
        self._slam = Slam(camera, self.encoder, room_names, self.config, *stages)

    def process(self, observation: Observation) -> None:
        """Add the next observation to the map."""
        self._running.process(observation)

    def has_keyframes_of(self, other: "Lexis") -> bool:
        """Whether this LEXIS makes the same keyframes as `other` of any walk. Only later stages may then differ."""
        mine, others = ((each.config.keyframes, each.config.landmarks) for each in (self, other))
        return mine == others and self.encoder.fingerprint == other.encoder.fingerprint

    def replay(self, map: LexisMap) -> None:
        """Add the keyframes of a map, in place of observations. This saves the encoding and the features of all images.

        The result is that of a run if no keyframe of `map` has retired (`pose_graph.copies` is None). Keyframes that have
        retired stay retired, and the loops that they sought are missing from the estimate.
        """
        self._running.replay(map)

    def finish(self) -> Estimate:
        """Complete the map, and return its contents as the estimate that the harness compares with the truth.

        The estimate also contains the loops, candidates and decisions that retired keyframes have given up.
        """
        self._map = self._running.finish()
        assert self._log is not None
        return estimate_of(self._log.completed(self._map, self.config.pose_graph))

    @property
    def _running(self) -> Slam:
        if self._slam is None:
            raise LexisError("LEXIS was not started; valid: start() first")
        return self._slam

    def plan(self, start: str, goal: str) -> Sequence[int]:
        """Return the indices of the keyframes on the shortest path from a room labelled `start` to one labelled `goal`."""
        if self._planner is None:
            self._planner = PathPlanner(self.map, self.config.planner)
        return self._planner.plan(start, goal).keyframes

    def save(self, folder: Path) -> None:
        """Write the map to the subfolder `map` of `folder`."""
        save_map(self.map, folder / "map")


def estimate_of(map: LexisMap) -> Estimate:
    """Convert a LEXIS map to an estimate, with one row for each keyframe."""
    loops = LoopArrays.of(map.loops)
    return Estimate(
        frames=np.array([keyframe.observation_index for keyframe in map.keyframes], int),
        T_W_B=map.T_W_B,
        labels=map.labels,
        baseline_labels=map.baseline_labels,
        rooms=map.room_of,
        floors=map.floors,
        loops=EstimatedLoops(loops.query, loops.match, loops.T_match_query, map.loop_weights),
        candidates=map.candidates,
        decisions=tuple(_decision(decision) for decision in map.decisions) or None,
        similarities=map.similarities,
        encoder=map.encoder.name,
        stage_seconds=map.stage_seconds,
    )


def _decision(decision: LoopDecision) -> CandidateDecision:
    figures = {
        "matches": decision.matches,
        "inliers": decision.inliers,
        "image cells": decision.cells,
        "misfit [m]": decision.misfit_m,
        "misfit [rad]": decision.misfit_rad,
    }
    known = {name: float(value) for name, value in figures.items() if value is not None}
    return CandidateDecision(decision.query, decision.match, decision.outcome == "accepted", decision.outcome, known)


@lru_cache(maxsize=1)
def load(name: str) -> Encoder:
    """Load an encoder by name; `ORACLE` names the error-free encoder for tests.

    The encoder that was loaded last is kept, because tests run many houses with one encoder. Encoders have no state.
    """
    if name == ORACLE:
        return Oracle()
    from lexis.encoder.open_clip_encoder import load_encoder  # torch takes seconds, and the oracle does without

    return load_encoder(name)


def _switched(config: Config, loops: bool, refine: bool) -> Config:
    """Return the settings, without loop closure if not `loops`, and without label refinement if not `refine`."""
    if not loops:
        config = replace(config, place_recognition=replace(config.place_recognition, candidates=0))
    if not refine:
        config = replace(config, labels=replace(config.labels, method="image"))
    return config
