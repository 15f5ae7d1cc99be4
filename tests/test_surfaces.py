"""The visible shell: it closes every room, faces inwards and never uses a place of a texture twice."""

from collections import defaultdict

import numpy as np
import pytest

from worlds.house import build_house
from worlds.presets import sample_house
from worlds.spec import RoomSpec
from worlds.surfaces import OUTSIDE, rectangles, surfaces
from worlds.walls import WALL_THICKNESS_M


@pytest.fixture(scope="module", params=["home", "uh2-apt", "random"])
def house(request):
    return build_house(sample_house(request.param, 4))


def test_floor_faces_tile_the_rooms(house):
    area = defaultdict(float)
    for face in surfaces(house):
        if face.kind == "floor":
            area[face.room] += np.linalg.norm(np.cross(face.corners[1] - face.corners[0], face.corners[3] - face.corners[0]))
    for room in house.rooms:
        assert area[room.id] == pytest.approx(room.polygon.area)
        assert sum((x1 - x0) * (y1 - y0) for x0, y0, x1, y1 in rectangles(room.polygon)) == pytest.approx(room.polygon.area)


def test_no_room_is_taken_for_the_outside():
    with pytest.raises(ValueError, match="pattern"):
        RoomSpec(id=OUTSIDE, label="kitchen", polygon_m=((0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (0.0, 4.0)))


def test_faces_look_into_their_room(house):
    rooms = {room.id: room for room in house.rooms}
    for face in surfaces(house):
        across, up = face.corners[1] - face.corners[0], face.corners[3] - face.corners[0]
        normal = np.cross(across, up)
        normal /= np.linalg.norm(normal)
        centre = face.corners.mean(axis=0)
        if face.room == OUTSIDE or min(np.linalg.norm(across), np.linalg.norm(up)) < WALL_THICKNESS_M + 1e-9:
            continue  # reveals belong to an opening, not to a side
        seen_from = centre + 0.06 * normal
        x0, y0, x1, y1 = rooms[face.room].polygon.bounds
        assert x0 < seen_from[0] < x1 and y0 < seen_from[1] < y1


def test_faces_share_no_place_on_their_sheet_and_keep_their_size(house):
    sheets = defaultdict(list)
    for face in surfaces(house):
        size = np.ptp(face.uv, axis=0)
        edges = np.linalg.norm(face.corners[1] - face.corners[0]), np.linalg.norm(face.corners[3] - face.corners[0])
        assert size == pytest.approx(edges, abs=1e-9) or size == pytest.approx(edges[::-1], abs=1e-9)
        sheets[face.room, face.kind].append((*face.uv.min(axis=0), *face.uv.max(axis=0)))
    for faces in sheets.values():
        u0, v0, u1, v1 = np.array(faces).T
        overlap = (np.minimum(u1[:, None], u1) - np.maximum(u0[:, None], u0) > 1e-9) & (
            np.minimum(v1[:, None], v1) - np.maximum(v0[:, None], v0) > 1e-9
        )
        assert np.array_equal(overlap, np.eye(len(faces), dtype=bool))
