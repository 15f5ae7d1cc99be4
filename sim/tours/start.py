"""`with_start_manoeuvre`: adds movements on the spot before a walk, so that visual-inertial systems can initialise."""

from dataclasses import replace

import numpy as np
from jaxtyping import Float64

from sim.tours.motion import DEGREE, Motion
from sim.tours.pace import Limits

_DURATION_S = 5.0
_RAMP_S = 0.8
"""Time over which the swing grows at its start and fades at its end [s]."""
_ACROSS, _UP, _YAW, _PITCH = range(4)
_AMPLITUDE = np.array([0.03, 0.0045, 0.14, 0.07])
"""Amplitudes: sideways and up [m], in yaw and in pitch [rad]."""
_HERTZ = np.array([0.6, 3.0, 0.5, 0.9])
"""Frequencies of these four motions [Hz]. The slow sideways swing gives parallax. The fast vertical swing makes the
acceleration differ between frames, at up to 30 frames a second."""
_DESIGNED_FOR = Limits()
"""Limits of speed, acceleration and turning within which the full swing stays."""


def with_start_manoeuvre(motion: Motion, limits: Limits) -> Motion:
    """Return a motion that first swings about the first pose of `motion` for five seconds, and then continues with `motion`.

    The body swings sideways, up and down, in yaw and in pitch. It stays within 4 cm of the first pose, and is at rest there
    before and after. The swing is part of the spline, so all derivatives stay exact and continuous. If a limit is below its
    default value, the swing is weaker in proportion.
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
    """Return the displacement by the swing at every knot: sideways and up [m], in yaw and in pitch [rad].

    The first `DEGREE` knots are at rest, so that the spline starts at rest.
    """
    t = np.arange(0.0, _DURATION_S, knot_s)
    ramp = np.clip(np.minimum(t, _DURATION_S - t) / _RAMP_S, 0.0, 1.0)
    window = np.sin(np.pi / 2 * ramp) ** 2
    waves = _AMPLITUDE * np.sin(2 * np.pi * _HERTZ * t[:, None])
    return np.pad(window[:, None] * waves, [(DEGREE, 0), (0, 0)])


def _strength(limits: Limits) -> float:
    """Return the factor, up to 1, by which the start manoeuvre's swing is scaled to stay within `limits`.

    The limits are those of speed, acceleration and turning. The full swing (factor 1) stays within the default limits.
    """
    return float(min(1.0, *(getattr(limits, name) / full for name, full in vars(_DESIGNED_FOR).items())))
