"""Houses of all families are sound: 300 layouts, which the project's own pytest plugin draws."""

import numpy as np
import shapely

from sim.harness import worlds
from worlds.floor_plans.preset_names import PRESETS
from worlds.house import build_house
from worlds.labels import ROOM_LABELS
from worlds.spec import HouseSpec
from worlds.truth import room_at


@worlds(presets=tuple(PRESETS), n=300, fidelity="layout")
def test_rooms_tile_their_storey_and_know_their_points(house):
    for storey in range(len(house.storeys)):
        polygons = [room.polygon for room in house.rooms if room.storey == storey]
        assert np.isclose(shapely.union_all(polygons).area, sum(polygon.area for polygon in polygons))
    assert {room.label for room in house.rooms} <= set(ROOM_LABELS)
    inside = np.array([[*room.polygon.representative_point().coords[0], room.floor_m + 1.0] for room in house.rooms])
    assert room_at(house, inside).tolist() == list(range(len(house.rooms)))
    again = build_house(HouseSpec.from_json(house.spec.to_json()))
    assert again.spec == house.spec and [room.polygon for room in again.rooms] == [room.polygon for room in house.rooms]
