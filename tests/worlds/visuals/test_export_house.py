"""A house as GLB has the same surfaces when an independent reader loads it."""

import io

import numpy as np
import pytest
import trimesh

from worlds.house import build_house
from worlds.presets import sample_house
from worlds.visuals.house_visuals import visuals
from worlds.visuals.mesh_files import to_glb, to_trimesh
from worlds.walls import WALL_THICKNESS_M


@pytest.fixture(scope="module")
def house():
    return build_house(sample_house("home", 2))


def test_floors_have_the_area_of_the_rooms(house):
    scene = to_trimesh(house)
    for room in house.rooms:
        _, name = scene.graph[f"{room.id}/floor"]
        clear_of_walls = room.polygon.buffer(-WALL_THICKNESS_M / 2, join_style="mitre").area
        assert clear_of_walls - 1e-6 <= scene.geometry[name].area <= room.polygon.area + 1e-6


def test_a_glb_holds_every_object_in_its_place(house):
    read = trimesh.load_scene(io.BytesIO(to_glb(house)), file_type="glb")
    assert {piece.id for piece in house.furniture if piece.parts} <= set(read.graph.nodes)
    points = np.concatenate([visual.corners.reshape(-1, 3) for visual in visuals(house).parts])
    y_up = points[:, [0, 2, 1]] * (1.0, 1.0, -1.0)
    assert np.allclose(read.bounds, [y_up.min(axis=0), y_up.max(axis=0)], atol=1e-5)


def test_a_glb_carries_its_textures(house):
    read = trimesh.load_scene(io.BytesIO(to_glb(house)), file_type="glb")
    room = house.rooms[0]
    _, name = read.graph[f"{room.id}/floor"]
    picture = np.asarray(read.geometry[name].visual.material.baseColorTexture.convert("RGB")).astype(float)
    assert np.abs(picture - visuals(house).images[f"{room.id}/floor"]).mean() < 6.0
