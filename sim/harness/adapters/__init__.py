"""Adapters for the SLAM systems that ship with the harness: LEXIS, and two simple baselines.

`lexis` is the adapter of LEXIS, `closure_log` records its loop closures, and `true_stages` contains replacements for
stages of LEXIS that know the truth. `odometry_only` returns the odometry's poses without any SLAM, and `geometric_rooms`
finds floors and rooms from positions alone. Both baselines fail in situations that a SLAM has to master.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
