"""A robot in MuJoCo that follows the plans of a SLAM by pure pursuit, with range scans and its own drifting pose estimate.

`drive` takes the body along the waypoints; `controller` steers it along the `route` and around the obstacles in the scans
(`scan`, `local_map`); `dead_reckoning` estimates the robot's pose, and `body` (with `outlines`) finds contacts and missing
ground with MuJoCo.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
