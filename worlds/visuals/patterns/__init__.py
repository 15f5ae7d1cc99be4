"""Patterns of materials: functions that take an area and a random generator, and return a shade for every pixel.

`worlds.visuals.materials` multiplies the shades by a colour. `texture_area` defines an area with its size in metres, and the
random noise that patterns are made of. `building` has the patterns of floors, walls and ceilings, and `objects` has the
patterns of furniture and small objects.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
