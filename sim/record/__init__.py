"""Writes runs as datasets for other programs: EuRoC ASL, TUM RGB-D and ROS 2 bags. Ground truth is in separate files.

`recording` writes a dataset. `take` collects the data that all sensors measure on one tour. `euroc`, `tum_rgbd` and `ros2`
(with `messages`) each write these data in one format; `image_names` names the files of images. `settings` writes the
settings files of other SLAM systems, and `rooms` writes the true rooms. `stamps` says when a recording begins. From a
recording, `lexis run` makes the same map as LEXIS makes in the live run.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
