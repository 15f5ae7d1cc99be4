"""Openings between rooms: doors, arches, half walls, counters and windows, and the openness of a house.

`placement` chooses where in a wall an opening is (as an `opening_draft`) and `door_swings` how its leaf swings; `doors` and
`windows` build the solid parts. `openness` opens or closes `partitions` (the whole boundary between two rooms) by one of the
`opening_forms` until a house has the requested openness.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
