"""Generated houses with several rooms and storeys, and the exact truth about them. Pure geometry: no simulator, no SLAM.

A house exists in two forms. `HouseSpec` (`spec.py`) is plain data with a JSON form. `build_house` (`house.py`) turns a spec
into exact geometry; equal specs give equal geometry. There are four sources of specs: `presets` (families of houses, one
house for each seed), `strategies` (for tests with Hypothesis, which reduces a failing house to a simpler one), `variant`
(the same house with some properties changed) and `plan_import` (floor plans drawn with other programs).

All other modules read the built house: `truth` says which room a point is in and which boundaries are open, `walkable` finds
paths, and `validation` checks that the house is possible and that every room can be reached on foot. The subpackages:

- `floor_plans`: layouts of storeys, made from lists of room labels.
- `openings`: doors, arches, half walls and windows, and the openness of a house.
- `stairs`: flights between storeys.
- `furniture`: the catalogue, and the placement of pieces in rooms.
- `visuals`: textures, meshes and export.
- `checks`: the individual checks that `validation` runs.

Glossary:

- room: a room instance with a label. Stairs are one room through all the storeys that they join.
- opening: any gap in a wall between two rooms; a leaf is the part of a door that swings.
- openness: the share of the inner walls' area that is permanently open, in [0, 1].
- spec: the plain data that describes a house or a part of it.
- W: the world frame of a house; x points east, y north, z up.
- bay: a slice of a storey with one main room and up to two small ones. A group consists of bays that stay side by side, a
  band is a row of bays along a corridor, and a wing is a corridor with its bands.
- clutter: factor for the amount of furniture that is filled in; 0: none, 1: as in a usual home.
- piece: one piece of furniture in its place. The host of a piece is the other piece that it stands at or on, or hangs above.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
