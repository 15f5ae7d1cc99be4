"""Recorded runs as input: TUM RGB-D, EuRoC ASL and ROS 2 bags.

`open_dataset` (in `dataset`) recognises the format by the files in the folder. `tum_rgbd`, `euroc` and `ros2` read one
format each; `recorded` holds code that these three share, `camera_tracks` joins the images of several cameras, and
`image_header` checks images without decoding them.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
