"""Simulated odometry, which drifts as visual-inertial odometry does, and a simulated inertial sensor.

`config` holds the parameters of the drift and presets of them, `simulation` draws an estimate of a tour's poses, and `imu`
simulates accelerometer and gyroscope for recordings.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
