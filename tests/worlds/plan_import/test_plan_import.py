"""Imported plans: our own exports come back unchanged, imprecise plans are corrected, and invalid ones are refused."""

import json
import math

import numpy as np
import pytest

from worlds.errors import SpecError, WorldsError
from worlds.plan_import.drawn_plan import normalised_name
from worlds.plan_import.importer import import_plan, to_geojson
from worlds.presets import sample_from_rooms, sample_house
from worlds.variant import variant

LEFT, RIGHT = [[0, 0], [4, 0], [4, 3], [0, 3]], [[4, 0], [8, 0], [8, 3], [4, 3]]
DOOR = {"type": "Feature", "properties": {"kind": "door"}, "geometry": {"type": "Point", "coordinates": [4.1, 1.5]}}


def room(label, corners, **properties):
    ring = [*corners, corners[0]]
    return {
        "type": "Feature",
        "properties": {"label": label, **properties},
        "geometry": {"type": "Polygon", "coordinates": [ring]},
    }


def tower(*climbs):
    """Rooms for a plan with a corridor and a staircase; on each storey, the staircase has one of the given climbs."""
    cell = [[-3, 0], [0, 0], [0, 3], [-3, 3]]
    stairs = [room("stairs", cell, storey=level, climb=climb) for level, climb in enumerate(climbs)]
    return [*stairs, *(room("corridor", LEFT, storey=level) for level in range(len(climbs)))]


def written(tmp_path, *features, **beside):
    path = tmp_path / "plan.geojson"
    path.write_text(json.dumps({"type": "FeatureCollection", **beside, "features": features}))
    return path


def svg(tmp_path, body, head='data-metres-per-unit="0.01"'):
    path = tmp_path / "plan.svg"
    path.write_text(f'<svg xmlns="http://www.w3.org/2000/svg" {head}>{body}</svg>')
    return path


def refusal(path, **options):
    with pytest.raises(WorldsError) as error:
        import_plan(path, **options)
    assert str(error.value).startswith(str(path)) and "\n" not in str(error.value)
    return str(error.value)


def rooms(spec):
    return {r.id: (level, r.label, r.polygon_m) for level, storey in enumerate(spec.storeys) for r in storey.rooms}


def gaps(spec):
    return {
        (level, frozenset(o.rooms), o.kind, frozenset([o.start_m, o.end_m]), o.leaf, o.leads, o.height_m, o.sill_m)
        for level, storey in enumerate(spec.storeys)
        for o in storey.openings
    }


def corners_of(spec):
    """The corners of every room, independent of where its polygon starts."""
    return {name: (level, label, frozenset(polygon)) for name, (level, label, polygon) in rooms(spec).items()}


def climbs(spec):
    return {r.id: r.climb for storey in spec.storeys for r in storey.rooms}


def heights(spec):
    return spec.slab_m, [storey.height_m for storey in spec.storeys]


@pytest.mark.parametrize(
    ("preset", "climb", "slab_m"),
    [
        *((preset, None, 0.3) for preset in ("home", "ori", "uh2-apt", "random")),
        ("home", None, 0.5),
        ("home", "lift", 0.5),
        ("uh2-apt", "lift", 0.3),
        ("uh2-apt", "spiral", 0.25),
    ],
)
@pytest.mark.parametrize("seed", [1, 2])
def test_exported_plans_are_imported_unchanged(tmp_path, preset, climb, slab_m, seed):
    house = variant(sample_house(preset, seed), climb=climb).model_copy(update={"slab_m": slab_m})
    path = tmp_path / "plan.geojson"
    path.write_text(to_geojson(house))
    back = import_plan(path).spec
    assert corners_of(back) == corners_of(house)
    assert gaps(back) == gaps(house)
    assert climbs(back) == climbs(house)
    assert heights(back) == heights(house)


def test_a_turned_sloppy_plan_in_map_coordinates_is_put_right(tmp_path):
    rng, angle = np.random.default_rng(3), math.radians(17.0)
    turn = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])

    def sloppy(points):
        points = np.array(points) + rng.uniform(-0.015, 0.015, (len(points), 2))
        return (points @ turn.T + [451_000.0, 5_000_000.0]).tolist()

    door = {**DOOR, "geometry": {"type": "LineString", "coordinates": sloppy([[4.2, 1.0], [4.2, 1.9]])}}
    plan = import_plan(written(tmp_path, room("kitchen", sloppy(LEFT)), room("office", sloppy(RIGHT)), door))
    (storey,) = plan.spec.storeys
    sizes = [np.ptp(np.array(r.polygon_m), axis=0) for r in storey.rooms]
    assert np.allclose(sizes, [[4, 3], [4, 3]], atol=0.05)
    assert storey.openings[0].width_m == pytest.approx(0.9, abs=0.05)
    assert any("turned by -17" in note or "turned by -16.9" in note for note in plan.notes) and any(
        "moved by" in note for note in plan.notes
    )


def test_without_doors_every_room_is_reached_through_the_corridor(tmp_path):
    corridor = room("Hallway", [[0, 3], [8, 3], [8, 5], [0, 5]])
    plan = import_plan(written(tmp_path, room("kitchen", LEFT), room("office", RIGHT), corridor))
    assert [set(o.rooms) for o in plan.spec.storeys[0].openings] == [{"corridor", "kitchen"}, {"corridor", "office"}]
    assert plan.notes == (
        "no openings are drawn; added, so that every room can be reached: "
        "kitchen - corridor (door), office - corridor (door)",
    )


HALL = room("corridor", [[0, 3], [8, 3], [8, 5], [0, 5]])
IN_HALL = {**DOOR, "geometry": {"type": "Point", "coordinates": [2, 3]}}


def test_rooms_that_the_drawn_doors_do_not_reach_get_added_ones(tmp_path):
    plan = import_plan(written(tmp_path, room("kitchen", LEFT), room("office", RIGHT), HALL, IN_HALL))
    drawn, added = plan.spec.storeys[0].openings
    assert set(drawn.rooms) == {"kitchen", "corridor"} and (drawn.start_m, drawn.end_m) == ((1.55, 3.0), (2.45, 3.0))
    assert set(added.rooms) == {"office", "corridor"}
    (note,) = plan.notes
    assert note == (
        "the drawn openings do not reach every room; added, so that every room can be reached: office - corridor (door)"
    )


