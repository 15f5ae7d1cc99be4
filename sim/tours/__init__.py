"""Tours: the path of the camera through a house, and its motion along that path.

`config` describes a tour, and `tour` plans it in steps: `stops` chooses places in every room, `order` their sequence, and
`itinerary` the kind of tour (with `lanes` for the lawn-mower); `paths` finds walkable lines between them, `smooth` rounds
these off at a distance from obstacles (`clearance`), `pace` assigns times within the limits of a walker, and `view` the
direction of the camera. `motion` is the resulting curve with exact derivatives, `sway` the gait on top of it, and `start`
an initial manoeuvre.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
