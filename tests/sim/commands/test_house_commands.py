"""`lexis-sim house`: every option takes effect, every problem is named, and bad files give one line and nothing else."""

import json
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from helpers import command_line
from PIL import Image

from sim import house_proof
from sim.gallery import best_view
from sim.house_proof import cases, prove
from worlds.house import build_house
from worlds.openings.openness import openness_of
from worlds.plan_import.importer import to_geojson
from worlds.presets import PRESETS, sample_house
from worlds.spec import HouseSpec, json_schema
from worlds.variant import variant

KITCHEN = {"id": "kitchen", "label": "kitchen", "polygon_m": [[0, 0], [4, 0], [4, 3], [0, 3]]}
BEDROOM = {"id": "bedroom", "label": "bedroom", "polygon_m": [[4, 0], [8, 0], [8, 3], [4, 3]]}
DOOR = {"rooms": ["kitchen", "bedroom"], "kind": "door", "start_m": [4, 1], "end_m": [4, 1.9]}
SOFA = {"id": "s", "kind": "sofa", "room": "bedroom", "position_m": [6, 1, 0], "yaw_rad": 0, "size_m": [2, 1, 1], "seed": 0}


def two_rooms(**change):
    return json.dumps({"storeys": [{"rooms": [KITCHEN, BEDROOM], "openings": [DOOR], "furniture": []} | change]})


def status_of(*argv):
    return command_line.status_of(["house", *argv])


@pytest.fixture(autouse=True)
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_what_is_asked_for_is_generated():
    options = "--openness 0.4 --clutter 0.5 --rooms 6 --storeys 2 --texture poor --light dim --seed 3 -o h.json"
    assert status_of("generate", *options.split()) == 0
    spec = HouseSpec.load("h.json")
    assert spec.storeys == sample_house("home", 3, openness=0.4, rooms=6, storeys=2).storeys
    assert openness_of(spec) == pytest.approx(0.4, abs=0.05)
    assert (spec.clutter, spec.appearance.texture, spec.appearance.light) == (0.5, "poor", "dim")


def test_check_names_rooms_without_an_essential_piece_unless_the_house_is_unfurnished(capsys):
    Path("sofa.json").write_text(two_rooms(furniture=[SOFA]), encoding="utf-8")
    Path("empty.json").write_text(two_rooms(), encoding="utf-8")
    assert status_of("check", "sofa.json") == status_of("check", "empty.json") == 0
    printed = capsys.readouterr().out
    assert "sofa.json: note: bedroom has no double bed, although every bedroom should\n" in printed
    assert "sofa.json: note: kitchen has no stove, although every kitchen should\n" in printed
    assert "empty.json: note" not in printed


def test_a_list_of_rooms_can_have_storeys():
    assert status_of("generate", "--rooms", "kitchen, gym,office", "--storeys", 2, "-o", "h.json") == 0
    spec = HouseSpec.load("h.json")
    assert len(spec.storeys) == 2 and {"kitchen", "gym", "office"} <= set(spec.room_labels)


def test_listed_furniture_is_that_of_the_house_and_listing_it_again_changes_nothing():
    assert status_of("generate", "--preset", "home", "--seed", "3", "-o", "h.json") == 0
    assert status_of("variant", "h.json", "--list-furniture", "-o", "listed.json") == 0
    before, listed = build_house(HouseSpec.load("h.json")), HouseSpec.load("listed.json")
    assert len(before.furniture) == sum(len(storey.furniture) for storey in listed.storeys) > 0
    assert [piece.kind for piece in build_house(listed).furniture] == [piece.kind for piece in before.furniture]
    assert status_of("variant", "listed.json", "--list-furniture", "-o", "again.json") == 2


def test_a_variant_is_the_library_s():
    spec = sample_house("home", 1, clutter=0.0)
    Path("h.json").write_text(spec.to_json(), encoding="utf-8")
    options = "--openness 0.7 --clutter 0.3 --mirror --rotate 3 --repaint 8 --add-storey --climb lift -o v.json"
    assert status_of("variant", "h.json", *options.split()) == 0
    wanted = variant(spec, openness=0.7, clutter=0.3, mirror=True, rotate=3, repaint=8, add_storey=True, climb="lift")
    assert HouseSpec.load("v.json") == wanted


