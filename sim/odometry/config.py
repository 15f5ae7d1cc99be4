"""Settings of simulated odometry, and presets with the measured drift of each preset."""

import math
from dataclasses import dataclass
from typing import Annotated

from annotated_types import Ge, Gt

from lexis.settings import Settings
from sim.errors import SimError


@dataclass(frozen=True)
class OdometryConfig(Settings, place="odometry", error=SimError):
    """Parameters of the error of simulated odometry, which grows with the path's length; see `sim.odometry.simulation`."""

    position_walk_m: Annotated[float, Ge(0)] = 0.0
    """White noise of translation: standard deviation of the position's random walk after 1 m of path, per axis [m/√m]."""
    yaw_walk_rad: Annotated[float, Ge(0)] = 0.0
    """White noise of yaw: standard deviation of the yaw's random walk after 1 m of path [rad/√m]."""
    scale_error: Annotated[float, Ge(0)] = 0.0
    """Standard deviation of the relative error of scale. The error is constant in a run and differs between runs."""
    velocity_bias: Annotated[float, Ge(0)] = 0.0
    """Standard deviation, per body axis, of the slowly varying bias of the translation, as a share of the path's length."""
    yaw_bias_rad_m: Annotated[float, Ge(0)] = 0.0
    """Standard deviation of the slowly varying bias of yaw, per metre of path [rad/m]."""
    bias_correlation_m: Annotated[float, Gt(0)] = 60.0
    """Length of path over which the correlation of a bias, a first-order Gauss-Markov process, falls to 1/e [m]."""
    tilt_rad: Annotated[float, Ge(0)] = 0.0
    """Standard deviation of the errors of roll and of pitch, which gravity keeps bounded [rad]."""
    tilt_correlation_m: Annotated[float, Gt(0)] = 2.0
    """Length of path over which the correlation of the errors of roll and pitch falls to 1/e [m]."""
    overconfidence: Annotated[float, Ge(1)] = 1.0
    """Factor by which the reported covariance is too small. This is also the NEES (normalised estimation error squared) of
    an increment, per degree of freedom. At 1, covariances match the errors; published filters reach 200 in orientation."""
    rate_hz: Annotated[float, Ge(100)] = 100.0
    """Least rate of the increments of motion that are added up along a tour [Hz]."""


def _preset(
    *, walk_m: float, yaw_walk_deg: float, scale: float, velocity_bias: float, yaw_bias_deg_m: float, tilt_deg: float
) -> OdometryConfig:
    return OdometryConfig(
        position_walk_m=walk_m,
        yaw_walk_rad=math.radians(yaw_walk_deg),
        scale_error=scale,
        velocity_bias=velocity_bias,
        yaw_bias_rad_m=math.radians(yaw_bias_deg_m),
        tilt_rad=math.radians(tilt_deg),
    )


ODOMETRY_PRESETS = {
    "perfect": OdometryConfig(),
    "multicam": _preset(
        walk_m=0.026, yaw_walk_deg=0.20, scale=0.005, velocity_bias=0.003, yaw_bias_deg_m=0.024, tilt_deg=0.15
    ),
    "mono": _preset(walk_m=0.038, yaw_walk_deg=0.34, scale=0.008, velocity_bias=0.004, yaw_bias_deg_m=0.038, tilt_deg=0.30),
    "degraded": _preset(
        walk_m=0.043, yaw_walk_deg=0.75, scale=0.010, velocity_bias=0.005, yaw_bias_deg_m=0.12, tilt_deg=0.50
    ),
    "openvins": _preset(
        walk_m=0.012, yaw_walk_deg=0.17, scale=0.001, velocity_bias=0.001, yaw_bias_deg_m=0.007, tilt_deg=0.38
    ),
}
"""Presets of the odometry by name. The table shows, for tours of 100 m, the mean relative pose errors over 8, 24 and 48 m of
path and the ATE (absolute trajectory error). All values are averages over runs; a test checks the relative pose errors:

============  =================  =================  =================  ========
preset        8 m                24 m               48 m               ATE
============  =================  =================  =================  ========
multicam      0.14 m  0.63 deg   0.26 m  1.03 deg   0.37 m  1.43 deg   0.23 m
mono          0.21 m  1.11 deg   0.38 m  1.76 deg   0.54 m  2.41 deg   0.33 m
degraded      0.26 m  2.36 deg   0.54 m  4.15 deg   0.78 m  6.10 deg   0.50 m
openvins      0.07 m  0.85 deg   0.13 m  1.06 deg   0.19 m  1.26 deg   0.11 m
============  =================  =================  =================  ========

- `multicam` drifts by 1 % and 0.05 deg/m over 24 m, as visual-inertial odometry with several cameras does in a house.
- `degraded` drifts by 2 % and 0.2 deg/m over 24 m, as visual-inertial odometry does in a house with little texture.
- `mono` has the yaw error of `multicam` divided by 0.61, the published ratio between several cameras and one.
- `openvins` follows the curve published for monocular OpenVINS in EuRoC's Vicon rooms (0.094 m 0.83 deg, 0.111 m 1.22 deg,
  0.184 m 1.43 deg). These sequences stay in one small room. The preset drifts too little over a house to show the difference
  between a good and a bad back end, so the other presets do not follow this curve.

`overconfidence` is the NEES per degree of freedom of single increments. If the increments of 8 to 96 m of path are composed
as though they were independent, the NEES is 0.8 to 1.0 times `overconfidence` (`openvins`: 0.5 to 0.8). The reason is that
tilt errors cancel each other, which lowers the NEES. Biases add up and raise the NEES, but by less.
"""
