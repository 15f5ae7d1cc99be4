"""The pose graph: keyframes joined by odometry and loop edges, and the poses that fit these edges best.

Read `pose_graph` first: the graph grows with each keyframe and each loop. `graph_optimisation` finds the poses and limits
the influence of wrong loops (paper, Eq. 2). `thinning` tells which keyframes are no longer needed, and `components` which
sessions are connected by loops and share a frame. `trusted_loops` tells which loops count as true, and `walked_steps` lists
the pairs of keyframes that the camera moved between. `far_loops` keeps loops that the poses rule out, in case the robot has
been carried elsewhere. `pose_estimate` is what a loop verifier reads of the graph, and `loop_record` keeps the candidates
and decisions of every keyframe.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
