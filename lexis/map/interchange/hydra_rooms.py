"""The rooms of a map as boxes, in the YAML file that the room evaluator of Hydra reads.

The file maps the number of each room to a list of boxes, whose union is the room (`eval/src/room_io.cpp` of
https://github.com/MIT-SPARK/Hydra, option `--bbox_file` of its program `evaluate_rooms`):

    3:
    - center: [1.0, 2.0, 1.2]
      extents: [4.0, 3.0, 2.4]
      rotation: {w: 1.0, x: 0.0, y: 0.0, z: 0.0}
"""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from jaxtyping import Float64

from lexis.files.replace import replaced_file
from lexis.floors import NO_FLOOR
from lexis.map.interchange.room_areas import rectangles, room_masks
from lexis.sight.cells import CELL_M
from lexis.sight.storey_grid import StoreyGrid, storey_grid, storeys
from lexis.types import LexisMap

STAIRS_BOX_M = (1.0, 1.0, 2.0)
"""Size of the box around the camera of every keyframe on stairs, for which there is no plan with free cells [m]."""
_KEYFRAME_BOX_M = (CELL_M, CELL_M, 2.0)
"""Size of the box around the camera of every keyframe of a room to which no free cell belongs [m]."""
Box = dict[str, Any]
"""A box in the form that it has in the file."""
RoomBoxes = Mapping[int, list[Box]]
"""The boxes of every room, by the room's number."""


def write_hydra_rooms(map: LexisMap, path: Path) -> None:
    """Write the boxes of all rooms. Raises LexisError if the file cannot be written, or a floor is too large."""
    write_room_boxes(hydra_rooms(map), path)


def write_room_boxes(rooms: RoomBoxes, path: Path) -> None:
    """Write a room file. Raises LexisError if it cannot be written."""
    with replaced_file(path) as beside:
        beside.write_text(yaml.safe_dump(dict(rooms), default_flow_style=None, width=120), encoding="utf-8")


def hydra_rooms(map: LexisMap) -> RoomBoxes:
    """Return the boxes of every room in W, by the id of the room.

    A room on a floor is the union of boxes between the floor and the ceiling. A room that contains keyframes on stairs has a
    box around the camera of each of these keyframes. If all keyframes of a room share their cells with earlier keyframes of
    other rooms, no cell belongs to the room; it then has a small box around the camera of each of its keyframes, which lies
    inside the other rooms. Every room has at least one box.
    """
    boxes: dict[int, list[Box]] = {room.id: [] for room in map.rooms}
    for floor, component in storeys(map):
        grid = storey_grid(map, floor, component)
        for room_id, mask in room_masks(map, grid).items():
            boxes[room_id] += [room_box(*_corners(grid, rectangle)) for rectangle in rectangles(mask)]
    for room in map.rooms:
        on_stairs = [i for i in room.keyframes if map.floors[i] == NO_FLOOR]
        boxes[room.id] += _around_cameras(map, on_stairs, STAIRS_BOX_M)
        boxes[room.id] = boxes[room.id] or _around_cameras(map, room.keyframes, _KEYFRAME_BOX_M)
    return boxes


def _corners(grid: StoreyGrid, rectangle: tuple[int, int, int, int]) -> Float64[np.ndarray, "2 3"]:
    """Return the lowest and the highest corner of the box over a rectangle of cells, in W [m]."""
    row, column, row_end, column_end = rectangle
    plan = grid.origin + CELL_M * np.array([[column, row], [column_end, row_end]])
    return np.column_stack((plan, grid.heights))


def _around_cameras(map: LexisMap, keyframes: Sequence[int], size_m: tuple[float, float, float]) -> list[Box]:
    """Return a box of the given size around the camera of each keyframe."""
    half = np.array(size_m) / 2
    cameras = (map.T_W_B[list(keyframes)] @ map.camera.T_B_C)[:, :3, 3]
    return [room_box(camera - half, camera + half) for camera in cameras]


def room_box(low: Float64[np.ndarray, "3"], high: Float64[np.ndarray, "3"]) -> Box:
    """Return the upright box between its lowest and its highest corner [m]."""
    centre, extents = np.round((low + high) / 2, 4), np.round(high - low, 4)
    upright = {"w": 1.0, "x": 0.0, "y": 0.0, "z": 0.0}
    return {"center": centre.tolist(), "extents": extents.tolist(), "rotation": upright}