def test_no_door_is_added_where_the_drawn_ones_suffice(tmp_path):
    doors = [IN_HALL, {**DOOR, "geometry": {"type": "Point", "coordinates": [6, 3]}}]
    plan = import_plan(written(tmp_path, room("kitchen", LEFT), room("office", RIGHT), HALL, *doors))
    assert len(plan.spec.storeys[0].openings) == 2 and plan.notes == ()


def test_a_counter_is_not_a_passage(tmp_path):
    counter = {**DOOR, "properties": {"kind": "counter"}}
    added = import_plan(written(tmp_path, room("kitchen", LEFT), room("office", RIGHT), counter)).spec.storeys[0].openings
    assert [opening.kind for opening in added] == ["counter", "door"]


def test_only_the_drawn_doors_count_if_that_is_asked_for(tmp_path):
    path = written(tmp_path, room("kitchen", LEFT), room("office", RIGHT), HALL, IN_HALL)
    message = refusal(path, only_drawn=True)
    assert "not reachable on foot (body radius 0.25 m): office" in message
    assert message.endswith("the plan is valid without --only-drawn (in Python only_drawn=False)")
    both = written(tmp_path, room("kitchen", LEFT), room("office", RIGHT), DOOR)
    assert import_plan(both, only_drawn=True).spec == import_plan(both).spec


def test_storeys_joined_by_drawn_stairs_need_no_doors_besides(tmp_path):
    cell = [[-3.4, 0], [0, 0], [0, 2], [-3.4, 2]]
    storeys = [room(label, c, storey=k) for k in (0, 1) for label, c in (("stairs", cell), ("corridor", LEFT))]
    ends = [
        {
            "type": "Feature",
            "properties": {"kind": "open", "storey": k},
            "geometry": {"type": "LineString", "coordinates": c},
        }
        for k, c in ((0, [[0, 0.05], [0, 1]]), (1, [[0, 1], [0, 1.95]]))
    ]
    plan = import_plan(written(tmp_path, *storeys, *ends))
    assert plan.notes == () and [len(storey.openings) for storey in plan.spec.storeys] == [1, 1]


def test_stairs_get_their_openings_too(tmp_path):
    cell = [[-3.4, 0], [0, 0], [0, 2], [-3.4, 2]]
    storeys = [room(label, c, storey=k) for k in (0, 1) for label, c in (("stairs", cell), ("corridor", LEFT))]
    spec = import_plan(written(tmp_path, *storeys)).spec
    assert [[o.leads for o in storey.openings] for storey in spec.storeys] == [["up"], ["down"]]


@pytest.mark.parametrize("climb", ["lift", "spiral"])
def test_lifts_and_spirals_get_one_opening_on_every_storey(tmp_path, climb):
    spec = import_plan(written(tmp_path, *tower(climb, climb, climb))).spec
    assert {r.climb for storey in spec.storeys for r in storey.rooms if r.label == "stairs"} == {climb}
    assert [[o.leads for o in storey.openings] for storey in spec.storeys] == [[None]] * 3


@pytest.mark.parametrize("climb", ["lift", "spiral"])
def test_openings_are_never_added_between_two_staircases(tmp_path, climb):
    cells = [[-3, 0], [0, 0], [0, 3], [-3, 3]], [[-3, -3], [0, -3], [0, 0], [-3, 0]]
    hall = [[0, -3], [3, -3], [3, 3], [0, 3]]
    stairs = [room("stairs", cell, storey=k, climb=climb) for k in (0, 1) for cell in cells]
    spec = import_plan(written(tmp_path, *stairs, *(room("corridor", hall, storey=k) for k in (0, 1)))).spec
    labels = {r.id: r.label for storey in spec.storeys for r in storey.rooms}
    beside = [sorted(labels[name] for name in opening.rooms) for storey in spec.storeys for opening in storey.openings]
    assert beside == [["corridor", "stairs"]] * 4


@pytest.mark.parametrize(
    ("cell", "climb", "message"),
    [
        ([[-1.2, 0], [0, 0], [0, 1.5], [-1.2, 1.5]], "flights", "1.20 x 1.50 m is too small for U stairs that rise 2.90 m"),
        ([[-1, 0], [0, 0], [0, 1], [-1, 1]], "spiral", "1.00 x 1.00 m is too small to rise 2.90 m"),
        ([[9, 9], [12, 9], [12, 12], [9, 12]], "flights", "no side of them borders a single room for long enough on every"),
    ],
)
def test_stairs_without_room_for_openings_are_refused_with_the_reason(tmp_path, cell, climb, message):
    stairs = [room("stairs", cell, storey=level, climb=climb) for level in (0, 1)]
    halls = [room("corridor", LEFT, storey=level) for level in (0, 1)]
    said = refusal(written(tmp_path, *stairs, *halls))
    assert "no openings could be added to stairs 'stairs'" in said and message in said and "; valid: " in said


def test_stairs_that_are_drawn_twice_are_refused_with_both_names(tmp_path):
    twice = room("stairs", tower("lift")[0]["geometry"]["coordinates"][0][:-1], name="again", climb="lift")
    assert "rooms 'stairs' and 'again' overlap near" in refusal(written(tmp_path, *tower("lift", "lift"), twice))


def test_rooms_that_lifts_connect_need_no_doors_between_them(tmp_path):
    shafts = [[-2, 0], [0, 0], [0, 2], [-2, 2]], [[8, 0], [10, 0], [10, 2], [8, 2]]
    lifts = [room("stairs", shaft, storey=k, climb="lift") for k in range(3) for shaft in shafts]
    doors = [
        {**DOOR, "properties": {"kind": "door", "storey": k}, "geometry": {"type": "Point", "coordinates": [x, 1]}}
        for k in range(3)
        for x in (0, 8)
    ]
    wings = [room("office", wing, storey=k) for k in (1, 2) for wing in (LEFT, RIGHT)]
    hall = room("corridor", [[0, 0], [8, 0], [8, 3], [0, 3]])
    plan = import_plan(written(tmp_path, hall, *wings, *lifts, *doors))
    assert plan.notes == () and [len(storey.openings) for storey in plan.spec.storeys] == [2, 2, 2]


@pytest.mark.parametrize(
    ("lower", "upper", "message"),
    [
        ("lift", "flights", "'stairs' has the climb 'lift', and 'stairs 2' above it 'flights'; valid: the same"),
        ("elevator", "lift", "features[0]: climb: is 'elevator'; valid: flights, spiral, lift"),
    ],
)
def test_staircases_with_an_invalid_climb_are_refused(tmp_path, lower, upper, message):
    assert message in refusal(written(tmp_path, *tower(lower, upper)))


