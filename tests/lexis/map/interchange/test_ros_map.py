"""The grids mean to map_server what they should: each place is free, occupied or unknown, at its coordinates."""

import json
from dataclasses import replace

import cv2
import numpy as np
import pytest
import shapely
import yaml
from helpers.landmarks import without_key_points
from helpers.two_rooms import ROOMS, two_rooms, with_session_apart

from lexis.errors import LexisError, MapError
from lexis.files.replace import write_contents
from lexis.map.export import export_map
from lexis.maths.se3 import transform


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("ros") / "maps"
    export_map(two_rooms(np.random.default_rng(3)), "ros", folder)
    return folder


def state(folder, x, y):
    """What map_server says of a place, by the rules of its mode trinary."""
    header = yaml.safe_load((folder / "floor0.yaml").read_text())
    assert header["mode"] == "trinary" and header["negate"] == 0
    image = cv2.imread(str(folder / header["image"]), cv2.IMREAD_GRAYSCALE)
    column = int((x - header["origin"][0]) / header["resolution"])
    row = len(image) - 1 - int((y - header["origin"][1]) / header["resolution"])
    occupancy = (255 - int(image[row, column])) / 255.0
    if occupancy > header["occupied_thresh"]:
        return "occupied"
    return "free" if occupancy < header["free_thresh"] else "unknown"


@pytest.mark.parametrize(
    ("place", "meaning"),
    [((2, 3), "free"), ((4.05, 1.55), "free"), ((6, 1), "free"), ((-0.4, 2), "unknown"), ((5, 4.4), "unknown")],
)
def test_places_are_what_they_are(folder, place, meaning):
    assert state(folder, *place) == meaning


def test_the_image_is_not_mirrored(folder):
    """The door is not in the middle of the wall: at one of two places that mirror each other, the wall is closed."""
    assert state(folder, 4.05, 1.55) == "free" and state(folder, 4.05, 2.45) != "free"


def test_walls_are_occupied(folder):
    along = np.arange(0.5, 7.5, 0.1)
    for wall_y in (0.0, 4.0):
        found = [{state(folder, x, wall_y + d) for d in (-0.05, 0.05)} for x in along]
        assert np.mean(["occupied" in states for states in found]) > 0.9


def test_rooms_lie_beside_the_grids(folder):
    storeys = json.loads((folder / "storeys.json").read_text())
    assert [(storey["floor"], storey["map"], storey["rooms"]) for storey in storeys] == [
        (0, "floor0.yaml", "floor0.geojson")
    ]
    rooms = json.loads((folder / "floor0.geojson").read_text())["features"]
    assert [room["properties"]["name"] for room in rooms] == ["kitchen", "office"]
    for room in rooms:
        polygon, true = shapely.geometry.shape(room["geometry"]), shapely.box(*ROOMS[room["properties"]["label"]])
        assert polygon.intersection(true).area / polygon.union(true).area > 0.85


def test_a_session_that_shares_no_frame_with_the_first_has_grids_of_its_own(folder, tmp_path):
    shift = [24.0, 0.0, 3.0]
    export_map(with_session_apart(two_rooms(np.random.default_rng(3)), shift), "ros", tmp_path / "maps")
    first, second = json.loads((tmp_path / "maps/storeys.json").read_text())
    assert [(one["floor"], one["session"], one["map"]) for one in (first, second)] == [
        (0, 0, "floor0.yaml"),
        (0, 1, "floor0-session1.yaml"),
    ]
    assert second["floor_m"] == pytest.approx(first["floor_m"] + 3.0)
    rooms = [json.loads((tmp_path / "maps" / one["rooms"]).read_text())["features"] for one in (first, second)]
    assert [[room["properties"]["id"] for room in part] for part in rooms] == [[0, 1], [3, 4]]


def test_an_earlier_folder_is_replaced_and_anything_else_is_left_alone(folder, tmp_path):
    written = {path.name for path in folder.iterdir()}
    (folder / "floor1.pgm").write_bytes(b"of an earlier map")
    write_contents(folder)
    export_map(two_rooms(np.random.default_rng(3)), "ros", folder)
    assert {path.name for path in folder.iterdir()} == written
    (tmp_path / "thesis").mkdir()
    (tmp_path / "thesis" / "chapter1.tex").write_text("years of work")
    with pytest.raises(LexisError, match=r"holds no storeys\.json"):
        export_map(two_rooms(np.random.default_rng(3)), "ros", tmp_path / "thesis")
    assert [path.read_text() for path in (tmp_path / "thesis").iterdir()] == ["years of work"]


def test_a_map_of_stairs_alone_has_no_grid(tmp_path):
    whole = two_rooms(np.random.default_rng(3))
    whole.floors[:] = -1
    with pytest.raises(MapError, match="only stairs"):
        export_map(whole, "ros", tmp_path / "maps")


def test_a_place_that_cameras_only_look_over_is_not_free(folder, tmp_path):
    """Without landmarks near the floor, every line of sight passes above tables. The path of the camera stays free."""
    seen = two_rooms(np.random.default_rng(3))
    over = tuple(
        replace(each, landmarks=without_key_points(kept))
        for each, T_W_B in zip(seen.keyframes, seen.T_W_B, strict=True)
        for points in (each.landmarks.points,)
        for height in (transform(T_W_B, points)[:, 2],)
        for kept in (points[(height > 1.0) | (height < 0.1) & (each.id < 2)],)
    )
    export_map(replace(seen, keyframes=over), "ros", tmp_path / "over")
    assert state(folder, 6.0, 1.0) == "free" and state(tmp_path / "over", 6.0, 1.0) == "unknown"
    assert state(tmp_path / "over", 6.0, 2.0) == "free"
