"""Import of floor plans drawn elsewhere: GeoJSON or SVG becomes a validated house.

`importer` orders the steps: `geojson` or `svg` (with `svg_tree` and `svg_shapes`) reads a `drawn_plan`, `straighten` makes
its outlines rectilinear, `drawn_openings` moves strokes to the nearest wall, and `added_openings` adds doors and stairs
where rooms could not be reached otherwise.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
