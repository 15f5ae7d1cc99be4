"""Chooses viewpoints of training frames along tours, in pairs of similar views, so that place recognition is learned."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64, Int

from lexis.maths.paths import arc_length
from lexis.types import Pose
from sim.errors import SimError
from sim.tours.tour import Tour, TourConfig, plan_tour
from worlds.house import House
from worlds.walkable import Walkable

IMAGE_SIZE = (160, 128)
"""Width and height of the encoder's input images [px]."""

_YAW, _PITCH, _ROLL, _HEIGHT = 0.35, 0.05, 0.02, 0.06
"""Standard deviations of yaw, pitch and roll from the tour's level view along the path [rad], and of height [m]."""
_ALL_ROUND_SHARE = 0.15
"""Share of pairs of views whose yaw is drawn uniformly from all directions, instead of around the path's direction."""
_SECOND_M, _SECOND_YAW = (0.1, 0.9), 0.2
"""Range of the distance between the two frames of a pair along the path [m], and standard deviation of the difference of
their yaws relative to the path [rad]."""


@dataclass(frozen=True)
class ViewpointConfig:
    """Number, spacing and image size of the frames that are rendered in a house."""

    size: tuple[int, int] = IMAGE_SIZE
    """Width and height of the images of the frames [px]."""
    rendered: tuple[int, int] = (480, 360)
    """Width and height at which images are rendered [px], before they are scaled to `size`. Default: LEXIS's image size."""
    spacing_m: float = 2.0
    """Distance between pairs of frames along the tour [m]."""
    most: int = 110
    """Largest number of frames of a house."""


TRAINING_VIEWS = ViewpointConfig()
LEXIS_VIEWS = ViewpointConfig(size=(480, 360))
"""Settings for frames in the size of LEXIS's images."""


def evenly_along(positions: Float64[np.ndarray, "n 3"], spacing_m: float, most: int) -> Int[np.ndarray, "k"]:
    """Return indices of points `spacing_m` apart along a path, or farther apart, so that there are at most `most` points."""
    path = arc_length(positions)
    spacing_m = max(spacing_m, path[-1] / most)
    return np.unique(np.searchsorted(path, np.arange(0.0, path[-1], spacing_m)))


def poses_along_tour(house: House, views: ViewpointConfig, rng: np.random.Generator) -> Float64[np.ndarray, "n 4 4"]:
    """Return poses `T_W_B` along a tour. Poses 2k and 2k + 1 are a pair of nearby, similar views.

    There are no poses if no tour is found.
    """
    try:
        tour = plan_tour(house, Walkable(house), rng, TourConfig())
    except SimError:
        return np.zeros((0, 4, 4))
    way = arc_length(tour.T_W_B[:, :3, 3])
    stops = np.arange(0.0, way[-1], views.spacing_m)
    if len(stops) > views.most // 2:
        stops = np.sort(rng.choice(stops, views.most // 2, replace=False))
    return np.array([pose for at in stops for pose in _pair(tour, way, float(at), rng)]).reshape(-1, 4, 4)


def _pair(tour: Tour, way: Float64[np.ndarray, "n"], at: float, rng: np.random.Generator) -> tuple[Pose, Pose]:
    yaw = rng.uniform(-np.pi, np.pi) if rng.random() < _ALL_ROUND_SHARE else rng.normal(0.0, _YAW)
    first, second = np.searchsorted(way, (at, min(at + rng.uniform(*_SECOND_M), way[-1])))
    return _glance(tour.T_W_B[first], yaw, rng), _glance(tour.T_W_B[second], yaw + rng.normal(0.0, _SECOND_YAW), rng)


def _glance(T_W_B: Pose, yaw: float, rng: np.random.Generator) -> Pose:
    pitch, roll, rise = rng.normal(0.0, (_PITCH, _ROLL, _HEIGHT))
    (cy, sy), (cp, sp), (cr, sr) = ((np.cos(a), np.sin(a)) for a in (yaw, pitch, roll))
    turn = np.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]]) @ [[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]]
    moved = T_W_B.copy()
    moved[:3, :3] = T_W_B[:3, :3] @ turn @ [[1, 0, 0], [0, cr, -sr], [0, sr, cr]]
    moved[2, 3] += rise
    return moved
