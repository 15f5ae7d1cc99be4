"""Tours: the path of the camera through a house, and the motion of the camera along that path.

`config` describes a tour, and `tour` plans it in steps. `stops` chooses places in every room, `order` puts them in sequence,
and `itinerary` decides what each kind of tour visits (with `lanes` for the lawn-mower). `paths` finds walkable lines between
the places, and `smooth` rounds them at a distance from obstacles (`clearance`). `pace` assigns times within the limits of a
walker, and `view` chooses the direction of the camera. `motion` is the resulting curve with exact derivatives. `sway` adds
the movements of a gait, and `start` adds a manoeuvre before the walk.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
