"""Several sessions in one map: a robot that returns on another day, or two maps that are merged.

A session is one recording, with an odometry frame of its own. Sessions that are connected by loop edges form a component of
the map, in which all poses share one frame (`lexis.graph.components`). A new session begins as a component of its own.
`relocalisation` seeks its place in the rest of the map, and joins both when several keyframes agree. `kidnapping` finds out
whether the robot was carried elsewhere during a session. `compatibility` checks that a session fits a map. `lexis.merging`
merges two saved maps in the same way, and `renumbered_map` tells how the second map has joined its sessions.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
