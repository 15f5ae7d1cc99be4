"""House specs: a JSON round trip is exact, and errors in JSON name the place."""

import json
import os
from pathlib import Path

import pytest

from worlds.errors import SpecError
from worlds.house import build_house
from worlds.presets import PRESETS, sample_house
from worlds.spec import HouseSpec, json_schema
from worlds.spec_errors import MAX_JSON_BYTES
from worlds.validation import validate

SQUARE = [[0, 0], [4, 0], [4, 3], [0, 3]]


def spec_json(**room):
    return json.dumps({"storeys": [{"rooms": [{"id": "a", "label": "kitchen", "polygon_m": SQUARE} | room]}]})


@pytest.mark.parametrize("preset", PRESETS)
def test_json_round_trip_is_the_identity(preset):
    spec = sample_house(preset, 11)
    assert HouseSpec.from_json(spec.to_json()) == spec
    assert HouseSpec.from_json(spec.to_json()).to_json() == spec.to_json()


@pytest.mark.parametrize("name", ["flat [  1   2 ]", 'a "quoted [ 1,  2 ]" name', 'back\\slash [ " 3,  4 ]'])
def test_json_keeps_every_character_of_names(name):
    data = json.loads(spec_json(id="a  b"))
    data["name"] = name
    data["storeys"][0]["rooms"].append({"id": "c", "label": "office", "polygon_m": [[4, 0], [8, 0], [8, 3], [4, 3]]})
    data["storeys"][0]["openings"] = [{"rooms": ["a  b", "c"], "kind": "door", "start_m": [4, 1], "end_m": [4, 2]}]
    spec = HouseSpec.from_json(json.dumps(data))
    assert HouseSpec.from_json(spec.to_json()) == spec and spec.name == name


def test_equal_houses_have_equal_texts():
    minus, plus = (HouseSpec.from_json(spec_json(polygon_m=[[zero, 0], [4, 0], [4, 3], [zero, 3]])) for zero in (-0.0, 0.0))
    assert minus == plus and minus.to_json() == plus.to_json()


def test_a_handwritten_house_needs_nothing_but_rooms():
    assert HouseSpec.from_json(spec_json()).room_labels == ("kitchen",)


@pytest.mark.parametrize(
    ("bad", "message"),
    [
        (spec_json(polygon_m=[[0, 0], [4, 0], [4, 3], [0.5, 2]]), "polygon_m (room 'a'): walls must run along x or y"),
        (spec_json(polygon_m=[[0, 0], [1e-9, 0], [1e-9, 3], [0, 3]]), "walls are at least 0.005 m long"),
        (spec_json(polygon_m=[[0, 0], [1000, 0], [1000, 1000], [0, 1000]]), "1000000 m²; at most 20000"),
        (json.dumps({"storeys": [{"rooms": [{"id": "a", "label": "office", "polygon_m": SQUARE}] * 2}]}), "repeated: a"),
        (json.dumps(json.loads(spec_json()) | {"schema_version": 1}), "no field 'schema_version'"),
    ],
)
def test_invalid_houses_are_refused(bad, message):
    with pytest.raises(SpecError) as error:
        HouseSpec.from_json(bad, source="my.json")
    assert message in str(error.value)


def test_an_opening_between_unknown_rooms_lists_the_known_ones():
    data = json.loads(spec_json())
    data["storeys"][0]["openings"] = [{"rooms": ["a", "b"], "kind": "door", "start_m": [0, 1], "end_m": [0, 2]}]
    with pytest.raises(SpecError, match=r"storeys\[0\].openings\[0\] names room 'b'; its storey's rooms are a"):
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
    pipe = tmp_path / "pipe.json"
    os.mkfifo(pipe)
    with pytest.raises(SpecError, match="larger than"):
        HouseSpec.load(huge)
    for endless in (pipe, "/dev/zero"):
        with pytest.raises(SpecError, match="cannot be read: is a device or a pipe"):
            HouseSpec.load(endless)
    with pytest.raises(SpecError, match="not text in UTF-8"):
        HouseSpec.load(binary)
    with pytest.raises(SpecError, match="cannot be read"):
        HouseSpec.load(tmp_path / "missing.json")


def test_the_published_schema_is_the_one_in_use():
    published = Path("worlds/house.schema.json").read_text(encoding="utf-8")
    assert json.loads(published) == json_schema(), "write worlds.spec.json_schema() to worlds/house.schema.json"


def leaves(node, schema, path="", description=""):
    """All numbers in a schema: the path, and all descriptions between the field and the number."""
    node = {**node, **schema["$defs"].get(node.get("$ref", "").rpartition("/")[2], {})}
    description += " " + node.get("description", "")
    if node.get("type") in ("number", "integer"):
        yield path, description
    for name, child in node.get("properties", {}).items():
        yield from leaves(child, schema, f"{path}.{name}")
    children = [*node.get("anyOf", ()), *node.get("prefixItems", ()), *([node["items"]] if "items" in node else [])]
    for child in children:
        yield from leaves(child, schema, path, description)


def test_every_number_of_the_schema_says_its_unit():
    schema = json_schema()
    numbers = list(leaves(schema, schema))
    assert len(numbers) >= 30
    assert [
        path for path, said in numbers if not any(unit in said for unit in ("[m]", "[rad]", "[1]", "seed", "counted"))
    ] == []


def test_the_example_of_the_documentation_is_a_house_of_two_rooms():
    readme = Path("worlds/README.md").read_text(encoding="utf-8")
    example = readme.split("```json\n")[1].split("```")[0]
    assert len(example.splitlines()) <= 15
    spec = HouseSpec.from_json(example)
    assert len(spec.storeys[0].rooms) == 2
    validate(build_house(spec))


def test_the_documentation_names_every_field():
    readme = Path("worlds/README.md").read_text(encoding="utf-8")
    schema = json_schema()
    objects = [schema, *schema["$defs"].values()]
    assert [name for o in objects for name in o["properties"] if f"`{name}`" not in readme] == []