@pytest.mark.parametrize("slab_m", ["0.5", 5, -1, math.nan, True, [0.3]])
def test_an_invalid_slab_is_refused(tmp_path, slab_m):
    assert "slab_m: is" in (message := refusal(written(tmp_path, *tower("lift", "lift"), slab_m=slab_m)))
    assert message.endswith("valid: a number from 0.1 to 1 [m]")


def test_rooms_drawn_at_the_inner_faces_of_their_walls_meet_in_the_middle(tmp_path):
    apart = [[x + 0.12, y] for x, y in RIGHT]
    path = written(tmp_path, room("kitchen", LEFT), room("office", apart), DOOR)
    message = refusal(path)
    assert "leave a gap of 0.12 m" in message or "no wall between two rooms" in message
    assert message.endswith("; the plan is valid with --snap 0.15 (in Python snap_m=0.15)")
    (storey,) = import_plan(path, snap_m=0.15).spec.storeys
    assert {x for r in storey.rooms for x, _ in r.polygon_m} == {0.0, 4.06, 8.12}


def test_rooms_that_are_exactly_snap_m_apart_meet(tmp_path):
    upper = room("corridor", [[0, 3.1], [8, 3.1], [8, 5], [0, 5]])  # 3.1 - 3 is more than 0.1
    (storey,) = import_plan(
        written(tmp_path, room("kitchen", [[0, 0], [8, 0], [8, 3], [0, 3]]), upper), snap_m=0.1
    ).spec.storeys
    assert {y for r in storey.rooms for _, y in r.polygon_m} == {0.0, 3.05, 5.0}


def test_names_keep_their_letters(tmp_path):
    spec = import_plan(written(tmp_path, room("office", LEFT, name="Büro Müller"), room("gym", RIGHT, name="体育館"))).spec
    assert [r.id for r in spec.storeys[0].rooms] == ["Buro Muller", "gym"]


@pytest.mark.parametrize(("name", "kept"), [(214, "214"), (2.14, "2.14"), ("214", "214"), (True, "gym"), ([3], "gym")])
def test_rooms_may_have_numbers_for_names(tmp_path, name, kept):
    leaf = {"kind": "door", "leaf": {"into": kept if kept == "gym" else name}}
    path = written(tmp_path, room("office", LEFT), room("gym", RIGHT, name=name), DOOR | {"properties": leaf})
    (storey,) = import_plan(path).spec.storeys
    assert [r.id for r in storey.rooms] == ["office", kept] and storey.openings[0].leaf.into == kept


@pytest.mark.parametrize(
    ("names", "into", "meant"),
    [
        (("bedroom", "bedroom"), "bedroom", "bedroom"),
        (("bedroom", "bedroom"), "bedroom 2", "bedroom 2"),
        (("Büro", "corridor"), "Büro", "Buro"),
        (("Büro", "corridor"), "Buro", "Buro"),
        (("", "bedroom"), "bedroom", "bedroom"),
        (("", "bedroom"), "bedroom 2", "bedroom 2"),
    ],
)
def test_a_door_leaf_names_its_room_by_id_or_as_drawn(tmp_path, names, into, meant):
    drawn = [room("bedroom", corners, name=name) for corners, name in zip((LEFT, RIGHT), names, strict=True)]
    door = DOOR | {"properties": {"kind": "door", "leaf": {"hinge": "start", "into": into, "angle_rad": 1.0}}}
    (storey,) = import_plan(written(tmp_path, *drawn, door)).spec.storeys
    assert [opening.leaf.into for opening in storey.openings] == [meant]
    other = DOOR | {"properties": {"kind": "door", "leaf": {"hinge": "start", "into": "attic", "angle_rad": 1.0}}}
    assert "swings into 'attic'; valid: " in refusal(written(tmp_path, *drawn, other))


def test_svg_shapes_transforms_and_y_down(tmp_path):
    body = """
      <g id="storey-0" transform="translate(100 50)">
        <rect id="kitchen_1" width="400" height="300"/>
        <path data-label="office" data-name="my office" d="M400 0 h400 V300 l-400,0 z"/>
        <line class="door" x1="400" y1="100" x2="400" y2="190"/>
        <text>a note</text><circle r="3"/><path d="M0 0 C 1 1 2 2 3 3"/>
      </g>"""
    plan = import_plan(svg(tmp_path, body))
    kitchen, office = plan.spec.storeys[0].rooms
    assert (kitchen.id, office.id) == ("kitchen", "my office")
    assert set(kitchen.polygon_m) == {(1.0, -3.5), (5.0, -3.5), (5.0, -0.5), (1.0, -0.5)}
    (door,) = plan.spec.storeys[0].openings
    assert {door.start_m, door.end_m} == {(5.0, -1.5), (5.0, -2.4)}
    assert plan.notes == ("ignored, because they name neither a label nor a kind: <path> on line 6",)


@pytest.mark.parametrize(
    "shape",
    [
        '<path class="door" d="M395 100 h10 v90 h-10 z"/>',
        '<path class="door" d="M395 100 v90 h10 v-90 z"/>',
        '<polyline class="door" points="405,190 395,190 395,100 405,100 405,190"/>',
        '<polygon data-kind="door" points="405,100 405,190 395,190 395,100"/>',
        '<rect data-kind="door" x="395" y="100" width="10" height="90"/>',
        '<path class="door" d="M400 100 V 190 Z"/>',
    ],
)
def test_an_opening_drawn_as_a_closed_shape_runs_along_its_middle(tmp_path, shape):
    (door,) = import_plan(svg(tmp_path, KITCHEN_SVG + GYM_SVG + shape)).spec.storeys[0].openings
    assert {door.start_m, door.end_m} == {(4.0, -1.0), (4.0, -1.9)}


def test_an_opening_with_another_closed_outline_is_refused(tmp_path):
    shape = '<path class="door" d="M395 100 h10 v90 z"/>'
    message = refusal(svg(tmp_path, KITCHEN_SVG + GYM_SVG + shape))
    assert "<path> 'door' on line 1: is a closed shape with 3 corners; valid: " in message


UNSUITABLE = "such shapes cannot be what their name, or their group's name, says"
INKSCAPE = 'xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape" width="210mm" height="297mm" viewBox="0 0 210 297"'


