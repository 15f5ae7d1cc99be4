"""A robot that drives the plans of a SLAM: a body in MuJoCo, a range scan, and pure pursuit by its own drifting estimate.

`drive` takes the body along the waypoints; `controller` steers it along the `route` and around what the scans show
(`scan`, `local_map`); `dead_reckoning` is what the robot believes of its pose, and `body` (with `outlines`) what MuJoCo
says of contacts and falls.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
