"""Laws of furnished rooms, checked with shapely, which the placer does not use."""

import math
from itertools import combinations
from zlib import crc32

import numpy as np
import pytest
from shapely import affinity
from shapely.geometry import LineString, Point, Polygon, box
from shapely.ops import unary_union

from worlds.furniture.placement import furnish, is_solid, parts_of
from worlds.furniture.room_plan import FLAT_M
from worlds.furniture.ways import PASSAGE_M
from worlds.labels import ROOM_LABELS, STAIRS
from worlds.presets import sample_house
from worlds.spec import OpeningSpec, RoomSpec, StoreySpec

BODY_M = 0.299


def _seeded(seed):
    """A generator for every room."""
    return lambda room: np.random.default_rng([seed, crc32(room.id.encode())])



def _pair(label, corners, door=((0.0, 0.6), (0.0, 1.5)), kind="door"):
    """A room and a corridor west of it."""
    room = RoomSpec(id="room", label=label, polygon_m=corners)
    corridor = RoomSpec(id="hall", label="corridor", polygon_m=((-1.5, 0.0), (0.0, 0.0), (0.0, 4.0), (-1.5, 4.0)))
    return StoreySpec(
        rooms=(room, corridor), openings=(OpeningSpec(rooms=("room", "hall"), kind=kind, start_m=door[0], end_m=door[1]),)
    )


def _rectangle(width, depth):
    return (0.0, 0.0), (width, 0.0), (width, depth), (0.0, depth)


L_SHAPE = ((0.0, 0.0), (5.0, 0.0), (5.0, 2.4), (2.6, 2.4), (2.6, 4.0), (0.0, 4.0))
STOREYS = {
    f"{label} {w} x {d}": _pair(label, _rectangle(w, d)) for label, w, d in [(label, 4.2, 4.0) for label in ROOM_LABELS]
}
STOREYS |= {f"small {label}": _pair(label, _rectangle(1.2, 1.8)) for label in ("toilet", "storage room", "pantry")}
STOREYS |= {f"L-shaped {label}": _pair(label, L_SHAPE) for label in ("living room", "kitchen", "office", "bedroom")}
STOREYS |= {"open plan": _pair("living room", _rectangle(5.0, 4.0), ((0.0, 0.0), (0.0, 4.0)), "open")}
STOREYS |= {
    f"{preset} {seed}.{level}": storey
    for preset in ("home", "ori", "uh2-apt")
    for seed in (1, 2)
    for level, storey in enumerate(sample_house(preset, seed).storeys)
}


@pytest.fixture(params=STOREYS, scope="module")
def furnished(request):
    storey = STOREYS[request.param]
    return storey, furnish(storey, _seeded(5), 1.5)


def _footprint(piece):
    (x, y, _), (w, d, _) = piece.position_m, piece.size_m
    return affinity.rotate(box(x - w / 2, y - d / 2, x + w / 2, y + d / 2), piece.yaw_rad, origin=(x, y), use_radians=True)


def _rooms(storey, pieces):
    for room in storey.rooms:
        yield room, Polygon(room.polygon_m), [piece for piece in pieces if piece.room == room.id]


def _heights(piece):
    return piece.position_m[2], piece.position_m[2] + piece.size_m[2]


def test_pieces_stand_inside_their_room_and_below_its_ceiling(furnished):
    storey, pieces = furnished
    for _, polygon, inside in _rooms(storey, pieces):
        clear = polygon.buffer(-0.05, join_style="mitre")
        for piece in inside:
            assert clear.contains(_footprint(piece)), piece
            assert _heights(piece)[1] <= storey.height_m + 1e-6, piece


def test_solid_pieces_are_apart_in_plan_and_all_pieces_in_space(furnished):
    storey, pieces = furnished
    for _, _, inside in _rooms(storey, pieces):
        upright = [(piece, _footprint(piece)) for piece in inside if _heights(piece)[1] > FLAT_M]
        for (a, plan_a), (b, plan_b) in combinations(upright, 2):
            (low_a, high_a), (low_b, high_b) = _heights(a), _heights(b)
            in_the_way = is_solid(a.kind) and is_solid(b.kind)
            if in_the_way or min(high_a, high_b) > max(low_a, low_b) + 1e-3:
                assert plan_a.intersection(plan_b).area < 1e-3 * min(plan_a.area, plan_b.area), (a.id, b.id)