def test_labels_and_layers_of_inkscape_count(tmp_path):
    body = """
      <g inkscape:groupmode="layer" inkscape:label="Rooms" id="layer1" transform="translate(10,20)">
        <rect id="rect1" inkscape:label="Kitchen" width="40" height="30"/>
        <path id="path2" class="bedroom" inkscape:label="Anna's room" d="m 40,0 h 40 v 30 H 40 Z"/>
        <g id="g5" inkscape:label="office"><rect id="rect9" y="30" width="80" height="20"/><text>Office</text></g>
      </g>
      <g inkscape:groupmode="layer" inkscape:label="Doors" id="layer2">
        <path id="path3" d="M 50,30 V 39"/><path id="swing" d="m 50,39 a 9,9 0 0 0 9,-9"/>
      </g>
      <g inkscape:groupmode="layer" inkscape:label="Garden" style="display:none"><rect y="60" width="30" height="30"/></g>"""
    plan = import_plan(svg(tmp_path, body, INKSCAPE), metres_per_unit=0.1)
    found = [(r.id, r.label, r.polygon_m[0]) for r in plan.spec.storeys[0].rooms]
    assert [room[:2] for room in found] == [("Kitchen", "kitchen"), ("Anna's room", "bedroom"), ("office", "office")]
    assert set(plan.spec.storeys[0].openings[0].rooms) == {"Kitchen", "Anna's room"}
    swing, note = plan.notes
    assert swing == f"ignored, because {UNSUITABLE}: <path> 'swing' on line 8"
    assert note.endswith("added, so that every room can be reached: office - Kitchen (door)")


def test_a_group_with_several_shapes_does_not_say_which_is_the_room(tmp_path):
    body = '<g class="kitchen"><rect width="400" height="300"/><rect id="sink" width="60" height="50"/></g>'
    notes = import_plan(svg(tmp_path, body + '<rect class="gym" x="400" width="400" height="300"/>')).notes
    assert notes == (
        "ignored, because several shapes could be the room that their group names: "
        "<rect> on line 1 at (0, 0); <rect> 'sink' on line 1 at (0, 0)",
    )


KITCHEN_SVG, GYM_SVG = (
    f'<rect class="{name}" x="{x}" width="400" height="300"/>' for name, x in (("kitchen", 0), ("gym", 400))
)


@pytest.mark.parametrize(
    "hidden",
    [
        '<g visibility="hidden">{}</g>',
        '<g visibility="collapse"><g>{}</g></g>',
        '<g style="fill:none; visibility: Hidden !important;">{}</g>',
        '<g visibility="visible" style="visibility:hidden">{}</g>',
        '<g display="inline" style="display:none">{}</g>',
        '<g display="none"><g visibility="visible" display="inline">{}</g></g>',
        '<defs><g id="a">{}</g></defs><use href="#a" visibility="hidden"/>',
    ],
)
def test_hidden_shapes_are_ignored(tmp_path, hidden):
    assert import_plan(svg(tmp_path, KITCHEN_SVG + hidden.format(GYM_SVG))) == import_plan(svg(tmp_path, KITCHEN_SVG))


@pytest.mark.parametrize(
    "shown",
    [
        '<g visibility="hidden"><g visibility="visible">{}</g></g>',
        '<g visibility="hidden"><g visibility="inherit" style="visibility:visible">{}</g></g>',
        '<g visibility="hidden" style="fill:none;visibility:visible">{}</g>',
        '<g display="none" style="display:inline">{}</g>',
        '<defs><g id="a" visibility="visible">{}</g></defs><use href="#a" visibility="hidden"/>',
    ],
)
def test_shapes_can_be_visible_again_in_a_hidden_layer(tmp_path, shown):
    both = import_plan(svg(tmp_path, KITCHEN_SVG + GYM_SVG))
    assert import_plan(svg(tmp_path, KITCHEN_SVG + shown.format(GYM_SVG))) == both


def test_the_visibility_of_the_whole_drawing_is_inherited(tmp_path):
    shown = f'{KITCHEN_SVG}<g visibility="visible">{GYM_SVG}</g>'
    plan = import_plan(svg(tmp_path, shown, 'data-metres-per-unit="0.01" visibility="hidden"'))
    assert [r.id for r in plan.spec.storeys[0].rooms] == ["gym"]


@pytest.mark.parametrize("moved", ['x="9"', 'y="9"', 'viewBox="0 0 40 30"'])
def test_rooms_in_a_nested_svg_that_moves_them_are_refused_with_its_place(tmp_path, moved):
    path = svg(tmp_path, f'{KITCHEN_SVG}\n<svg id="wing" {moved}><g>{GYM_SVG}</g></svg>')
    assert "<rect> 'gym' on line 2: lies in <svg> 'wing' on line 2" in (message := refusal(path))
    assert message.endswith("valid: a group (<g>) with a transform instead")


def test_a_symbol_with_a_view_box_is_refused_where_it_shows_a_room(tmp_path):
    symbol = f'<symbol id="a" viewBox="0 0 40 30">{GYM_SVG}</symbol>'
    assert import_plan(svg(tmp_path, KITCHEN_SVG + symbol)) == import_plan(svg(tmp_path, KITCHEN_SVG))
    shown = svg(tmp_path, KITCHEN_SVG + symbol + '<use href="#a" id="wing" width="9"/>')
    assert "lies in <symbol> 'wing' on line 1" in refusal(shown)


def test_a_nested_svg_without_rooms_or_openings_does_no_harm(tmp_path):
    logo = '<svg x="9" viewBox="0 0 40 30"><path id="logo" d="M0 0h9"/></svg>'
    plan = import_plan(svg(tmp_path, KITCHEN_SVG + f"<svg>{GYM_SVG}</svg>" + logo))
    assert plan.spec == import_plan(svg(tmp_path, KITCHEN_SVG + GYM_SVG)).spec
    assert "ignored, because they name neither a label nor a kind: <path> 'logo' on line 1" in plan.notes


def test_layers_are_storeys(tmp_path):
    layers = "".join(
        f"""<g inkscape:label="Floor {k}"><rect class="stairs" x="-340" width="340" height="200"/>
        <rect class="corridor" width="400" height="300"/></g>"""
        for k in (0, 1)
    )
    spec = import_plan(svg(tmp_path, layers)).spec
    assert [[r.label for r in storey.rooms] for storey in spec.storeys] == [["stairs", "corridor"]] * 2


