"""The true rooms of a house as boxes, in the file that Hydra's evaluator reads (`lexis.map.interchange.hydra_rooms`)."""

from collections.abc import Iterator
from itertools import pairwise

import numpy as np
import shapely

from lexis.map.interchange.hydra_rooms import Box, RoomBoxes, room_box
from worlds.house import House, Room


def true_room_boxes(house: House) -> RoomBoxes:
    """Return boxes in W for every room, by the index of the room in `House.rooms`; the boxes fill the room exactly."""
    return {i: list(_boxes(room)) for i, room in enumerate(house.rooms)}


def _boxes(room: Room) -> Iterator[Box]:
    """Cut a room at the x coordinates of all corners. The pieces are boxes, because walls run along x or y."""
    cuts = np.unique(shapely.get_coordinates(room.polygon)[:, 0]).tolist()
    _, low_y, _, high_y = room.polygon.bounds
    for left, right in pairwise(cuts):
        for part in shapely.get_parts(room.polygon.intersection(shapely.box(left, low_y, right, high_y))):
            if part.area > 0.0:  # a wall along the cut is a line
                low, high = np.reshape(part.bounds, (2, 2))
                yield room_box(np.array([*low, room.floor_m]), np.array([*high, room.ceiling_m]))
