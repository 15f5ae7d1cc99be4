"""Floor plans: from a list of rooms to rooms with outlines and links (requests for openings between rooms), by storey.

For presets, which `preset_names` lists, `building_kinds` and `room_lists` choose the rooms. `programmes` draws areas
from `room_sizes`, and groups the rooms: a bay is a main room with the small rooms carved from it, and the bays of a
group stay side by side.

`floor_plan` then lays out all storeys. `wings` places corridors, stairs and bands (rows of rooms along a corridor), `bands`
chooses a band for every group of bays, `bays` cuts bays into rooms, and `outdoors` adds gardens and balconies.
`storey_draft` collects the rooms of a storey as `rectangles` in whole centimetres and turns them into a `worlds.layout`.

For property-based tests, `grown_plan` builds a house from a list of room requests. For variants of a house, `symmetry`
mirrors and rotates it, and `upper_storey` adds a storey.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