@pytest.mark.parametrize("layer", ["storey-12", "Floor 10", "level 8"])
def test_layers_with_the_number_of_a_storey_too_high_are_refused(tmp_path, layer):
    body = f'{KITCHEN_SVG}<g id="{layer}">{GYM_SVG}</g>'
    assert f"<rect> 'gym' on line 1: storey '{layer[-2:].strip()}'; valid: 0 (the lowest) to 7" in refusal(
        svg(tmp_path, body)
    )


@pytest.mark.parametrize(
    ("layer", "storey"),
    [("level-8", "8"), ("Floor - 8", "8"), ("Floor_8", "8"), ("Floor -1", "-1"), ("storey -2", "-2")],
)
def test_a_dash_before_the_number_of_a_layer_separates_it_or_is_a_sign(tmp_path, layer, storey):
    body = f'{KITCHEN_SVG}<g id="{layer}">{GYM_SVG}</g>'
    assert f"storey '{storey}'; valid: 0 (the lowest) to 7" in refusal(svg(tmp_path, body))


def test_what_is_drawn_once_can_be_used_often(tmp_path):
    body = """
      <defs><rect id="cell" width="300" height="400"/><g id="way"><line class="door" x1="-10" x2="80"/></g></defs>
      <use href="#cell" class="office"/><use xlink:href="#cell" class="office" x="300"/>
      <rect class="corridor" y="400" width="600" height="200"/>
      <use href="#way" x="100" y="400"/><use href="#way" transform="translate(400 400)"/><use href="#nothing"/>"""
    plan = import_plan(svg(tmp_path, body))
    assert [r.id for r in plan.spec.storeys[0].rooms] == ["office", "office 2", "corridor"]
    assert [{o.start_m[0], o.end_m[0]} for o in plan.spec.storeys[0].openings] == [{0.9, 1.8}, {3.9, 4.8}]
    assert plan.notes == ()


@pytest.mark.parametrize("use", ["", ' id="use12"', ' id="office"'])
def test_a_use_with_an_id_shows_what_the_symbol_is(tmp_path, use):
    """Drawing programs give an id to every <use>; it counts only if what is shown has no name of its own."""
    symbol = '<symbol id="door"><line x1="400" y1="100" x2="400" y2="190"/></symbol>'
    shown = import_plan(svg(tmp_path, f'{symbol}{KITCHEN_SVG}{GYM_SVG}<use href="#door"{use}/>'))
    assert [opening.kind for opening in shown.spec.storeys[0].openings] == ["door"] and shown.notes == ()
    cell = f'<defs><rect id="cell" x="400" width="400" height="300"/></defs>{KITCHEN_SVG}<use href="#cell"{use}/>'
    labels = [r.label for r in import_plan(svg(tmp_path, cell)).spec.storeys[0].rooms]
    assert labels == ["kitchen", "office"][: 1 + ("office" in use)]


def test_a_use_says_on_which_storey_it_shows_a_plan_again(tmp_path):
    floor = """<g id="storey-0"><rect class="stairs" x="-340" width="340" height="200"/>
        <rect class="corridor" width="400" height="300"/></g>"""
    spec = import_plan(svg(tmp_path, floor + '<use id="storey-1" href="#storey-0"/>')).spec
    assert [[r.label for r in storey.rooms] for storey in spec.storeys] == [["stairs", "corridor"]] * 2


@pytest.mark.parametrize(
    ("head", "unit"),
    [
        ('width="8000mm" height="3000mm" viewBox="0 0 800 300"', ""),
        ('width="800cm"', "cm"),
        ('data-metres-per-unit="0.01"', ""),
        ('width="8m" data-metres-per-unit="0.01"', "px"),
    ],
)
def test_pages_and_lengths_have_units(tmp_path, head, unit):
    body = f'<rect id="kitchen" width="400{unit}" height="300{unit}"/><rect id="gym" x="400{unit}" width="400{unit}" '
    (kitchen, gym) = import_plan(svg(tmp_path, f'{body} height="300{unit}"/>', head)).spec.storeys[0].rooms
    assert np.allclose(np.ptp(kitchen.polygon_m, axis=0), (4, 3)) and np.max(gym.polygon_m) == pytest.approx(8)


def test_a_plan_at_the_size_of_paper_needs_a_scale(tmp_path):
    body = '<rect id="kitchen" width="40" height="30"/><rect id="gym" x="40" width="40" height="30"/>'
    message = refusal(svg(tmp_path, body, INKSCAPE))
    assert "is 0.08 x 0.03 m on its page" in message and "give --metres-per-unit" in message
    assert message.endswith("0.1 for 1:100")
    (kitchen, _) = import_plan(svg(tmp_path, body, INKSCAPE), metres_per_unit=0.1).spec.storeys[0].rooms
    assert np.allclose(np.ptp(kitchen.polygon_m, axis=0), (4, 3))


def test_svg_words_that_resemble_a_known_one_are_named_once_with_their_place(tmp_path):
    body = """
      <rect id="kitchen" width="400" height="300"/><rect class="gym" x="400" width="400" height="300"/>
      <rect class="wall Kitchn" x="900" width="9" height="9"/><rect class="kitchn" x="950" width="9" height="9"/>
      <rect class="door" x="395" y="100" width="9" height="90"/><line id="Office_2" x2="9"/>
      <rect class="wall" width="9" height="9"/><path id="path371" d="M0 0 h9"/>"""
    notes = import_plan(svg(tmp_path, body)).notes
    assert notes[:5] == (
        "<rect> 'wall Kitchn' on line 3: 'kitchn' is unknown (did you mean 'kitchen'?); ignored",
        "<rect> 'door' on line 4: 'door' is an opening: a line, polyline or path, not a rect; ignored",
        "<line> 'Office_2' on line 4: 'office' is a room: a rect, polygon, polyline or path, not a line; ignored",
        "ignored, because they name neither a label nor a kind: "
        "<rect> 'wall Kitchn' on line 3 at (900, 0); <rect> 'kitchn' on line 3 at (950, 0); "
        "<rect> 'wall' on line 5 at (0, 0); <path> 'path371' on line 5 at (0, 0)",
        f"ignored, because {UNSUITABLE}: <rect> 'door' on line 4 at (395, 100); <line> 'Office_2' on line 4 at (0, 0)",
    )
    assert not any("'wall' is unknown" in note for note in notes)


