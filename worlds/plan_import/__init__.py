"""Import of floor plans drawn elsewhere: GeoJSON or SVG becomes a validated house.

`importer` calls the steps in order: `geojson` or `svg` (with `svg_tree` and `svg_shapes`) reads a `drawn_plan`, `straighten`
makes the rooms' outlines rectilinear, `drawn_openings` moves each stroke (a drawn opening) to the nearest wall, and
`added_openings` adds openings to rooms and stairs that could not be reached otherwise.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
