"""`Person`: a person, made of plain shapes, who walks along a tour."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from sim.render.actor import Actor
from sim.tours.tour import Tour
from worlds.parts import Colour, Part
from worlds.visuals.meshes import Solid

_STRIDE_M = 0.45
"""Distance between the feet when both are on the floor [m]."""
_STEPS_HZ = 1.8
_NEAREST_M = 0.45
"""Least distance from the camera at which a person is drawn [m]."""
_SKIN: tuple[Colour, ...] = ((0.93, 0.76, 0.64), (0.78, 0.57, 0.42), (0.5, 0.34, 0.25))
_SHIRTS: tuple[Colour, ...] = ((0.75, 0.15, 0.15), (0.15, 0.3, 0.65), (0.2, 0.5, 0.3), (0.85, 0.8, 0.7), (0.2, 0.2, 0.22))
_TROUSERS: tuple[Colour, ...] = ((0.16, 0.2, 0.36), (0.3, 0.27, 0.24), (0.12, 0.12, 0.13))
_SHOES: Colour = (0.1, 0.09, 0.08)


@dataclass(frozen=True)
class Looks:
    """Appearance of a person."""

    height_m: float
    skin: Colour
    shirt: Colour
    trousers: Colour


def draw_person(rng: np.random.Generator) -> Looks:
    """Choose the colours of a person, and a height between 1.55 and 1.95 m, at random."""
    skin, shirt, trousers = (shades[int(rng.integers(len(shades)))] for shades in (_SKIN, _SHIRTS, _TROUSERS))
    return Looks(float(rng.uniform(1.55, 1.95)), skin, shirt, trousers)


@dataclass(frozen=True, eq=False)
class Person(Actor):
    """A person who walks along a tour ahead of the camera, because the path of a tour is free of obstacles.

    At time `start_s` [s] the person is at the place that the tour reaches `ahead_s` [s] later. `pace` is the person's speed
    as a multiple of the tour's speed.
    """

    tour: Tour
    start_s: float
    ahead_s: float
    pace: float
    looks: Looks

    def solids_at(self, stamp: float, T_W_B: Float64[np.ndarray, "4 4"]) -> Sequence[Solid]:
        """Return the walking person's body at time `stamp` [s], or nothing if the person would be too near the camera."""
        T_W_P = self.tour.pose_at(self.start_s + self.ahead_s + self.pace * (stamp - self.start_s))
        x, y, z = T_W_P[:3, 3]
        if np.hypot(x - T_W_B[0, 3], y - T_W_B[1, 3]) < _NEAREST_M:
            return []
        heading = float(np.arctan2(T_W_P[1, 0], T_W_P[0, 0]))
        swing = float(np.sin(np.pi * _STEPS_HZ * (stamp - self.start_s)))
        position = (float(x), float(y), float(z) - self.tour.eye_height_m)
        return [Solid(_body(self.looks, swing), position, heading - np.pi / 2)]


def _body(looks: Looks, swing: float) -> tuple[Part, ...]:
    """Build a person who looks along y.

    `swing`, in [-1, 1], is the position of the right foot, as a share of half a stride ahead. The left foot is as far
    behind.
    """
    h = looks.height_m / 1.75
    parts = [
        Part("cylinder", (0.0, 0.0, 1.16 * h), (0.38, 0.22, 0.56 * h), looks.shirt),
        Part("ball", (0.0, 0.0, 1.42 * h), (0.42, 0.22, 0.16), looks.shirt),
        Part("cylinder", (0.0, 0.0, 0.9 * h), (0.34, 0.22, 0.18 * h), looks.trousers),
        Part("cylinder", (0.0, 0.0, 1.48 * h), (0.11, 0.11, 0.12 * h), looks.skin),
        Part("ball", (0.0, 0.01, 1.63 * h), (0.16, 0.2, 0.24 * h), looks.skin),
        Part("ball", (0.0, -0.015, 1.67 * h), (0.17, 0.2, 0.18 * h), _SHOES),
    ]
    for side in (-1.0, 1.0):
        foot = side * swing * _STRIDE_M / 2
        parts += [
            Part("cylinder", (0.1 * side, 0.35 * foot, 0.65 * h), (0.17, 0.17, 0.5 * h), looks.trousers),
            Part("cylinder", (0.1 * side, 0.8 * foot, 0.25 * h), (0.13, 0.13, 0.42 * h), looks.trousers),
            Part("box", (0.1 * side, foot + 0.05, 0.04), (0.1, 0.27, 0.08), _SHOES),
            Part("cylinder", (0.24 * side, -0.2 * foot, 1.25 * h), (0.1, 0.1, 0.34 * h), looks.shirt),
            Part("cylinder", (0.24 * side, -0.6 * foot, 0.96 * h), (0.08, 0.08, 0.3 * h), looks.skin),
        ]
    return tuple(parts)
