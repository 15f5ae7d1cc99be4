"""Drawings of floor plans: SVG and PNG show the same, with the right orientation, and agree with the house's geometry."""

import re
from dataclasses import replace

import cv2
import numpy as np
import pytest
from helpers.opening_rooms import every_kind
from PIL import ImageColor
from shapely.geometry import LineString, Point, Polygon, box
from shapely.ops import unary_union

from sim.errors import SimError
from sim.report.data import FloorPlan, PlannedOpening, PlannedRoom
from sim.report.drawing import STYLES, Drawing, Mark
from sim.report.house_plan import floor_plans, plan_png, plan_svg
from sim.report.palette import label_colours
from sim.report.plan import plan_drawing
from sim.report.png import to_image
from sim.report.rulers import with_rulers
from sim.report.svg import to_svg
from sim.report.symbols import NAMES, opening_marks
from worlds.house import build_house
from worlds.labels import ROOM_LABELS
from worlds.presets import sample_house
from worlds.variant import variant

COLOURS = {"kitchen": "#ff0000", "office": "#0000ff"}


@pytest.fixture
def plan() -> FloorPlan:
    """The plan of a kitchen and of an office north of it."""
    kitchen = np.array([[0.0, 0.0], [5.0, 0.0], [5.0, 4.0], [0.0, 4.0]])
    return FloorPlan(0, 0.0, (PlannedRoom("k", "kitchen", kitchen), PlannedRoom("o", "office", kitchen + np.array([0, 4]))))


def test_north_is_up_and_metres_are_where_they_should_be(plan):
    drawing = plan_drawing(plan, COLOURS)
    image = to_image(drawing, pixels_per_metre=40)
    assert image.shape[:2] == pytest.approx(tuple((drawing.high - drawing.low)[::-1] * 40), abs=1)

    def pixel(x: float, y: float) -> np.ndarray:
        column, row = (np.array([x, y]) - [drawing.low[0], drawing.high[1]]) * [40, -40]
        return image[int(row), int(column)].astype(int)

    red, blue = pixel(2.5, 1.0), pixel(2.5, 5.0)
    assert red[0] > red[2] + 30
    assert blue[2] > blue[0] + 30
    assert (pixel(5.3, 5.0) == 255).all()


def test_the_scale_bar_and_the_legend_fit_beside_the_smallest_room():
    cupboard = PlannedRoom("c", "kitchen", np.array([[0.0, 0.0], [0.9, 0.0], [0.9, 0.9], [0.0, 0.9]]))
    opening = PlannedOpening("door", np.array([[0.0, 0.0], [0.8, 0.0]]))
    drawing = plan_drawing(FloorPlan(0, 0.0, (cupboard,), openings=(opening,)), COLOURS)
    rightmost = drawing.low.max()
    for mark in drawing.marks:
        text_m = 0.58 * mark.size * len(mark.text) if mark.kind == "text" else 0.0
        rightmost = max(rightmost, float(mark.points[:, 0].max()) + text_m)
    assert rightmost <= drawing.high[0]


def test_rulers_state_the_coordinates_of_what_is_beside_them():
    room = PlannedRoom("r", "kitchen", np.array([[-3.5, -12.0], [4.5, -12.0], [4.5, 2.0], [-3.5, 2.0]]))
    plan = FloorPlan(0, 0.0, (room,))
    before = plan_drawing(plan, COLOURS)
    drawing = with_rulers(before, plan)
    added = drawing.marks[len(before.marks) :]
    middles = [(m.text, *(m.points[0] + [0.58 * m.size * len(m.text) / 2, 0.0])) for m in added if m.kind == "text"]
    above = [(float(text), x) for text, x, y in middles if y > 2.0]
    beside = [(float(text), y) for text, x, y in middles if x < -3.5]
    assert above == [(n, pytest.approx(n)) for n in range(-2, 5, 2)]
    assert beside == [(n, pytest.approx(n)) for n in range(-12, 3, 2)]
    assert sum(mark.kind == "line" for mark in added) == len(range(-3, 5)) + len(range(-12, 3))
    for mark in added:
        assert (drawing.low <= mark.points).all() and (mark.points <= drawing.high).all()


def test_letters_are_as_high_as_asked_for_where_they_fit(plan):
    usual, larger = (plan_drawing(plan, COLOURS, letter_m=metres) for metres in (0.26, 0.5))
    for before, after in zip(*([m for m in d.marks if m.kind == "text"] for d in (usual, larger)), strict=True):
        assert before.text == after.text and before.size < after.size <= 0.5


def test_a_lift_has_a_cross_on_every_storey():
    house = build_house(variant(sample_house("home", 100), climb="lift"))
    shafts = [Polygon(room.polygon_m) for storey in house.spec.storeys for room in storey.rooms if room.climb == "lift"]
    crosses = [unary_union([Polygon(outline) for outline in plan.treads]) for plan in floor_plans(house)]
    assert len(shafts) == len(crosses) == 2
    for shaft, cross in zip(shafts, crosses, strict=True):
        assert shaft.contains(cross) and 0.8 * shaft.area < cross.area


