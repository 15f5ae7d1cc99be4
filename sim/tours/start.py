"""`with_start_manoeuvre`: a few seconds of swinging on the spot, from which visual-inertial systems initialise."""

from dataclasses import replace

import numpy as np
from jaxtyping import Float64

from sim.tours.motion import DEGREE, Motion
from sim.tours.pace import Limits

_DURATION_S = 5.0
_RAMP_S = 0.8
"""Over which the swing grows at its start and fades at its end."""
_ACROSS, _UP, _YAW, _PITCH = range(4)
_AMPLITUDE = np.array([0.03, 0.0045, 0.14, 0.07])
"""To the side [m], up [m], of yaw and of pitch [rad]."""
_HERTZ = np.array([0.6, 3.0, 0.5, 0.9])
"""The slow swing to the side gives parallax; the fast one changes the acceleration between frames, at up to 30 a second."""
_DESIGNED_FOR = Limits()
"""The limits that the full swing keeps."""


def with_start_manoeuvre(motion: Motion, limits: Limits) -> Motion:
    """The motion, preceded by five seconds of swinging about its first pose: sideways, up and down, in yaw and in pitch.

    The body stays within 4 cm of the pose and begins and ends there at rest. The swing is part of the spline, so all
    derivatives stay exact and continuous. Limits below those of an ordinary walk make it weaker in proportion.
    """
    swing = _swing(motion.knot_s) * _strength(limits)
    first = motion.controls[0]
    yaw = first[3]
    controls = np.tile(first, (len(swing), 1))
    controls[:, :2] += swing[:, _ACROSS, None] * [-np.sin(yaw), np.cos(yaw)]
    controls[:, 2] += swing[:, _UP]
    controls[:, 3] += swing[:, _YAW]
    controls[:, 4] += swing[:, _PITCH]
    return replace(motion, controls=np.concatenate([controls, motion.controls]))


def _swing(knot_s: float) -> Float64[np.ndarray, "n 4"]:
    """The swing at every knot, led in by as many knots at rest as one point of the spline depends on."""
    t = np.arange(0.0, _DURATION_S, knot_s)
    ramp = np.clip(np.minimum(t, _DURATION_S - t) / _RAMP_S, 0.0, 1.0)
    window = np.sin(np.pi / 2 * ramp) ** 2
    waves = _AMPLITUDE * np.sin(2 * np.pi * _HERTZ * t[:, None])
    return np.pad(window[:, None] * waves, [(DEGREE, 0), (0, 0)])


def _strength(limits: Limits) -> float:
    """The share of the full swing that keeps the limits."""
    return float(min(1.0, *(getattr(limits, name) / full for name, full in vars(_DESIGNED_FOR).items())))