def test_misspelt_properties_of_geojson_are_named(tmp_path):
    hall = room("hall", [[0, 3], [8, 3], [8, 5], [0, 5]], storry=0, width_m=3, name_de="Flur")
    other = {**room("gym", LEFT), "properties": {"lable": "gym", "colour": "red"}}
    plan = import_plan(written(tmp_path, hall, room("office", RIGHT), other))
    assert plan.notes[:3] == (
        "features[0]: 'storry' is unknown (did you mean 'storey'?); ignored",
        "features[2]: 'lable' is unknown (did you mean 'label'?); ignored",
        "ignored, because they have neither a label nor a kind: features[2]",
    )


def test_misspelt_fields_beside_the_features_are_named(tmp_path):
    beside = {"storey_height_m": [3.5], "slab": 0.5, "name": "plan", "crs": {}, "bbox": [0, 0, 4, 3]}
    assert import_plan(written(tmp_path, room("gym", LEFT), **beside)).notes == (
        "the FeatureCollection: 'storey_height_m' is unknown (did you mean 'storey_heights_m'?); ignored",
        "the FeatureCollection: 'slab' is unknown (did you mean 'slab_m'?); ignored",
    )


PROPERTIES = ("label", "name", "storey", "kind", "climb", "height_m", "sill_m", "leaf", "leads", "colour")


@pytest.mark.parametrize("preset", ["home", "uh2-apt"])
def test_properties_that_are_null_are_absent(tmp_path, preset):
    """Geographic information systems write every property on every feature, with null where a feature has no value."""
    drawing = json.loads(to_geojson(sample_house(preset, 1)))
    del drawing["slab_m"], drawing["storey_heights_m"]
    path = tmp_path / "plan.geojson"
    path.write_text(json.dumps(drawing))
    plain = import_plan(path)
    for feature in drawing["features"]:
        feature["properties"] = dict.fromkeys(PROPERTIES) | feature["properties"]
        if feature["properties"]["storey"] == 0:
            feature["properties"]["storey"] = None
    drawing["features"].append({"type": "Feature", "properties": {"lable": None, "kind": None}, "geometry": None})
    path.write_text(json.dumps({**drawing, "slab_m": None, "storey_heights_m": None, "storey_height_m": None}))
    nulls = import_plan(path)
    last = len(drawing["features"]) - 1
    assert nulls.spec == plain.spec
    assert nulls.notes == (f"ignored, because they have neither a label nor a kind: features[{last}]", *plain.notes)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        (3.5, "storey_heights_m is 3.5; valid: a list with the height of every storey [m]"),
        ({"0": 3.5}, "valid: a list with the height of every storey [m]"),
        (["3.5"], "storey_heights_m[0]: height_m: is '3.5'; valid: a number above 2 and at most 6 [m]"),
        ([None, 1.5], "storey_heights_m[1]: height_m: is 1.5; valid: a number above 2 and at most 6 [m]"),
        ([True], "storey_heights_m[0]: height_m: is true; valid: a number above 2 and at most 6 [m]"),
        ([3, 3, 3.0], "storey_heights_m[2] is given, but storey 2 has no rooms; valid: at most 2 heights"),
    ],
)
def test_invalid_heights_are_refused(tmp_path, given, message):
    assert message in refusal(written(tmp_path, *tower("lift", "lift"), storey_heights_m=given))


def test_storeys_without_a_given_height_have_the_usual_one(tmp_path):
    spec = import_plan(written(tmp_path, *tower("lift", "lift"), storey_heights_m=[None, 3])).spec
    assert heights(spec) == (0.3, [2.6, 3.0])


def test_ignored_shapes_are_named_where_the_plan_is_invalid(tmp_path):
    lost = refusal(svg(tmp_path, '<rect class="kitchn" width="400" height="300"/>'))
    assert "has 0 rooms with a label" in lost and "<rect> 'kitchn' on line 1: 'kitchn' is unknown (did you mean" in lost
    far = '<rect id="gym" width="400" height="300"/><rect id="office" x="900" width="400" height="300"/>'
    lost = refusal(svg(tmp_path, far + '<rect id="corrider" x="400" width="500" height="300"/>'))
    assert "not reachable" in lost and "(did you mean 'corridor'?)" in lost


def test_guesses_are_few_however_many_words_are_wrong(tmp_path):
    shapes = "".join(f'<line class="kitche{a}{b}"/>' for a in "abcdefg" for b in "abcdefg")
    assert len(import_plan(svg(tmp_path, '<rect id="gym" width="400" height="300"/>' + shapes)).notes) == 20 + 1


@pytest.mark.parametrize(
    ("text", "name"),
    [
        ("Office_2", "office"), ("WC #12", "wc"), ("living  room-1", "living room"), ("Room 7B", "room 7b"),
        ("hall-", "hall-"), ("1.20", "1"), ("12", ""), (" Gym. 3 ", "gym"),
    ],
)  # fmt: skip
def test_names_count_without_case_and_number(text, name):
    assert normalised_name(text) == name


@pytest.mark.parametrize("character", "-1 ")
def test_a_name_may_be_as_long_as_a_file(character):
    """In quadratic time, this would take minutes."""
    word = "x" + character * 1_000_000 + "x"
    assert normalised_name(word).replace(" ", "") == word.replace(" ", "")


