"""One run: build the house, walk it, drift the odometry, feed LEXIS. What came out, beside what is true."""

import time
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64, Int

from lexis.errors import ObservationError
from lexis.perception import Encoder
from lexis.slam import Slam
from lexis.types import LexisMap
from sim.feature_sensor.model import MINI_FEATURES, load_features
from sim.feature_sensor.oracle import Oracle
from sim.feature_sensor.sensor import FeatureSensor
from sim.fidelity import ORACLE
from sim.harness.config import RunConfig
from sim.harness.parts import slam_config
from sim.harness.walk import walk
from sim.session import Session
from sim.truth import Truth
from worlds.house import House
from worlds.walkable import Walkable


@dataclass(frozen=True, eq=False)
class Run:
    """A finished run. Arrays "of keyframes" are indexed by keyframe id."""

    config: RunConfig
    house: House
    walkable: Walkable
    session: Session
    map: LexisMap
    seconds: dict[str, float]
    """Wall time of house and tour, of building the scene, and of rendering [s]."""
    delivered: tuple[Truth, ...]
    """What was true of every observation, in the order in which LEXIS was given them."""
    refused: tuple[str, ...] = ()
    """Why LEXIS did not take some of them; only under faults."""

    @property
    def observed(self) -> Int[np.ndarray, "n"]:
        """Index of the observation that became each keyframe."""
        return np.array([keyframe.observation_index for keyframe in self.map.keyframes], int)

    @property
    def stamps(self) -> Float64[np.ndarray, "n"]:
        """Of keyframes [s]."""
        return np.array([keyframe.stamp for keyframe in self.map.keyframes])

    @property
    def true_poses(self) -> Float64[np.ndarray, "n 4 4"]:
        """T_W_B of keyframes."""
        return np.asarray(self.session.tour.T_W_B[self.observed])

    @property
    def odometry_poses(self) -> Float64[np.ndarray, "n 4 4"]:
        """T_O_B of keyframes, as LEXIS was given them."""
        return np.array([keyframe.T_O_B for keyframe in self.map.keyframes])

    @property
    def true_rooms(self) -> Int[np.ndarray, "n"]:
        """Index into `house.rooms` of keyframes."""
        return np.array([self.session.truths[i].room for i in self.observed], int)

    @property
    def walked_rooms(self) -> tuple[int, ...]:
        """Indices into `house.rooms` of the rooms that the walk went through, in that order."""
        return tuple(dict.fromkeys(truth.room for truth in self.session.truths))

    @property
    def unseen_rooms(self) -> tuple[str, ...]:
        """Ids of the rooms that the walk went through without a keyframe, in that order."""
        seen = set(self.true_rooms.tolist())
        return tuple(self.house.rooms[room].id for room in self.walked_rooms if room not in seen)

    @property
    def true_labels(self) -> Int[np.ndarray, "n"]:
        """Index into the map's room names of keyframes."""
        return np.array([self.map.room_names.index(self.session.truths[i].label) for i in self.observed], int)

    @property
    def true_storeys(self) -> Int[np.ndarray, "n"]:
        """Storey of keyframes."""
        return np.array([self.session.truths[i].storey for i in self.observed], int)


def run(config: RunConfig, encoder: Encoder | None = None, progress: Callable[[float], None] | None = None) -> Run:
    """Run LEXIS on the simulated house that `config` describes.

    `encoder` replaces the one that `config` names; `progress` is told the share of frames done. Under faults, observations
    that LEXIS refuses are left out, as a driver would that logs the error and goes on. Raises `WorldsError`,
    `SimError` or `LexisError` where the config asks for what cannot be.
    """
    encoder = encoder or _encoder(config.encoder)
    sensor = _sensor(config, encoder)
    seconds: dict[str, float] = {}
    with _timed(seconds, "house_s"):
        walked = walk(config)
    with _timed(seconds, "scene_s"):
        session = Session(walked.house, walked.tour, walked.odometry, config.rig.front, config.faults, config.seed, sensor)
    slam = Slam(config.rig.front, encoder, walked.house.spec.room_labels, slam_config(config), session.verifier())
    delivered, refused = [], []
    with closing(iter(session)) as pairs:
        for observation, truth in pairs:
            delivered.append(truth)
            try:
                slam.process(observation)
            except ObservationError as error:
                if not config.faults:
                    raise
                refused.append(str(error))
            if progress is not None:
                progress((observation.index + 1) / len(session))
    lexis_map = slam.finish()
    seconds["render_s"] = session.render_seconds
    return Run(config, walked.house, walked.walkable, session, lexis_map, seconds, tuple(delivered), tuple(refused))


def _encoder(name: str) -> Encoder:
    if name == ORACLE:
        return Oracle()
    from lexis.encoder.open_clip_encoder import load_encoder  # torch takes seconds, and the oracle does without

    return load_encoder(name)


def _sensor(config: RunConfig, encoder: Encoder) -> FeatureSensor | None:
    """What takes the place of images; None where there are images."""
    if config.fidelity == "render":
        return None
    source = config.feature_model or MINI_FEATURES
    model = load_features(source)
    oracle = isinstance(encoder, Oracle)
    if not oracle:
        model.check(encoder, str(source))
    return FeatureSensor(model, config.rig.front, config.seed, oracle)


@contextmanager
def _timed(seconds: dict[str, float], name: str) -> Iterator[None]:
    start = time.perf_counter()
    yield
    seconds[name] = time.perf_counter() - start
