"""`plan_tour`: plans a walk without collisions through a house and back to the start.

1. Plan the nodes to visit, by the kind of tour (`itinerary`).
2. Connect the nodes by paths, and smooth the whole path (`smooth`). If a length is requested, compare it with the length of
   the smooth path, plan a longer or shorter tour, and repeat.
3. Choose the direction of view along the path (`view`).
4. Time the path within the limits of speed and acceleration (`pace`), and add sway.
"""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float64

from lexis.maths.paths import arc_length
from sim.errors import SimError
from sim.tours.config import TourConfig, TourKind
from sim.tours.itinerary import SMOOTHED, Planner
from sim.tours.motion import Motion
from sim.tours.pace import paced
from sim.tours.smooth import smooth_path
from sim.tours.start import with_start_manoeuvre
from sim.tours.sway import draw_sway
from sim.tours.view import view_along
from worlds.free_space import BODY_HIGH_M
from worlds.house import House
from worlds.walkable import Walkable

_RANDOM_M = 100.0
"""Length of a random tour if none is requested [m]."""
_EVERY_ROOM: frozenset[TourKind] = frozenset({"rooms", "both ways", "lawn-mower"})
"""Kinds of tours that visit every room."""
_LENGTH_TOLERANCE = (3.0, 0.03)
"""Tolerance of a requested length, in metres and as a share of the length. The larger tolerance applies."""
_SHORTEST_M = 1.0
"""A length that no tour can have [m]. If it is requested, the planner makes the shortest possible tour."""
_TRIES = 5
_GOOD_ENOUGH = 0.3
"""Deviation from the requested length that needs no further tries, as a share of the tolerance."""

__all__ = ["Tour", "TourConfig", "plan_tour"]


@dataclass(frozen=True, eq=False)
class Tour:
    """A walk through a house: the continuous motion, and the poses at the times of the frames."""

    stamps: Float64[np.ndarray, "n"]
    """Times of the frames [s]."""
    T_W_B: Float64[np.ndarray, "n 4 4"]
    """Poses of the body: x forward, z up, at eye height. They are level apart from sway and from pitch on stairs."""
    motion: Motion
    eye_height_m: float

    @property
    def distances_m(self) -> Float64[np.ndarray, "n"]:
        """Length of the path, without sway, up to each frame [m]."""
        return arc_length(replace(self.motion, sway=None).position(self.stamps))

    @property
    def length_m(self) -> float:
        """Length of the whole path, without sway [m]."""
        every = np.append(np.arange(0.0, self.motion.duration_s, 0.02), self.motion.duration_s)
        return float(arc_length(replace(self.motion, sway=None).position(every))[-1])

    def pose_at(self, t: float) -> Float64[np.ndarray, "4 4"]:
        """Return the exact body pose `T_W_B` at time `t` [s]; the first pose before the tour, and the last pose after it."""
        return np.squeeze(self.motion.poses_at(np.array([float(t)]), self.eye_height_m), axis=0)


def plan_tour(house: House, walkable: Walkable, rng: np.random.Generator, config: TourConfig | None = None) -> Tour:
    """Plan a tour that a body of the radius `walkable.radius_m` can walk without collision.

    Raises `SimError` if no tour is possible in the house, or no tour of the requested length, and for a camera above the
    height up to which paths are free.
    """
    config = config or TourConfig()
    if config.eye_height_m >= BODY_HIGH_M:
        given = f"tour: eye_height_m is {config.eye_height_m:g}"
        raise SimError(f"{given}; valid: below {BODY_HIGH_M:g}, the height up to which paths are free of obstacles")
    planner, sway_rng = Planner.of(house, walkable, config, rng), rng.spawn(1)[0]
    path = _path(planner, config)
    if config.reverse:
        path = path[::-1].copy()
    view = view_along(house, path, config.glance_rad, config.pitch_on_stairs)
    motion = paced(path, view, config.limits, draw_sway(config.sway, sway_rng))
    if config.start_manoeuvre:
        motion = with_start_manoeuvre(motion, config.limits)
    stamps = np.arange(0.0, motion.duration_s, 1.0 / config.frame_rate_hz)
    return Tour(stamps, motion.poses_at(stamps, config.eye_height_m), motion, config.eye_height_m)


def shortest_length(house: House, walkable: Walkable, rng: np.random.Generator, config: TourConfig) -> float:
    """Return the length of the shortest tour of the kind in `config` [m]. The length in `config` is ignored.

    Raises `SimError` if no tour is possible in the house.
    """
    return float(arc_length(_smooth(Planner.of(house, walkable, config, rng), _SHORTEST_M))[-1])


def _path(planner: Planner, config: TourConfig) -> Float64[np.ndarray, "k 3"]:
    """Return a smooth path of the requested length. Raises `SimError` if no such path is found.

    Smoothing changes the length of a path. The length that is asked of the planner is therefore corrected by the length of
    the previous smooth path, in a few tries.
    """
    wished = _RANDOM_M if config.length_m is None and config.kind == "random" else config.length_m
    if wished is None:
        return _smooth(planner, None)
    tolerance = max(_LENGTH_TOLERANCE[0], _LENGTH_TOLERANCE[1] * wished)
    share, best, least = SMOOTHED, None, np.inf
    for _ in range(_TRIES):
        path = _smooth(planner, wished / share)
        length = float(arc_length(path)[-1])
        if abs(length - wished) < abs(least - wished):
            best, least = path, length
        if best is not None and abs(least - wished) <= _GOOD_ENOUGH * tolerance:
            break
        share *= length / wished
    if best is None or abs(least - wished) > tolerance:
        bound = "at least" if least > wished else "at most"
        where = "that visits every room of" if config.kind in _EVERY_ROOM else "in"
        raise SimError(
            f"tour: length_m is {wished:g}; valid: {bound} {least:.0f} for a tour ({config.kind}) {where} "
            f"house {planner.house.spec.name!r}"
        )
    return best


def _smooth(planner: Planner, length_m: float | None) -> Float64[np.ndarray, "k 3"]:
    return smooth_path(planner.paths.line(planner.nodes(length_m)), planner.walkable)
