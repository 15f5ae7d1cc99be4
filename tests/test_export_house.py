"""A house as GLB: the same surfaces, read back by an independent reader."""

import io

import pytest
import trimesh

from worlds.export import to_glb, to_trimesh
from worlds.house import build_house
from worlds.presets import sample_house


@pytest.fixture(scope="module")
def house():
    return build_house(sample_house("home", 2))


def test_floors_have_the_area_of_the_rooms(house):
    scene = to_trimesh(house)
    for room in house.rooms:
        _, name = scene.graph[f"{room.id}/floor"]
        assert scene.geometry[name].area == pytest.approx(room.polygon.area)


def test_a_glb_holds_every_object_in_its_place(house):
    read = trimesh.load_scene(io.BytesIO(to_glb(house)), file_type="glb")
    assert {piece.id for piece in house.furniture if piece.parts} <= set(read.graph.nodes)
    low, high = read.bounds
    assert low[2] >= -0.31 and high[2] <= house.storeys[-1].ceiling_m + house.spec.slab_m + 1.0
