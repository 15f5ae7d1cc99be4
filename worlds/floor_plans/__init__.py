"""Floor plans: from a list of rooms to rooms with outlines, joined by links, storey by storey.

Presets: `building_kinds` and `room_lists` choose the rooms, `programmes` groups them into bays and runs of bays by their
`room_sizes`. `floor_plan` then lays out all storeys: `wings` places corridors, stairs and the depth of bands, `bands`
assigns bays to bands, `bays` cuts bays into rooms, `outdoors` adds gardens and balconies, and `storey_draft` collects
`rectangles` in whole centimetres until they become a `worlds.layout`. Hypothesis: `grown_plan` grows a house room by room.
Variants: `symmetry` mirrors and turns a house, `upper_storey` adds a storey.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