def test_a_plan_becomes_a_house_and_notes_are_printed(here, capsys):
    spec = sample_house("home", 2)
    (here / "plan.geojson").write_text(to_geojson(spec))
    assert status_of("import", "plan.geojson", "-o", "h.json") == 0
    assert HouseSpec.load("h.json").room_labels == spec.room_labels
    square = "<rect class='office' width='400' height='300'/><rect class='gym' x='400' width='400' height='300'/>"
    (here / "plan.svg").write_text(f"<svg xmlns='http://www.w3.org/2000/svg'>{square}</svg>")
    assert status_of("import", "plan.svg", "--metres-per-unit", 0.01, "-o", "h.json") == 0
    assert "note: no openings are drawn; added" in capsys.readouterr().out
    assert status_of("import", "plan.svg", "--metres-per-unit", 0.01, "--only-drawn", "-o", "h.json") == 2
    assert "the plan is valid without --only-drawn" in capsys.readouterr().err


def test_the_schema_is_printed(capsys):
    assert status_of("schema") == 0
    assert json.loads(capsys.readouterr().out) == json_schema()


def test_a_view_is_the_picture_of_the_room(here, capsys):
    (here / "h.json").write_text(two_rooms(furniture=[SOFA]))
    assert status_of("view", "h.json", "--room", "bedroom", "-o", "v.png") == 0
    assert capsys.readouterr().out == "v.png: bedroom (bedroom)\n"
    house = build_house(HouseSpec.load("h.json"))
    picture = np.asarray(Image.open("v.png"))
    assert picture.shape == (720, 960, 3)
    np.testing.assert_array_equal(picture, best_view(house, house.room_by_id["bedroom"], (960, 720)))


def test_a_check_describes_the_house_and_counts_in_good_english(here, capsys):
    room, sofa = BEDROOM | {"id": "b"}, SOFA | {"room": "b"}
    for rooms, openings, furniture in (([room], [], [sofa]), ([KITCHEN, BEDROOM], [DOOR], [])):
        (here / "h.json").write_text(two_rooms(rooms=rooms, openings=openings, furniture=furniture))
        assert status_of("check", "h.json") == 0
        printed = capsys.readouterr().out
        assert ("1 room on 1 floor" in printed) == (len(rooms) == 1) and ("2 rooms on 1 floor" in printed) == (
            len(rooms) == 2
        )
        assert ("1 piece of furniture" if furniture else "0 pieces of furniture") in printed


def test_a_check_names_every_problem(here, capsys):
    narrow, outside = DOOR | {"end_m": [4, 1.3]}, SOFA | {"position_m": [7.5, 1, 0]}
    (here / "bad.json").write_text(two_rooms(openings=[narrow], furniture=[outside]))
    assert status_of("check", "bad.json") == 1
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) >= 3 and all(line.startswith("bad.json: ") for line in lines)
    for named in ("openings[0] (kitchen - bedroom): 0.30 m wide", "'s'", "not reachable on foot"):
        assert any(named in line for line in lines), lines


def test_a_check_names_all_rooms_that_overlap_even_where_nothing_can_be_built(here, capsys):
    others = [BEDROOM | {"id": name, "polygon_m": [[x, 0], [8, 0], [8, 3], [x, 3]]} for name, x in (("b", 3), ("c", 5))]
    (here / "bad.json").write_text(two_rooms(rooms=[KITCHEN, *others], openings=[]))
    assert status_of("check", "bad.json") == 1
    assert capsys.readouterr().out.splitlines() == [
        f"bad.json: storeys[0]: rooms {pair} overlap by {area} m²; rooms may only touch"
        for pair, area in (("'kitchen' and 'b'", "3.00"), ("'b' and 'c'", "9.00"))
    ]


def sparse_gigabyte(path):
    with path.open("wb") as file:
        file.truncate(1_000_000_000)


