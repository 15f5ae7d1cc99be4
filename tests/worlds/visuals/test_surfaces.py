"""The visible shell is the complete boundary of everything solid, and no two faces share a place in a texture."""

from collections import defaultdict

import numpy as np
import pytest
import shapely
from helpers.opening_rooms import LENGTH_M, ROOMS, WALL_X, every_kind

from worlds.house import build_house
from worlds.labels import STAIRS
from worlds.presets import sample_house
from worlds.spec import RoomSpec
from worlds.visuals.surfaces import OUTSIDE, surfaces
from worlds.walls import WALL_THICKNESS_M, arch_curve

HALF = WALL_THICKNESS_M / 2


@pytest.fixture(scope="module", params=["home", "uh2-apt", "ori", "every kind"])
def house(request):
    return build_house(every_kind() if request.param == "every kind" else sample_house(request.param, 4))


@pytest.fixture(scope="module")
def faces(house):
    return surfaces(house)


def is_solid(house, points):
    """Whether points lie in walls or slabs, computed from walls, arches and polygons and not from the faces."""
    boxes = [(*wall.bounds, wall.bottom_m, wall.top_m) for wall in house.walls if not wall.spandrel]
    solid = inside(points, boxes)
    for wall in (wall for wall in house.walls if wall.spandrel):
        opening = next(o for b, o in house.boundaries[wall.storey] if b is wall.boundary)
        curve = np.array(arch_curve(wall.boundary, opening, np.inf))
        bottom = house.storeys[wall.storey].floor_m + np.interp(points[:, wall.boundary.axis], *curve.T)
        solid |= inside(points, [(*wall.bounds, wall.bottom_m, wall.top_m)]) & (points[:, 2] > bottom)
    tops = [*(storey.floor_m for storey in house.storeys), house.storeys[-1].ceiling_m + house.spec.slab_m]
    for level, top in enumerate(tops):
        bottom = top - house.spec.slab_m
        below, above = (house.spec.storeys[k].rooms if 0 <= k < len(house.storeys) else () for k in (level - 1, level))
        under = [r.id for r in below if not house.room_by_id[r.id].outdoor] + [r.id for r in above]
        wells = [r for r in house.rooms if r.label == STAIRS and r.floor_m < bottom < top < r.ceiling_m]
        plan = shapely.union_all([house.room_by_id[name].polygon for name in under])
        plan = plan.difference(shapely.union_all([well.polygon for well in wells]))
        walls = [b for b in boxes if np.isclose(b[5], bottom) or np.isclose(b[4], top)]
        slab = (bottom < points[:, 2]) & (points[:, 2] < top)
        solid[slab] |= shapely.contains_xy(plan, points[slab, :2]) | inside(
            points[slab], [(*wall[:4], bottom, top) for wall in walls]
        )
    return solid


def inside(points, boxes):
    """Whether points lie in one of the boxes (x0, y0, x1, y1, z0, z1)."""
    table = np.array(boxes).reshape(-1, 6)
    low, high = table[:, [0, 1, 4]], table[:, [2, 3, 5]]
    return ((low < points[:, None]) & (points[:, None] < high)).all(axis=2).any(axis=1)


def normals_and_areas(faces):
    corners = np.array([face.corners for face in faces])
    crossed = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    length = np.linalg.norm(crossed, axis=1)
    return crossed / length[:, None], length / 2


def test_faces_part_solid_from_free(house, faces, rng):
    normals, _ = normals_and_areas(faces)
    weights = rng.dirichlet(np.ones(4), len(faces))
    places = np.einsum("fc,fck->fk", weights, np.array([face.corners for face in faces]))
    assert is_solid(house, places - 1e-5 * normals).all()
    assert not is_solid(house, places + 1e-5 * normals).any()


def test_the_first_face_on_a_ray_is_where_the_solid_begins(house, faces, rng):
    """Rays from anywhere in a room in any direction show that no face is missing and that none floats."""
    rooms = [room for room in house.rooms if not room.outdoor]
    starts, ways = [], rng.normal(size=(100, 3))
    while len(starts) < len(ways):
        room = rooms[int(rng.integers(len(rooms)))]
        x0, y0, x1, y1 = room.polygon.bounds
        point = rng.uniform((x0, y0, room.floor_m), (x1, y1, room.ceiling_m))
        if room.polygon.contains(shapely.Point(point)) and not is_solid(house, point[None])[0]:
            starts.append(point)
    starts, ways = np.array(starts), ways / np.linalg.norm(ways, axis=1, keepdims=True)
    reach, front = first_hits(np.array([face.corners for face in faces]), starts, ways)
    met = np.isfinite(reach)
    assert front[met].all()
    assert met.mean() > 0.9
    assert is_solid(house, starts[met] + ways[met] * (reach[met, None] + 1e-6)).all()
    before = np.linspace(0.0, 1.0, 30)[:, None, None] * (np.where(met, reach, 20.0) - 1e-6)[:, None]
    assert not is_solid(house, (starts + ways * before).reshape(-1, 3)).any()


