"""`room_polygons`: the rooms of a spec as polygons, checked so that walls can be built along their sides."""

import numpy as np
import shapely
from shapely.geometry import Polygon

from worlds.errors import HouseError
from worlds.labels import STAIRS
from worlds.spec import HouseSpec


def room_polygons(spec: HouseSpec) -> dict[str, Polygon]:
    """Return the polygon of each room along the wall centre lines [m], by room id, in the order of the spec.

    Raises `HouseError` for polygons that cross or touch themselves or are clockwise, and for stairs that are no rectangle.
    All polygons are checked together, because one call of shapely for all rooms is faster than one call for each room.
    """
    rooms = [room for storey in spec.storeys for room in storey.rooms]
    points = np.array([point for room in rooms for point in (*room.polygon_m, room.polygon_m[0])])
    rings = shapely.linearrings(points, indices=np.repeat(np.arange(len(rooms)), [len(r.polygon_m) + 1 for r in rooms]))
    polygons = np.asarray(shapely.polygons(rings))
    simple, turns_left = shapely.is_valid(polygons), shapely.is_ccw(rings)
    rectangular = np.isclose(shapely.area(polygons), shapely.area(shapely.envelope(polygons)))
    for room, is_simple, is_left, is_rectangle in zip(rooms, simple, np.atleast_1d(turns_left), rectangular, strict=True):
        if not is_simple:
            raise HouseError(f"room {room.id!r}: its polygon crosses or touches itself; valid: a simple polygon")
        if not is_left:
            raise HouseError(f"room {room.id!r}: its polygon turns clockwise; valid: counter-clockwise (reverse it)")
        if room.label == STAIRS and not is_rectangle:
            raise HouseError(f"stairs {room.id!r}: their polygon is not rectangular; valid: a rectangle")
    return {room.id: polygon for room, polygon in zip(rooms, polygons, strict=True)}
