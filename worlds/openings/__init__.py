"""Openings between rooms: doors, arches, half walls, counters and windows, and the openness of a house.

`placement` chooses where in a wall an opening lies (as an `opening_draft`), and `door_swings` chooses how a door's leaf
swings. `doors` and `windows` build door leaves and windows as objects. `openness` opens or closes `partitions` (each is the
whole wall between two rooms), in one of the `opening_forms`, until a house has the requested openness.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
