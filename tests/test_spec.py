"""House specs: JSON is an exact copy, and bad JSON names the place."""

import json

import pytest

from worlds.errors import SpecError
from worlds.presets import PRESETS, sample_house
from worlds.spec import MAX_JSON_BYTES, HouseSpec

SQUARE = [[0, 0], [4, 0], [4, 3], [0, 3]]


def spec_json(**room):
    return json.dumps({"storeys": [{"rooms": [{"id": "a", "label": "kitchen", "polygon_m": SQUARE} | room]}]})


@pytest.mark.parametrize("preset", PRESETS)
def test_json_round_trip_is_the_identity(preset):
    spec = sample_house(preset, 11)
    assert HouseSpec.from_json(spec.to_json()) == spec
    assert HouseSpec.from_json(spec.to_json()).to_json() == spec.to_json()


def test_a_handwritten_house_needs_nothing_but_rooms():
    assert HouseSpec.from_json(spec_json()).room_labels == ("kitchen",)


@pytest.mark.parametrize(
    ("bad", "place"),
    [
        (spec_json(label="kitchn"), "storeys[0].rooms[0].label: unknown label 'kitchn'"),
        (spec_json(polygon_m=[[0, 0], [4, 0], [4, 3], [0.5, 2]]), "polygon_m: walls must run along x or y"),
        (spec_json(polygon_m=[[0, 0], [4, 0], [4, 1e9], [0, 1e9]]), "polygon_m"),
        (spec_json().replace("4", "NaN", 1), "polygon_m[1][0]: Input should be a finite number"),
        (spec_json(colour="red"), "storeys[0].rooms[0].colour"),
        ('{"storeys": []}', "storeys"),
        ("{", "JSON"),
        (json.dumps({"storeys": [{"rooms": [{"id": "a", "label": "office", "polygon_m": SQUARE}] * 2}]}), "repeated: a"),
        (spec_json().replace("4", "true", 1), "polygon_m[1][0]: Input should be a valid number"),
        (spec_json(polygon_m=[[0, 0], ["4", 0], ["4", 3], [0, 3]]), "polygon_m[1][0]: Input should be a valid number"),
        (spec_json(polygon_m=[[0, 0], [1000, 0], [1000, 1000], [0, 1000]]), "1000000 m²; at most 20000"),
        (json.dumps(json.loads(spec_json()) | {"schema_version": 1}), "schema_version"),
    ],
)
def test_bad_json_is_refused_in_one_line_that_names_the_place(bad, place):
    with pytest.raises(SpecError) as error:
        HouseSpec.from_json(bad, source="my.json")
    assert str(error.value).startswith("my.json") and place in str(error.value) and "\n" not in str(error.value)


def test_an_opening_between_unknown_rooms_lists_the_known_ones():
    data = json.loads(spec_json())
    data["storeys"][0]["openings"] = [{"rooms": ["a", "b"], "kind": "door", "start_m": [0, 1], "end_m": [0, 2]}]
    with pytest.raises(SpecError, match="names room 'b'; its rooms are a"):
        HouseSpec.from_json(json.dumps(data))


def test_two_pieces_of_furniture_with_one_id_are_refused():
    data = json.loads(spec_json())
    piece = {"id": "f", "kind": "sofa", "room": "a", "position_m": [2, 1, 0], "yaw_rad": 0, "size_m": [2, 1, 1], "seed": 0}
    data["storeys"][0]["furniture"] = [piece, piece]
    with pytest.raises(SpecError, match="furniture ids must be unique in the house; repeated: f"):
        HouseSpec.from_json(json.dumps(data))


def test_files_that_cannot_be_a_house_are_not_read(tmp_path):
    huge = tmp_path / "huge.json"
    with huge.open("wb") as file:
        file.truncate(MAX_JSON_BYTES + 1)
    binary = tmp_path / "binary.json"
    binary.write_bytes(b"\xff\xfe")
    for endless in (huge, "/dev/zero"):
        with pytest.raises(SpecError, match="larger than"):
            HouseSpec.load(endless)
    with pytest.raises(SpecError, match="not text in UTF-8"):
        HouseSpec.load(binary)
    with pytest.raises(SpecError, match="cannot be read"):
        HouseSpec.load(tmp_path / "missing.json")
