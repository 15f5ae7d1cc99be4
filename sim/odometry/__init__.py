"""Odometry that drifts as visual-inertial odometry does, and the inertial sensor behind it.

`config` holds the error law's parameters and the presets, `simulation` draws an estimate of a tour's poses, and `imu`
simulates accelerometer and gyroscope for recordings.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
