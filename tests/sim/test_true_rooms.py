"""The boxes of the room file are exactly the true rooms of a house."""

import numpy as np
import pytest
import yaml

from sim.house_files import MODELS
from worlds.house import build_house
from worlds.presets import sample_house
from worlds.spec import HouseSpec
from worlds.truth import room_at

_L_SHAPE = [[0, 0], [6, 0], [6, 2], [3, 2], [3, 5], [0, 5]]
L_SHAPED = {"storeys": [{"height_m": 2.5, "rooms": [{"id": "a", "label": "kitchen", "polygon_m": _L_SHAPE}]}], "seed": 1}


def rooms_at(rooms, points):
    """For each point the first room with a box that contains the point, as Hydra finds it; -1 for none."""
    found = np.full(len(points), -1)
    for room, boxes in sorted(rooms.items(), reverse=True):
        for box in boxes:
            found[(np.abs(points - box["center"]) <= np.array(box["extents"]) / 2).all(axis=1)] = room
    return found


@pytest.mark.parametrize("spec", [sample_house("home", 5), HouseSpec.model_validate(L_SHAPED)], ids=["home", "L"])
def test_boxes_and_truth_agree_on_random_points(spec, rng, tmp_path):
    house = build_house(spec)
    MODELS[".yaml"](house, tmp_path / "rooms.yaml")
    boxes = yaml.safe_load((tmp_path / "rooms.yaml").read_text())
    corners = np.concatenate([np.array(room.polygon.exterior.coords) for room in house.rooms])
    heights = rng.choice([room.floor_m + 1.0 for room in house.rooms], 3000)
    points = np.column_stack((rng.uniform(corners.min(axis=0), corners.max(axis=0), (3000, 2)), heights))
    true = room_at(house, points)
    assert set(true.tolist()) - {-1} == set(range(len(house.rooms)))
    assert np.mean(true == rooms_at(boxes, points)) > 0.999
