"""Paths between rooms over the pose graph (paper, Sec. IV, planning application).

Read `planner` first: it joins the parts. `path_ends` chooses the keyframe from which a path leaves a room, and `arrivals`
the keyframes at which a path into a room may end, because a robot there is surely inside. Both compare the `evidence` for
rooms. `connections` are the steps between keyframes that a robot can travel; the longest of them are `shortcuts` through
space that the images show to be free. Both choose among `close_pairs` of keyframes.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