@pytest.mark.parametrize(
    ("features", "message"),
    [
        ([room("kitchn", LEFT)], "features[0]: unknown label 'kitchn' (did you mean 'kitchen'?)"),
        (
            [room("gym", [[0, 0], [4, 0], [5, 3], [0, 3]], name="my gym")],
            "features[0] ('my gym'): the wall from corner 1 (4.00",
        ),
        ([room("gym", [[0, 0], [4e-5, 0], [4e-5, 3e-5], [0, 3e-5]]), room("gym", LEFT)], "at least 4 corners farther apart"),
        (
            [room("gym", [[7, 50], [7 + 4e-5, 50], [7 + 4e-5, 50 + 3e-5], [7, 50 + 3e-5]])],
            "seems to have coordinates in degrees",
        ),
        ([room("gym", LEFT), room("office", [[3, 0], [8, 0], [8, 3], [3, 3]]), DOOR], "overlap"),
        ([room("gym", LEFT), room("office", [[9, 0], [12, 0], [12, 3], [9, 3]])], "not reachable"),
        ([room("gym", LEFT, storey=9)], "features[0]: storey '9'; valid: 0 (the lowest) to 7"),
        (
            [room("gym", LEFT, storey=1)],
            "storey 0 has no rooms, but storey 1 has; valid: storeys numbered from 0 without a gap",
        ),
        (
            [room("pantry", [[0, 0], [0.5, 0], [0.5, 0.45], [0, 0.45]]), room("gym", LEFT)],
            "features[0]: has an area of 0.225 m²; valid: at least 0.25 m²",
        ),
        (
            [room("pantry", [[0, 0], [9, 0], [9, 0.051], [0, 0.051]]), room("gym", [[0, 0.05], [9, 0.05], [9, 3], [0, 3]])],
            "features[0]: nothing is left of the room",
        ),
        ([{**room("gym", LEFT), "geometry": None}], "features[0]: a room has a geometry of type null; valid: Polygon"),
        ([{**DOOR, "geometry": None}], "features[0]: an opening has a geometry of type null; valid: LineString, Point"),
        (
            [room("gym", LEFT), {**DOOR, "properties": {"label": "gym"}}],
            'a room has a geometry of type "Point"; valid: Polygon',
        ),
        ([room("gym", [[0, 0], [4, "x"], [4, 3]])], "features[0]: [4, 'x'] is not a pair of coordinates"),
        ([DOOR], "has 0 rooms with a label; valid: 1 to 200"),
        ([room("gym", LEFT), room("office", RIGHT), {**DOOR, "properties": {"kind": "portal"}}], "unknown kind of opening"),
        (
            [room("gym", LEFT), {**DOOR, "properties": {"kind": "dor"}}],
            "kind of opening 'dor' (did you mean 'door'?); valid:",
        ),
        ([room("gym", LEFT)] * 201, "has 201 rooms"),
        (
            [room("gym", LEFT), room("office", RIGHT), {**DOOR, "properties": {"kind": "door", "height_m": "2"}}],
            "features[2]: height_m: is '2'; valid: a number above 0 and at most 1000 [m]",
        ),
        ([room("gym", [p for k in range(40) for p in ([k, k % 2], [k + 1, k % 2])] + [[40, 9], [0, 9]])], "4 to 64"),
    ],
)
def test_invalid_drawings_are_refused_with_their_place(tmp_path, features, message):
    assert message in refusal(written(tmp_path, *features))


def test_a_door_far_from_any_wall_is_refused_and_one_to_the_outside_left_out(tmp_path):
    pair = room("gym", LEFT), room("office", RIGHT)

    def door(x, y):
        return {**DOOR, "geometry": {"type": "Point", "coordinates": [x, y]}}

    assert "no wall between two rooms is within 0.3 m of the door at (2.00, 1.50) m" in refusal(
        written(tmp_path, *pair, DOOR, door(2, 1.5))
    )
    plan = import_plan(written(tmp_path, *pair, DOOR, door(2, 0)))
    assert plan.notes == ("features[3]: leads out of the house; ignored",) and len(plan.spec.storeys[0].openings) == 1


STROKE = '<line id="{}" class="door" x1="400" y1="{}" x2="400" y2="{}"/>'


def test_openings_that_overlap_are_both_named_as_drawn(tmp_path):
    doors = STROKE.format("one", 50, 140) + "\n" + STROKE.format("two", 100, 190)
    message = refusal(svg(tmp_path, KITCHEN_SVG + GYM_SVG + doors))
    assert "<line> 'one' on line 1 and <line> 'two' on line 2 overlap by 0.40 m; valid: " in message


def test_a_field_that_stands_twice_in_geojson_is_refused(tmp_path):
    path = tmp_path / "plan.geojson"
    path.write_text('{"type": "FeatureCollection", "features": [], "features": []}')
    assert "has the field 'features' 2 times; valid: once" in refusal(path)


@pytest.mark.parametrize("again", [(50, 140), (140, 50), (53, 138)])
def test_an_opening_that_is_drawn_twice_counts_once(tmp_path, again):
    doors = STROKE.format("one", 50, 140), STROKE.format("two", *again)
    once, twice = (import_plan(svg(tmp_path, KITCHEN_SVG + GYM_SVG + "".join(doors[:n]))) for n in (1, 2))
    assert twice.spec == once.spec
    assert twice.notes == ("<line> 'two' on line 1: is the same opening as <line> 'one' on line 1; ignored",)


@pytest.mark.parametrize(("x", "leads_out"), [(3.8, True), (4.25, True), (4.0, False)])
def test_a_stroke_belongs_to_the_nearest_wall_even_if_that_is_an_outer_wall(tmp_path, x, leads_out):
    """At the end of an inner wall a point is as near to the outer wall; then the inner wall counts."""
    pair = room("gym", LEFT), room("office", RIGHT)
    front = {**DOOR, "geometry": {"type": "Point", "coordinates": [x, 0]}}
    plan = import_plan(written(tmp_path, *pair, DOOR, front) if leads_out else written(tmp_path, *pair, front))
    assert (plan.notes == ("features[3]: leads out of the house; ignored",)) == leads_out
    assert len(plan.spec.storeys[0].openings) == 1


def test_a_front_door_near_an_inner_wall_leads_out(tmp_path):
    front = {**DOOR, "geometry": {"type": "LineString", "coordinates": [[3.75, 0.02], [4.65, 0.02]]}}
    plan = import_plan(written(tmp_path, room("gym", LEFT), room("office", RIGHT), DOOR, front))
    assert plan.notes == ("features[3]: leads out of the house; ignored",)