MALFORMED = {
    "NaN": (two_rooms().replace("1.9", "NaN"), "openings[0].end_m[1] (opening 'kitchen' - 'bedroom'): is not a number"),
    "negative size": (two_rooms(furniture=[SOFA | {"size_m": [-2, 1, 1]}]), "furniture[0].size_m[0] (furniture 's'): is -2"),
    "unknown label": (two_rooms(rooms=[KITCHEN | {"label": "lair"}, BEDROOM]), "rooms[0].label (room 'kitchen'): unknown"),
    "a million rooms": ('{"storeys": [{"rooms": [' + "{}," * 999_999 + "{}]}]}", "storeys[0].rooms: has 1000000 items"),
    "a gigabyte": (sparse_gigabyte, "larger than 16 MB"),
}
IMPOSSIBLE = {
    "overlap": (
        two_rooms(rooms=[KITCHEN, BEDROOM | {"polygon_m": [[3, 0], [8, 0], [8, 3], [3, 3]]}]),
        "storeys[0]: rooms 'kitchen' and 'bedroom' overlap by 3.00 m²",
    ),
    "unreachable": (two_rooms(openings=[]), "not reachable on foot (body radius 0.25 m): bedroom"),
    "a door wider than its wall": (
        two_rooms(openings=[DOOR | {"start_m": [4, 1], "end_m": [4, 3.5]}]),
        "storeys[0].openings[0] (kitchen - bedroom): only 2.00 of its 2.50 m lie in the wall",
    ),
}
BAD = [(*case, 2) for case in MALFORMED.values()] + [(*case, 1) for case in IMPOSSIBLE.values()]


@pytest.mark.parametrize(("content", "message", "checked"), BAD, ids=[*MALFORMED, *IMPOSSIBLE])
def test_a_bad_house_costs_a_line_that_names_the_place_and_leaves_nothing(content, message, checked, here, capsys):
    bad = here / "bad.json"
    content(bad) if callable(content) else bad.write_text(content)
    for command in (["export", bad, "-o", "h.glb"], ["variant", bad, "--mirror", "-o", "h.json"]):
        assert status_of(*command) == 2
        printed = capsys.readouterr()
        assert message in printed.err and printed.err.count("\n") == 1 and printed.out == ""
    assert status_of("check", bad) == checked
    printed = capsys.readouterr()
    assert message in (printed.err if checked == 2 else printed.out)
    assert [path.name for path in here.iterdir()] == ["bad.json"]


def test_the_plan_of_a_house_that_is_not_valid_is_drawn_with_a_note(here, capsys):
    (here / "shut.json").write_text(two_rooms(openings=[]))
    assert status_of("show", "shut.json", "-o", "plan.png") == 0
    assert capsys.readouterr().err.startswith("note: the house is not valid: not reachable on foot")
    (here / "bad.json").write_text(two_rooms(rooms=[KITCHEN, BEDROOM | {"polygon_m": [[3, 0], [8, 0], [8, 3], [3, 3]]}]))
    assert status_of("show", "bad.json", "-o", "none.png") == 2
    assert capsys.readouterr().err.startswith("lexis-sim: bad.json: rooms 'kitchen' and 'bedroom' overlap")


def test_every_malformed_field_has_a_line_of_its_own(here, capsys):
    (here / "bad.json").write_text(two_rooms(rooms=[KITCHEN | {"label": "lair"}, BEDROOM | {"seed": -1}]))
    assert status_of("check", "bad.json") == 2
    printed = capsys.readouterr()
    label, seed = printed.err.splitlines()
    assert "bad.json: storeys[0].rooms[0].label (room 'kitchen'): unknown label 'lair'" in label and printed.out == ""
    assert "bad.json: storeys[0].rooms[1].seed (room 'bedroom'): is -1; valid: a whole number" in seed
    assert all(line.startswith("lexis-sim: ") and len(line) <= 400 for line in (label, seed))


@pytest.mark.parametrize(
    ("argv", "message"),
    [
        (["generate", "--openness", "2", "-o", "h.json"], "openness is 2.0; valid: 0"),
        (["generate", "--clutter", "nan", "-o", "h.json"], "clutter is nan; valid: 0"),
        (["generate", "--rooms", "1", "-o", "h.json"], "valid: 2 to 40"),
        (["generate", "--storeys", "9", "-o", "h.json"], "valid: 1 to 4"),
        (["generate", "--texture", "shiny", "-o", "h.json"], "choose from"),
        (["generate", "--preset", "ori", "--rooms", "gym", "-o", "h.json"], "cannot be combined with a list of --rooms"),
        (["generate", "-o", "."], "is a folder"),
        (["generate", "-o", "pipe"], "pipe: is a device or a pipe"),
        (["variant", "good.json", "-o", "h.json"], "good.json: nothing would change"),
        (["variant", "good.json", "--clutter", "5", "-o", "h.json"], "clutter is 5.0; valid: 0"),
        (["variant", "good.json", "--repaint", "-4", "-o", "h.json"], "whole number from 0"),
        (["import", "plan.png", "-o", "h.json"], "valid: .svg, .geojson, .json"),
        (["import", "plan.svg", "-o", "h.json"], "plan.svg: cannot be read"),
        (["import", "huge.svg", "-o", "h.json"], "huge.svg: larger than 16 MB"),
        (["import", "good.json", "-o", "h.json"], "good.json: "),
        (["import", "huge.svg", "--snap", "7", "-o", "h.json"], "valid: a number from 0.001 to 0.3"),
        (["view", "good.json", "--room", "kitchn", "-o", "h.png"], "(did you mean 'kitchen'?); valid: kitchen, bedroom"),
        (["view", "good.json", "--room", "kitchen", "-o", "h.jpg"], "valid: a name that ends in .png"),
        (["prove", "--preset", "home,castle"], "unknown preset 'castle'; valid: home"),
    ],
)
def test_bad_arguments_cost_a_line_and_leave_nothing(argv, message, here, capsys):
    (here / "good.json").write_text(two_rooms())
    sparse_gigabyte(here / "huge.svg")
    os.mkfifo(here / "pipe")
    assert status_of(*argv) == 2
    printed = capsys.readouterr()
    assert message in printed.err and printed.err.count("\n") == 1 and printed.out == ""
    assert not (here / "h.json").exists()


