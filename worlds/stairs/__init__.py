"""Stairs: flights between the storeys of a cell, each rule of a walkable stair checked.

`cells` finds the rooms that stairs stand in and where one enters them, `flights` fits straight, L- and U-shaped flights into
a cell, `geometry` turns these into boxes, and `build` puts the stairs of a house together.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
