"""Floor plans: from a list of rooms to rooms with outlines, joined by links, storey by storey.

For presets, `building_kinds` and `room_lists` choose the rooms, and `programmes` groups them into bays and runs of bays by
their `room_sizes`. `floor_plan` then lays out all storeys: `wings` places corridors, stairs and bands (rows of rooms along a
corridor), `bands` assigns bays to bands, `bays` cuts bays into rooms, `outdoors` adds gardens and balconies, and
`storey_draft` collects `rectangles` in whole centimetres until they become a `worlds.layout`.

For Hypothesis, `grown_plan` grows a house room by room. For variants of a house, `symmetry` mirrors and turns it, and
`upper_storey` adds a storey.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
