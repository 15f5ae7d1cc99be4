"""Stairs: flights of steps and spiral stairs, which are built only where a person can walk them, and lifts.

A flight joins one storey to the next. It consists of one or two straight runs of steps, with a landing between two runs.

`cells` finds the rooms that stairs stand in and the openings that lead to them, `flights` fits straight, L- and U-shaped
flights into such a room, `spirals` makes spiral stairs, `shafts` finds the entrances of spirals and lifts and the way
through a lift, `geometry` turns the flights into boxes, and `build` combines these for a whole house.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