def test_openings_are_clear(furnished):
    storey, pieces = furnished
    for opening in storey.openings:
        line = LineString([opening.start_m, opening.end_m])
        zone = line.buffer(0.9 - 1e-3, cap_style="flat")
        for piece in pieces:
            if piece.room in opening.rooms:
                footprint = _footprint(piece)
                assert footprint.distance(line) > 0.05 or _heights(piece)[1] <= FLAT_M, f"{piece.id} stands in an opening"
                if opening.width_m <= PASSAGE_M and is_solid(piece.kind):
                    assert footprint.intersection(zone).area < 1e-3, f"{piece.id} is in the way"


def test_a_body_gets_from_opening_to_opening_and_about_the_room(furnished):
    storey, pieces = furnished
    for room, polygon, inside in _rooms(storey, pieces):
        solids = unary_union([_footprint(piece).buffer(BODY_M) for piece in inside if is_solid(piece.kind)])
        free = polygon.buffer(-0.05 - BODY_M, join_style="mitre").difference(solids)
        regions = list(getattr(free, "geoms", [free]))
        doors = [LineString([o.start_m, o.end_m]).buffer(0.6) for o in storey.openings if room.id in o.rooms]
        through = [region for region in regions if all(region.intersects(door) for door in doors)]
        covered = max((region.buffer(BODY_M).area for region in through), default=0.0)
        assert covered >= 0.35 * polygon.area, f"{room.id}: a body covers {covered:.1f} of {polygon.area:.1f} m²"


def test_solid_pieces_are_square_to_the_walls(furnished):
    _, pieces = furnished
    for piece in pieces:
        quarters = piece.yaw_rad / (math.pi / 2)
        assert not is_solid(piece.kind) or abs(quarters - round(quarters)) < 1e-9


def test_pieces_have_parts_and_unique_names(furnished):
    storey, pieces = furnished
    assert len({piece.id for piece in pieces}) == len(pieces)
    assert all(parts_of(piece) == parts_of(piece) != () for piece in pieces)
    assert not [piece for room, _, inside in _rooms(storey, pieces) if room.label == STAIRS for piece in inside]


def test_furnishing_is_deterministic_and_prefixes_names():
    storey = STOREYS["kitchen 4.2 x 4.0"]
    first, second = (furnish(storey, _seeded(1), prefix="7") for _ in range(2))
    assert first == second != furnish(storey, _seeded(2), prefix="7")
    assert all(piece.id.startswith("7") for piece in first)


def test_clutter_scales_what_lies_about():
    storeys = [STOREYS[f"{label} 4.2 x 4.0"] for label in ("kitchen", "garage", "children's room")]

    def count(clutter):
        return sum(len(furnish(storey, _seeded(seed), clutter)) for storey in storeys for seed in range(3))

    assert count(0.0) == 0 < count(0.5) < count(1.0) < count(2.5)


@pytest.mark.parametrize(
    ("label", "kinds"),
    [
        ("kitchen", {"fridge", "stove", "kitchen sink", "kitchen counter"}),
        ("bathroom", {"bathtub", "toilet bowl", "washbasin"}),
        ("bedroom", {"double bed", "wardrobe"}),
        ("living room", {"sofa", "tv stand"}),
        ("dining room", {"dining table", "dining chair"}),
        ("office", {"desk", "office chair"}),
        ("garage", {"workbench"}),
    ],
)
def test_rooms_nearly_always_hold_what_makes_them(label, kinds):
    rooms = [
        {
            piece.kind
            for piece in furnish(_pair(label, _rectangle(4.2, 4.0)), _seeded(s))
            if piece.room == "room"
        }
        for s in range(12)
    ]
    for kind in kinds:
        assert sum(kind in room for room in rooms) >= 9, kind


def test_chairs_face_their_table():
    pieces = furnish(_pair("dining room", _rectangle(5.0, 4.0)), _seeded(0))
    table = next(piece for piece in pieces if piece.kind == "dining table")
    for chair in (piece for piece in pieces if piece.kind == "dining chair"):
        x, y, _ = chair.position_m
        ahead = Point(x - 0.5 * math.sin(chair.yaw_rad), y + 0.5 * math.cos(chair.yaw_rad))
        assert _footprint(table).contains(ahead)
