"""`lexis-sim bench sessions`: does a robot recognise a mapped house on another day, and does it notice a twin house?

The first day's walk gives a map. On the second day, with another tour, odometry and sensor noise, the robot starts at many
places of its tour. In its own house, it has to recognise where it is; in a twin house, it must not recognise anything.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float64

from lexis.maths.paths import arc_length
from lexis.maths.se3 import between
from lexis.slam import Slam
from lexis.types import Camera, LexisMap, Observation
from lexis.verification import Verifier
from sim.errors import SimError
from sim.feature_sensor.covisibility_verifier import CovisibilityVerifier
from sim.harness import Scenario, run
from sim.harness.adapters import Lexis
from sim.harness.feature_input import FeatureInput
from sim.harness.world_tests import FEATURES_FRAME_RATE_HZ
from worlds.presets import sample_house
from worlds.spec import HouseSpec

NEAR_M = 10.0
"""A session should be joined to the map of its house within this length of walk [m]."""
WRONG_M = 1.0
"""A session with a larger error of the position counts as joined at a wrong place [m]."""
_SECOND_DAY = 500_000
"""This number plus the seed of a house is the seed of the tour, the odometry and the sensor noise of the second day."""
_APART_M = 1000.0
"""Distance between twin houses in the world [m], so that no view in one house shows anything of the other house."""


@dataclass(frozen=True, eq=False)
class Day:
    """The walk of one day through a house, observed by the simulated feature sensor instead of by rendered images."""

    observations: tuple[Observation, ...]
    T_W_B: Float64[np.ndarray, "n 4 4"]
    """True poses of the body, by index of the observation."""
    camera: Camera
    room_names: tuple[str, ...]
    verifier: CovisibilityVerifier
    map: LexisMap
    """The map of this day alone."""


@dataclass(frozen=True)
class Start:
    """The result of a session that started at some observation of the second day."""

    joined_m: float | None
    """Length of the walk until the session was joined to the map [m]; None if it never was."""
    error_m: float | None
    """Error of the position of the last keyframe, relative to the nearest keyframe of the first day [m]; None if the session
    was never joined to the map."""


@dataclass(frozen=True)
class SessionsRow:
    """Figures of all sessions in one kind of house."""

    starts: int
    """Number of sessions."""
    joined: int
    """Number of sessions that were joined to the map."""
    near: int
    """Number of sessions that were joined to the map within `NEAR_M` of walk."""
    wrong: int
    """Number of sessions that were joined to the map at a wrong place; see `WRONG_M`."""
    median_m: float | None
    """Median length of the walk until a session was joined to the map [m]; None if none was."""
    largest_error_m: float | None
    """Largest error of the position in a session that was joined to the map [m]; None if none was."""


class _Recorder(Lexis):
    """LEXIS that also stores its observations, and the camera, room names and verifier that it was given."""

    def __init__(self) -> None:
        super().__init__()
        self.observations: list[Observation] = []
        self.given: tuple[Camera, tuple[str, ...], Verifier] | None = None

    def start_on_features(self, camera: Camera, room_names: Sequence[str], features: FeatureInput) -> None:
        self.given = camera, tuple(room_names), features.verifier
        super().start_on_features(camera, room_names, features)

    def process(self, observation: Observation) -> None:
        self.observations.append(observation)
        super().process(observation)


def walked_day(house: HouseSpec, seed: int) -> Day:
    """Walk through a house with the tour, the odometry and the sensor noise of a seed, and map it."""
    slam = _Recorder()
    scenario = Scenario(house=house, seed=seed, fidelity="features", frame_rate_hz=FEATURES_FRAME_RATE_HZ)
    finished = run(scenario, slam)
    assert slam.given is not None
    camera, names, verifier = slam.given
    if not isinstance(verifier, CovisibilityVerifier):
        raise SimError("bench sessions: the run has no simulated verifier; valid: runs on features")
    return Day(tuple(slam.observations), finished.session.tour.T_W_B, camera, names, verifier, slam.map)


def return_to(first: Day, second: Day, start: int, length_m: float, twin: bool = False) -> tuple[LexisMap, Start]:
    """Continue the map of the first day by a session that starts at observation `start` of the second day.

    The session ends after about `length_m` of walk. If `twin`, its house is the twin house. Returns the continued map and
    the result of the session.
    """
    count = len(first.T_W_B)
    verifier = first.verifier.followed_by(second.verifier, count, _APART_M if twin else 0.0)
    slam = Slam(second.camera, Lexis().encoder, second.room_names, verifier=verifier, map=first.map)
    walked_m, joined_m = 0.0, None
    previous = second.observations[start]
    for observation in second.observations[start:]:
        slam.process(replace(observation, index=count + observation.index))
        walked_m += float(np.linalg.norm(observation.T_O_B[:3, 3] - previous.T_O_B[:3, 3]))
        previous = observation
        if joined_m is None and not slam.is_split and slam.keyframe_count > len(first.map.keyframes):
            joined_m = walked_m
        if walked_m > length_m:
            break
    found = slam.finish()
    return found, Start(joined_m, None if joined_m is None else _error_m(found, first, second))


def _error_m(found: LexisMap, first: Day, second: Day) -> float:
    """Return the error of the position of the last keyframe, relative to the nearest keyframe of the first day [m]."""
    count, last = len(first.T_W_B), found.keyframes[-1].observation_index
    old = [k.id for k in found.keyframes if k.observation_index < count]
    true_old = first.T_W_B[[found.keyframes[i].observation_index for i in old]]
    true = second.T_W_B[last - count]
    nearest = int(np.linalg.norm(true_old[:, :3, 3] - true[:3, 3], axis=1).argmin())
    estimated = between(found.T_W_B[old[nearest]], found.T_W_B[-1])
    return float(np.linalg.norm(estimated[:3, 3] - between(true_old[nearest], true)[:3, 3]))


def starts(day: Day, every_m: float, length_m: float) -> list[int]:
    """Return indices of observations along a day's walk, `every_m` apart, each followed by `length_m` of walk.

    The result is empty if the walk is shorter than `length_m`. Lengths are right up to the distance between observations.
    """
    path_m = arc_length(np.array([seen.T_O_B[:3, 3] for seen in day.observations]))
    places = np.arange(0.0, path_m[-1] - length_m, every_m)
    return [int(row) for row in np.searchsorted(path_m, places)]


def measure_sessions(
    preset: str, seeds: Sequence[int], every_m: float = 10.0, length_m: float = 15.0
) -> Iterator[tuple[int, bool, list[Start]]]:
    """Yield, twice for every house, its seed, whether the second day is in the twin house, and the results of the sessions.

    To the encoder, the twin house looks exactly like the house of the first day. The verifier confirms loops between the two
    houses only as often as other false loops.
    """
    for seed in seeds:
        house = sample_house(preset, seed)
        first, second = walked_day(house, seed), walked_day(house, seed + _SECOND_DAY)
        for twin in (False, True):
            yield seed, twin, [return_to(first, second, at, length_m, twin)[1] for at in starts(second, every_m, length_m)]


def summary(measured: Iterable[tuple[int, bool, Sequence[Start]]]) -> dict[str, SessionsRow]:
    """Return the figures of the sessions in the same house and in twin houses, by the name of the house."""
    by_house: dict[bool, list[Start]] = {False: [], True: []}
    for _, twin, found in measured:
        by_house[twin] += found
    return {name: _row(by_house[twin]) for twin, name in ((False, "the same"), (True, "a twin"))}


def _row(found: Sequence[Start]) -> SessionsRow:
    walks = [start.joined_m for start in found if start.joined_m is not None]
    errors = [start.error_m for start in found if start.error_m is not None]
    return SessionsRow(
        starts=len(found),
        joined=len(walks),
        near=sum(walk <= NEAR_M for walk in walks),
        wrong=sum(error > WRONG_M for error in errors),
        median_m=float(np.median(walks)) if walks else None,
        largest_error_m=max(errors, default=None),
    )