def test_svg_and_png_span_the_same_part_of_the_plan(plan):
    drawing = plan_drawing(plan, COLOURS)
    x, y, width, height = map(float, re.search(r'viewBox="([^"]*)"', to_svg(drawing)).group(1).split())
    np.testing.assert_allclose([x, -y - height], drawing.low, atol=0.011)
    np.testing.assert_allclose([x + width, -y], drawing.high, atol=0.011)


def test_marks_widen_a_drawing_but_only_so_far(plan):
    drawing = plan_drawing(plan, COLOURS)
    wider = drawing.with_marks([Mark("line", "odometry", np.array([[2.0, 2.0], [90.0, 2.0]]))], reach_m=1.5)
    np.testing.assert_allclose(wider.high - drawing.high, [1.5, 0])
    np.testing.assert_allclose(wider.low, drawing.low)


def test_nothing_is_painted_over_wrong_keyframes_and_the_camera_hides_no_estimate():
    order = list(STYLES)
    assert order[-1] == "wrong" and order.index("camera") < order.index("wrong-estimate") < order.index("estimate")
    assert STYLES["camera"].radius > STYLES["wrong-estimate"].radius


def test_labels_have_colours_of_their_own():
    colours = label_colours(ROOM_LABELS)
    assert len(set(colours.values())) == len(ROOM_LABELS)
    assert label_colours(reversed(ROOM_LABELS)) == colours
    assert all(label_colours([label])[label] == colours[label] for label in ROOM_LABELS)


def test_the_floors_of_stairs_and_corridors_which_meet_in_most_houses_differ_clearly():
    colours = label_colours(("stairs", "corridor"))
    a, b = (np.array(ImageColor.getrgb(colour)) * STYLES["room"].fill_opacity for colour in colours.values())
    assert np.abs(a - b).max() > 20


def test_a_storey_without_rooms_is_refused():
    with pytest.raises(SimError, match="storey 2"):
        plan_drawing(FloorPlan(2, 6.0, ()), COLOURS)


def test_the_picture_of_a_house_holds_every_storey():
    house = build_house(sample_house("home", 3))
    picture = cv2.imdecode(np.frombuffer(plan_png(house), np.uint8), cv2.IMREAD_COLOR)
    widths = [np.ptp(np.concatenate([room.outline for room in plan.rooms])[:, 0]) for plan in floor_plans(house)]
    assert picture.shape[1] > 60 * sum(widths)


def test_a_house_is_drawn_as_it_is_built():
    house = build_house(sample_house("home", 3))
    plans = floor_plans(house)
    assert [plan.floor_m for plan in plans] == [storey.floor_m for storey in house.storeys]
    for level, plan in enumerate(plans):
        area = sum(Polygon(room.polygon_m).area for room in house.spec.storeys[level].rooms)
        assert unary_union([Polygon(room.outline) for room in plan.rooms]).area == pytest.approx(area)
        walls = unary_union([Polygon(outline) for outline in plan.walls])
        assert plan.openings
        assert not any(walls.contains(Point(opening.ends.mean(axis=0))) for opening in plan.openings)


def plan_of_every_opening():
    """Return the plan of a house with all kinds of openings; the garden's door has a leaf, and the other door has none."""
    plan = floor_plans(build_house(every_kind()))[0]
    first = next(i for i, opening in enumerate(plan.openings) if opening.kind == "door")
    openings = tuple(replace(opening, has_leaf=opening.has_leaf and i != first) for i, opening in enumerate(plan.openings))
    return replace(plan, openings=openings, leaves=plan.leaves[1:])


def test_every_kind_of_opening_has_a_symbol_of_its_own_and_is_named():
    plan = plan_of_every_opening()
    symbols = {o.kind: sorted((mark.kind, mark.style) for mark in opening_marks(o)) for o in plan.openings}
    assert set(symbols) == set(NAMES)
    assert len({tuple(symbol) for symbol in symbols.values()}) == len(NAMES)
    drawing = plan_drawing(plan, label_colours(ROOM_LABELS))
    svg = to_svg(drawing)
    for name in (*NAMES.values(), "window", "door leaf"):
        assert f"<title>{name}</title>" in svg
    told = [mark.text for mark in drawing.marks if mark.kind == "text"]
    assert {*NAMES.values(), "window"} <= set(told)
    assert all((drawing.low <= mark.points).all() and (mark.points <= drawing.high).all() for mark in drawing.marks)


