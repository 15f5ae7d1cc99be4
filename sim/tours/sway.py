"""`Sway`: the periodic motion of a hand-held or legged camera about its path, as sums of sine functions."""

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from jaxtyping import Float64

from sim.errors import SimError

SwayName = Literal["none", "hand-held", "quadruped"]
SWAYS: tuple[SwayName, ...] = get_args(SwayName)

_HAND_HELD_HZ = (0.45, 0.9, 1.8)
_HAND_HELD = np.array([[3, 6, 3, 0.35, 0.35, 0.25], [2, 5, 3, 0.25, 0.30, 0.15], [1, 1, 5, 0.10, 0.25, 0.05]])
"""Amplitudes of the sway of a hand-held camera, a row for each frequency: x, y, z [mm], roll, pitch, yaw [deg]. A step takes
about 0.55 s, and a full cycle of the gait two steps."""
_QUADRUPED_HZ = (1.5, 3.0)
_QUADRUPED = np.array([[0, 5, 1, 0.9, 0.2, 0.3], [2, 0, 5, 0.1, 0.7, 0.0]])
"""Amplitudes of the sway of a trotting robot, as in `_HAND_HELD`. The body moves sideways in cycles of two steps, and up and
down with each step."""
_JITTER = 0.25
"""Largest deviation of the amplitudes of a walk, as a share. Frequencies deviate by up to half of this share."""


@dataclass(frozen=True, eq=False)
class Sway:
    """Periodic motion of a camera about its path at full walking speed, as a sum of sine functions.

    Arrays have six columns: displacements x, y, z in the level body frame [m], and rotations roll, pitch, yaw [rad].
    """

    amplitude: Float64[np.ndarray, "m 6"]
    angular_frequency: Float64[np.ndarray, "m"]
    """Angular frequency of each sine [rad/s]."""
    phase: Float64[np.ndarray, "m 6"]
    """Phase of each sine [rad]."""

    def at(self, t: Float64[np.ndarray, "n"], derivative: int = 0) -> Float64[np.ndarray, "n 6"]:
        """Return the sway at times `t` [s], or its derivative of the order `derivative`."""
        angle = self.angular_frequency[:, None] * t[:, None, None] + self.phase + derivative * np.pi / 2
        return np.asarray((self.amplitude * self.angular_frequency[:, None] ** derivative * np.sin(angle)).sum(axis=1))


def draw_sway(kind: str, rng: np.random.Generator) -> Sway | None:
    """Draw the random sway of one walk; None if `kind` is "none". Raises `SimError` if `kind` is not one of `SWAYS`."""
    if kind not in SWAYS:
        raise SimError(f"sway {kind!r} is unknown; valid: {', '.join(SWAYS)}")
    if kind == "none":
        return None
    hertz, size = (_HAND_HELD_HZ, _HAND_HELD) if kind == "hand-held" else (_QUADRUPED_HZ, _QUADRUPED)
    amplitude = size * np.repeat([1e-3, np.pi / 180], 3) * rng.uniform(1 - _JITTER, 1 + _JITTER, size.shape)
    frequency = 2 * np.pi * np.array(hertz) * rng.uniform(1 - _JITTER / 2, 1 + _JITTER / 2)
    return Sway(amplitude, frequency, rng.uniform(0.0, 2 * np.pi, size.shape))
