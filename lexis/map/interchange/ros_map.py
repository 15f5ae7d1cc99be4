"""Occupancy grids for ROS: for each storey the `map.yaml` and PGM of map_server and Nav2, with the rooms as polygons.

For floor 0, the folder holds `floor0.yaml`, `floor0.pgm` and `floor0.geojson`, and so on for other floors. Sessions that
share no frame with the first one have files of their own, such as `floor0-session2.yaml`. `storeys.json` lists the storeys,
each with the first session that was there. Pixels are 254 for free, 0 for occupied and 205 for unknown cells, as map_saver
writes them; the thresholds are chosen so that unknown cells do not count as free. A cell is only free if a camera also looks
through it near the floor, because otherwise it may be over a table. All coordinates are in the frame W of the map [m], also
those of the GeoJSON.
"""

import json
from pathlib import Path
from typing import Any

import numpy as np
import shapely
import yaml
from jaxtyping import UInt8

from lexis.errors import MapError
from lexis.files.replace import replaced_folder
from lexis.map.interchange.room_areas import outline, room_masks
from lexis.room_names import instance_names
from lexis.sight.cells import CELL_M
from lexis.sight.storey_grid import StoreyGrid, storey_grid, storeys
from lexis.types import LexisMap

INDEX = "storeys.json"
FREE, OCCUPIED, UNKNOWN = 254, 0, 205
"""Values of pixels for free, occupied and unknown cells."""
_THRESHOLDS = {"occupied_thresh": 0.65, "free_thresh": 0.196}
"""A pixel of value v is free if (255 - v) / 255 is below `free_thresh`. This quotient is 0.1961 for unknown cells, which are
thus not free."""


def write_ros_maps(map: LexisMap, path: Path) -> None:
    """Write a folder with the grids and rooms of all floors. An earlier folder of this kind is replaced.

    Raises LexisError if the folder cannot be written or holds something else, or if the map has no floor or a floor is too
    large.
    """
    grids = [storey_grid(map, floor, component) for floor, component in storeys(map)]
    if not grids:
        raise MapError("the map has no floor, only stairs; valid: a map with keyframes on a floor")
    with replaced_folder(path, INDEX) as folder:
        for grid in grids:
            _write_storey(map, grid, folder)
        (folder / INDEX).write_text(json.dumps([_entry(grid) for grid in grids], indent=1) + "\n", encoding="utf-8")


def _write_storey(map: LexisMap, grid: StoreyGrid, folder: Path) -> None:
    names = _entry(grid)
    x, y = np.round(grid.origin, 6).tolist()
    header = {"image": names["image"], "mode": "trinary", "resolution": CELL_M, "origin": [x, y, 0.0], "negate": 0}
    text = yaml.safe_dump(header | _THRESHOLDS, sort_keys=False, default_flow_style=None)
    (folder / names["map"]).write_text(text, encoding="utf-8")
    pixels = _pixels(grid)
    rows, columns = pixels.shape
    (folder / names["image"]).write_bytes(f"P5\n{columns} {rows}\n255\n".encode() + pixels.tobytes())
    (folder / names["rooms"]).write_text(json.dumps(_rooms(map, grid)) + "\n", encoding="utf-8")


def _entry(grid: StoreyGrid) -> dict[str, Any]:
    """Return the names of a storey's files, and the heights of its floor and ceiling in W [m]."""
    name = f"floor{grid.floor}" + (f"-session{grid.component}" if grid.component else "")
    heights = {"floor_m": round(grid.heights[0], 3), "ceiling_m": round(grid.heights[1], 3)}
    numbers = {"floor": grid.floor, "session": grid.component}
    return numbers | {"map": f"{name}.yaml", "image": f"{name}.pgm", "rooms": f"{name}.geojson"} | heights


def _pixels(grid: StoreyGrid) -> UInt8[np.ndarray, "rows columns"]:
    """Return the image of a grid. Its first row is the row with the highest y."""
    pixels = np.full(grid.free.shape, UNKNOWN, np.uint8)
    pixels[grid.free & grid.low] = FREE
    pixels[grid.occupied] = OCCUPIED
    return pixels[::-1]


def _rooms(map: LexisMap, grid: StoreyGrid) -> dict[str, Any]:
    """Return the rooms of a storey as GeoJSON."""
    names = instance_names(map.rooms)
    features = [
        {
            "type": "Feature",
            "properties": {"id": room, "name": names[room], "label": map.rooms[room].label, "floor": grid.floor},
            "geometry": shapely.geometry.mapping(outline(mask, grid)),
        }
        for room, mask in room_masks(map, grid).items()
    ]
    return {"type": "FeatureCollection", "features": features}
