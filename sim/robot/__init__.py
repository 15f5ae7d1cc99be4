"""A simulated robot that drives the plans of a SLAM by pure pursuit, with range scans and its own drifting pose estimate.

`drive` moves the robot along the waypoints of a plan. `controller` steers the robot along the `route` and around the
obstacles that the scans show (`scan`, `local_map`). `dead_reckoning` estimates the robot's pose. `body` (with `outlines`)
finds collisions and missing ground with MuJoCo.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