@pytest.mark.parametrize("command", ["export", "variant --mirror", "import"])
@pytest.mark.parametrize("other_name", ["./b.json", "link.json"])
def test_no_command_replaces_the_file_that_it_reads(command, other_name, here, capsys):
    (here / "b.json").write_text(two_rooms())
    (here / "link.json").symlink_to("b.json")
    name, *options = command.split()
    for file, out in (("b.json", other_name), (other_name, "b.json")):
        assert status_of(name, file, *options, "-o", out) == 2
        printed = capsys.readouterr()
        assert "is the file that is read" in printed.err and printed.err.count("\n") == 1 and printed.out == ""
        assert (here / "b.json").read_text() == two_rooms() and (here / "link.json").is_symlink()


@pytest.mark.parametrize("command", ["run", "check", "record"])
def test_a_house_that_breaks_a_rule_is_named_by_its_file(command, here, capsys):
    (here / "apart.json").write_text(two_rooms(openings=[]))
    assert command_line.status_of([command, "--house", "apart.json", "-o", "out"]) == 2
    message = capsys.readouterr().err
    assert message.startswith("lexis-sim: apart.json: not reachable on foot") and message.count("\n") == 1
    assert not (here / "out").exists()


def test_a_reader_that_closes_the_pipe_causes_no_traceback():
    code = "import sys; from sim.cli import main; sys.exit(main(['house', 'schema']))"
    process = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    process.stdout.close()
    assert process.stderr.read() == b"" and process.wait() == 141


def test_houses_are_proved_in_two_processes_each(capsys):
    assert status_of("prove", "--houses", 6, "--preset", "uh2-apt,apartment", "--seed", 600, "--processes", 2) == 0
    assert capsys.readouterr().out.count(" 3 ") == 2


def test_cases_cover_every_family_plain_and_as_open_and_cluttered_as_can_be():
    wanted = cases(PRESETS, 40, 1000)
    assert [case.seed for case in wanted] == list(range(40, 1040))
    assert {(case.preset, case.openness, case.clutter) for case in wanted} >= {
        (preset, openness, clutter) for preset in PRESETS for openness in (None, 0.0, 1.0) for clutter in (0.0, 1.0, 4.0)
    }


@pytest.mark.parametrize(
    ("changed", "why"),
    [({"seconds": 9.0}, None), ({"digest": "other"}, "is another house when generated again"), ({"failure": "x"}, "x")],
)
def test_a_failure_and_a_difference_are_reported(changed, why, monkeypatch):
    made = house_proof._Made(0.1, "digest", None)
    monkeypatch.setattr(house_proof, "process_pool", InTurn)
    monkeypatch.setattr(house_proof, "_make", lambda case, first: replace(made, **changed) if first else made)
    assert [proof.failure for proof in prove(cases(["home"], 0, 2), 2)] == [why, why]


class InTurn:
    """An executor that runs everything at once in this process."""

    def __init__(self, *_):
        pass

    def __enter__(self):
        return self

    def __exit__(self, *_):
        pass

    def map(self, work, *items, chunksize):
        return list(map(work, *items))


@pytest.mark.slow
def test_a_thousand_houses():
    assert not [proof for proof in prove(cases(PRESETS, 10_000, 1000), 2) if proof.failure]