LAUGHS = (
    "<svg data-metres-per-unit='1'><g id='g0'><rect/></g>"
    + "".join(f"<g id='g{k + 1}'>" + f"<use href='#g{k}'/>" * 10 + "</g>" for k in range(20))
    + "</svg>"
)
BOMB = '<!DOCTYPE svg [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;">]>'


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (BOMB + "<svg>&b;</svg>", "document type definition"),
        ('<!DOCTYPE svg SYSTEM "file:///etc/passwd"><svg/>', "document type definition"),
        ("<svg>" + "<g>" * 200, "nested deeper than 100"),
        ("<svg>" + "<g/>" * 100_001 + "</svg>", "more than 100000"),
        ("<html/>", "outermost element is <html>"),
        ("<svg><g></svg>", "is not SVG: mismatched tag at line 1"),
        ("<svg/>", "does not state its scale"),
        ('<svg data-metres-per-unit="1"><path id="gym" d="M0 0 C 1 1 2 2 3 3 Z"/></svg>', "has a curve (CubicBezier)"),
        ('<svg data-metres-per-unit="1"><path id="gym" d="M0 0 L garbage Z"/></svg>', "its coordinates cannot be read"),
        ('<svg data-metres-per-unit="1"><path id="gym" d="L 4 0 L 4 3 Z"/></svg>', "has 0 corners"),
        ('<svg data-metres-per-unit="1"><path id="gym" d="M0 0h4v3z M9 0h1v1z"/></svg>', "more than one part"),
        ('<svg data-metres-per-unit="1"><path id="gym" d="M0 0h4v3h-4"/></svg>', "a room's path is closed"),
        (f'<svg data-metres-per-unit="1"><path id="gym" d="M{"0 0 " * 250_001}Z"/></svg>', "more than 1000000 characters"),
        ('<svg data-metres-per-unit="1"><rect id="gym" width="5ft" height="3"/></svg>', "width is '5ft'"),
        ('<svg data-metres-per-unit="ten"/>', "data-metres-per-unit is 'ten'"),
        ('<svg width="9mm" viewBox="0 0 0 9"/>', "has the viewBox '0 0 0 9'; valid: the numbers x, y,"),
        ('<svg width="0mm"/>', "has a page with the width '0mm'; valid: a width above 0"),
        ("<svg data-metres-per-unit='1'><g id='a'><use href='#a'/></g></svg>", "nested deeper than 100"),
        (LAUGHS, "more than 100000"),
        (
            '<svg data-metres-per-unit="1"><rect id="gym" width="5" height="3" transform="wobble(3)"/></svg>',
            "transform 'wobble(3)'",
        ),
        (" " * 16_000_001, "larger than 16 MB"),
    ],
)
def test_hostile_and_broken_svg_is_refused(tmp_path, text, message):
    path = tmp_path / "plan.svg"
    path.write_text(text)
    assert message in refusal(path)


W3C = '<!DOCTYPE svg PUBLIC "-//W3C//DTD SVG 1.1//EN" "http://www.w3.org/Graphics/SVG/1.1/DTD/svg11.dtd"'


def test_the_document_type_that_drawing_programs_write_is_accepted_without_declarations(tmp_path):
    plain = svg(tmp_path, KITCHEN_SVG + GYM_SVG)
    body, plan = plain.read_text(), import_plan(plain)
    plain.write_text(f'<?xml version="1.0"?>\n{W3C}>{body}')
    assert import_plan(plain) == plan
    plain.write_text(f'{W3C} [<!ENTITY a "kitchen">]>{body}')
    assert "document type definition" in refusal(plain)


def test_a_room_may_be_a_multipolygon_of_one_polygon(tmp_path):
    plain, one, two = room("gym", LEFT), room("gym", LEFT), room("gym", LEFT)
    ring = plain["geometry"]["coordinates"]
    one["geometry"] = {"type": "MultiPolygon", "coordinates": [ring]}
    two["geometry"] = {"type": "MultiPolygon", "coordinates": [ring, ring]}
    assert import_plan(written(tmp_path, one)) == import_plan(written(tmp_path, plain))
    message = refusal(written(tmp_path, two))
    assert "features[0]: a room has a MultiPolygon of 2 polygons; valid: one polygon for each room" in message


SINGULAR = ["scale(0)", "scale(0 1)", "scale(1e-9)", "skewX(90)", "matrix(0 0 0 0 0 0)", "matrix(1 1 1 1 0 0)"]


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("transform", [*SINGULAR, "scale(1e300) scale(1e300)"])
def test_a_transform_that_leaves_nothing_of_a_room_is_refused_with_the_element(tmp_path, transform):
    path = svg(tmp_path, f'<g transform="{transform}"><rect id="kitchen" width="400" height="400"/></g>')
    assert "<rect> 'kitchen' on line 1: " in refusal(path) and "; valid: " in refusal(path)


@pytest.mark.parametrize("beside", ["", '<rect id="gym" width="400" height="400"/>'])
def test_a_room_without_any_size_is_refused_with_its_place(tmp_path, beside):
    path = svg(tmp_path, f'{beside}<rect id="kitchen"/>')
    assert "<rect> 'kitchen' on line 1: has too few corners; valid: " in refusal(path)


@pytest.mark.parametrize("text", ["", "{", "[]", '{"features": 3}', "[" * 100_000, '{"features": [null, 3, {}]}'])
def test_broken_geojson_is_refused(tmp_path, text):
    path = tmp_path / "plan.geojson"
    path.write_text(text)
    refusal(path)


def test_files_of_other_kinds_and_senseless_scales_are_refused(tmp_path):
    assert "valid: .svg, .geojson, .json" in refusal(tmp_path / "plan.dxf")
    assert "cannot be read" in refusal(tmp_path / "missing.svg")
    for options in ({"metres_per_unit": 0.0}, {"metres_per_unit": math.nan}, {"snap_m": 1.0}):
        with pytest.raises(SpecError, match="valid:"):
            import_plan("plan.svg", **options)


def test_a_use_that_refers_to_nothing_draws_nothing(tmp_path):
    rooms = '<rect class="kitchen" width="4" height="3"/><rect class="bedroom" x="4" width="4" height="3"/>'
    plans = []
    for stray in ("", "<use/>", '<use x="20"/>', '<use href=""/>', '<use href="#nowhere"/>'):
        path = tmp_path / "plan.svg"
        path.write_text(f'<svg xmlns="http://www.w3.org/2000/svg" data-metres-per-unit="1">{rooms}{stray}</svg>')
        plans.append(import_plan(path).spec)
    assert all(plan == plans[0] for plan in plans)


def test_every_malformed_field_of_a_drawn_door_is_reported(tmp_path):
    house = to_geojson(sample_from_rooms(("kitchen", "bedroom"), seed=3))
    drawing = json.loads(house)
    door = next(feature for feature in drawing["features"] if "kind" in feature["properties"])
    door["properties"] |= {"height_m": "q", "sill_m": "x"}
    path = tmp_path / "plan.geojson"
    path.write_text(json.dumps(drawing))
    with pytest.raises(SpecError) as caught:
        import_plan(path)
    told = [str(caught.value), *caught.value.__notes__]
    assert len(told) == 2 and any("height_m" in line for line in told) and any("sill_m" in line for line in told)


def test_an_outline_of_one_point_is_refused(tmp_path):
    alone = room("office", LEFT)
    alone["geometry"]["coordinates"] = [[[9, 9]]]
    assert "too few corners" in refusal(written(tmp_path, room("kitchen", LEFT), alone))