def test_the_switch_for_the_names_of_rooms_leaves_the_legend_and_the_scale():
    plan = plan_of_every_opening()
    marks = plan_drawing(plan, label_colours(ROOM_LABELS)).marks
    said = " ".join(f"{room.name} ({room.label})" for room in plan.rooms)
    assert all(mark.text in said for mark in marks if mark.style == "name")
    notes = {mark.text for mark in marks if mark.kind == "text" and mark.style != "name"}
    assert notes == {"2 m", *NAMES.values(), "window", "door with a leaf"}


def test_the_legend_names_doors_with_a_leaf_where_there_are_any():
    plan = floor_plans(build_house(every_kind()))[0]
    assert plan.leaves
    for drawn in (plan, replace(plan, leaves=())):
        marks = plan_drawing(drawn, label_colours(ROOM_LABELS)).marks
        assert ("door with a leaf" in [mark.text for mark in marks]) == bool(drawn.leaves)
        assert len([mark for mark in marks if mark.style == "swing"]) == len(drawn.leaves) + bool(drawn.leaves)


def test_the_legend_names_doorways_only_where_one_has_no_leaf():
    all_with_leaves = floor_plans(build_house(every_kind()))[0]
    for drawn, is_named in ((plan_of_every_opening(), True), (all_with_leaves, False)):
        marks = plan_drawing(drawn, label_colours(ROOM_LABELS)).marks
        assert (NAMES["door"] in [mark.text for mark in marks if mark.kind == "text"]) == is_named


@pytest.mark.parametrize("climb", [None, "spiral"])
def test_an_arrow_leads_up_the_stairs_inside_their_room_on_both_storeys(climb):
    house = build_house(variant(sample_house("home", 7), climb=climb))
    (stairs,), plans = house.stairs, floor_plans(house)
    cell = house.room_by_id[stairs.room].polygon.buffer(1e-6)
    for plan in plans:
        (path,) = plan.climbs
        assert cell.contains(LineString(path))
        assert {*map(tuple, stairs.walking_line[1:-1, :2])} <= {*map(tuple, path)}
        line, head = (mark.points for mark in plan_drawing(plan, label_colours(ROOM_LABELS)).marks if mark.style == "climb")
        np.testing.assert_array_equal(line, path)
        np.testing.assert_array_equal(head[1], path[-1])
        assert np.linalg.norm(head - head[1], axis=1).max() < 0.3


def test_titles_tell_the_storeys_of_a_house_apart():
    for storeys, expected in ((2, ["0", "1"]), (1, [])):
        svg = plan_svg(build_house(sample_house("home", 7, storeys=storeys)))
        assert re.findall(r">storey (\d), floor at [\d.]+ m</text>", svg) == expected


def test_leaves_windows_and_fences_are_the_houses():
    house = build_house(every_kind())
    plan = floor_plans(house)[0]
    assert len(plan.leaves) == len(house.leaves) == 2
    assert len(plan.windows) == len(house.windows) > 0
    fences = unary_union([Polygon(outline) for outline in plan.fences])
    assert not any(fences.contains(Point(opening.ends.mean(axis=0))) for opening in plan.openings)


def test_dashes_leave_white_between_them():
    line = np.array([[0.0, 0.5], [2.0, 0.5]])
    drawn = to_image(Drawing([Mark("line", "open", line)], np.zeros(2), np.array([2.0, 1.0])), pixels_per_metre=100)[
        50, 5:-5
    ]
    on, off = STYLES["open"].dash
    assert (drawn < 128).any(axis=1).mean() == pytest.approx(on / (on + off), abs=0.1)


@pytest.mark.parametrize(("preset", "seed"), [("office", 610), ("school", 611), ("random", 611)])
def test_names_stand_in_their_rooms(preset, seed):
    house = build_house(sample_house(preset, seed, clutter=0.0))
    for plan in floor_plans(house):
        rooms = [Polygon(room.outline) for room in plan.rooms]
        south = min(room.bounds[1] for room in rooms)  # the legend and the scale are south of it
        marks = plan_drawing(plan, label_colours(ROOM_LABELS)).marks
        names = [mark for mark in marks if mark.style == "name" and mark.points[0, 1] > south]
        assert len(names) >= len(rooms)
        for mark in names:
            (x, y), width = mark.points[0], 0.55 * mark.size * len(mark.text)
            (room,) = [room for room in rooms if room.contains(Point(x, y))]
            assert room.contains(box(x, y - 0.2 * mark.size, x + width, y + 0.4 * mark.size)), mark.text


def test_lamps_under_the_ceiling_are_not_drawn_and_what_stands_below_them_is():
    house = build_house(sample_house("home", seed=3))
    hanging = [piece for piece in house.furniture if piece.kind.startswith("ceiling")]
    standing = [piece for piece in house.furniture if piece.solid]
    drawn = [Polygon(outline) for floor in floor_plans(house) for outline in floor.furniture]
    assert hanging and not any(piece.footprint.equals(outline) for piece in hanging for outline in drawn)
    assert standing and all(any(piece.footprint.equals(outline) for outline in drawn) for piece in standing)
