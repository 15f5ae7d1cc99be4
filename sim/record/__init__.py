"""Runs as datasets for other programs: EuRoC ASL, TUM RGB-D and ROS 2 bags. The truth is in separate files.

`recording` writes a dataset, for which `take` collects the data of all sensors on one tour; `euroc`, `tum_rgbd` and `ros2`
(with `messages`) write it in one form each; `settings` writes the calibration files of other SLAM systems, and `rooms` the
true rooms. `lexis run` makes the same map from a recording as LEXIS makes in the live run.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
