"""SLAM systems that the harness knows: LEXIS, and plain ones to compare with.

`lexis` is the adapter of LEXIS. `odometry_only` is no SLAM at all, and `geometric_rooms` finds floors and rooms from
positions alone; both fail where a SLAM must not.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
