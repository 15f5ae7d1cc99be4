"""Placement of furniture: a seeded search that keeps every room walkable.

`furnish` fills the rooms of a storey: `counts` decides how many pieces of a kind there are, `candidates` proposes places,
and `room_plan` accepts a place that is free and leaves the room walkable (`free_floor`). `kept_free` lists what openings and
windows need, `room_shape` is the outline of the room, `piece` a placed piece, and `draws` gives every piece a random stream
of its own.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
