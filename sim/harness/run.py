"""One run: build the house, walk it, drift the odometry, feed LEXIS. What came out, beside what is true."""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64, Int

from lexis.encoder import Encoder, load_encoder
from lexis.slam import Slam
from lexis.types import LexisMap
from sim.harness.config import RunConfig
from sim.harness.walk import walk
from sim.session import Session
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
        """T_O_B of keyframes."""
        return np.asarray(self.session.odometry.T_O_B[self.observed])

    @property
    def true_rooms(self) -> Int[np.ndarray, "n"]:
        """Index into `house.rooms` of keyframes."""
        return np.array([self.session.truths[i].room for i in self.observed], int)

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

    `encoder` replaces the one that `config` names; `progress` is told the share of frames done. Raises `WorldsError`,
    `SimError` or `LexisError` where the config asks for what cannot be.
    """
    encoder = encoder or load_encoder(config.encoder)
    seconds: dict[str, float] = {}
    with _timed(seconds, "house_s"):
        walked = walk(config)
    with _timed(seconds, "scene_s"):
        session = Session(walked.house, walked.tour, walked.odometry, config.camera)
    slam = Slam(config.camera, encoder, walked.house.spec.room_labels, config.slam_config())
    for observation, _ in session:
        slam.process(observation)
        if progress is not None:
            progress((observation.index + 1) / len(session))
    lexis_map = slam.finish()
    seconds["render_s"] = session.render_seconds
    return Run(config, walked.house, walked.walkable, session, lexis_map, seconds)


@contextmanager
def _timed(seconds: dict[str, float], name: str) -> Iterator[None]:
    start = time.perf_counter()
    yield
    seconds[name] = time.perf_counter() - start