@pytest.mark.parametrize("kind", ["door", "cased", "arch", "half wall", "counter", "open"])
def test_an_opening_ends_below_and_above_where_its_kind_says(kind, rng):
    house = build_house(every_kind())
    boundary, opening = next((b, o) for b, o in house.boundaries[0] if o is not None and (o.kind, o.rooms) == (kind, ROOMS))
    low, high = opening.gap_m(2.6)
    y = rng.uniform(boundary.low, boundary.high, 40)
    starts = np.column_stack([rng.uniform(-HALF, HALF, 40) + WALL_X, y, np.full(40, max(low, 1.0) + 0.3)])
    quads = np.array([face.corners for face in surfaces(house)])
    top = np.interp(y, *np.array(arch_curve(boundary, opening, high)).T) if kind == "arch" else high
    for up, expected in ((1.0, top - starts[:, 2]), (-1.0, starts[:, 2] - low)):
        reach, front = first_hits(quads, starts, np.tile([0.0, 0.0, up], (40, 1)))
        assert front.all()
        np.testing.assert_allclose(reach, expected, atol=1e-6)


def first_hits(quads, starts, ways):
    """The distance to the first face on each ray (inf if there is none), and whether its front is hit."""
    triangles = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    a, b, c = (triangles[:, k] for k in range(3))
    normal = np.cross(b - a, c - a)
    with np.errstate(divide="ignore", invalid="ignore"):
        facing = ways @ normal.T
        t = (np.einsum("tk,tk->t", a, normal) - starts @ normal.T) / facing
        hit = starts[:, None] + t[..., None] * ways[:, None]
        inside = np.isfinite(t) & (t > 0.0)
        for p, q in ((a, b), (b, c), (c, a)):
            inside &= np.einsum("rtk,tk->rt", np.cross(q - p, hit - p), normal) >= -1e-9
    t = np.where(inside, t, np.inf)
    first = t.argmin(axis=1)
    rows = np.arange(len(ways))
    return t[rows, first], facing[rows, first] < 0.0


@pytest.mark.parametrize(("room", "plane", "side"), [("kitchen", WALL_X - HALF, -1), ("living room", WALL_X + HALF, 1)])
def test_wall_and_gaps_make_up_the_whole_boundary(room, plane, side):
    house = build_house(every_kind())
    faces = [face for face in surfaces(house) if face.room == room and np.allclose(face.corners[:, 0], plane)]
    normals, areas = normals_and_areas(faces)
    assert (np.sign(normals[:, 0]) == side).all()
    gaps = 0.0
    for opening in house.spec.storeys[0].openings[:6]:
        low, high = opening.gap_m(2.6)
        gaps += opening.width_m * (high - low)
        if opening.kind == "arch":
            (boundary,) = (b for b, o in house.boundaries[0] if o is opening)
            curve = np.array(arch_curve(boundary, opening, high))
            gaps -= opening.width_m * high - np.trapezoid(curve[:, 1], curve[:, 0])
    assert areas.sum() + gaps == pytest.approx((LENGTH_M - WALL_THICKNESS_M) * 2.6)


def test_floor_faces_are_what_walls_leave_of_the_rooms(house, faces):
    area = defaultdict(float)
    for face, size in zip(faces, normals_and_areas(faces)[1], strict=True):
        if face.kind == "floor":
            area[face.room] += size
    for room in house.rooms:
        floor = house.storeys[room.storey].floor_m
        walls = shapely.union_all([w.footprint for w in house.walls if w.storey == room.storey and w.bottom_m == floor])
        assert area[room.id] == pytest.approx(room.polygon.difference(walls).area)


def test_no_room_is_taken_for_the_outside():
    with pytest.raises(ValueError, match="pattern"):
        RoomSpec(id=OUTSIDE, label="kitchen", polygon_m=((0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (0.0, 4.0)))


def test_faces_keep_their_size_and_shape_on_their_sheet(faces):
    for face in faces:
        for a, b in ((0, 1), (1, 2), (2, 3), (3, 0), (0, 2), (1, 3)):
            in_space, on_sheet = (np.linalg.norm(points[a] - points[b]) for points in (face.corners, face.uv))
            assert on_sheet == pytest.approx(in_space, abs=1e-9)


def test_faces_share_no_place_on_their_sheet(faces):
    sheets = defaultdict(list)
    for face in faces:
        assert face.uv.min() >= -1e-9
        sheets[face.room, face.kind].append((*face.uv.min(axis=0), *face.uv.max(axis=0)))
    for places in sheets.values():
        u0, v0, u1, v1 = np.array(places).T
        overlap = (np.minimum(u1[:, None], u1) - np.maximum(u0[:, None], u0) > 1e-9) & (
            np.minimum(v1[:, None], v1) - np.maximum(v0[:, None], v0) > 1e-9
        )
        assert np.array_equal(overlap, np.eye(len(places), dtype=bool))
