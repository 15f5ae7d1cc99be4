"""Patterns of materials: functions of an area and a random generator that return a grey shade for every pixel.

`worlds.visuals.materials` colours them. `texture_area` is the area with its size in metres, and the random fields that
patterns are mixed from; `building` holds floors and walls, `objects` furniture and things.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
