"""Messages about invalid houses: one line, the place, the valid values; and in bounded time, however large the file."""

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from worlds.errors import SpecError
from worlds.spec import HouseSpec
from worlds.spec_errors import MAX_MISTAKES

SQUARE = [[0, 0], [4, 0], [4, 3], [0, 3]]
ROOM = {"id": "a", "label": "kitchen", "polygon_m": SQUARE}
DOOR = {"rooms": ["a", "a"], "kind": "door", "start_m": [0, 1], "end_m": [0, 2]}
SOFA = {"id": "f", "kind": "sofa", "room": "a", "position_m": [2, 1, 0], "yaw_rad": 0, "size_m": [2, 1, 1], "seed": 0}
JARGON = ("Input", "should", "validation", "pydantic", "dict", "tuple", "None", "Traceback")


def house(room=None, opening=None, piece=None, storey=None, top=None):
    data = {"rooms": [ROOM | (room or {})], "openings": [DOOR | (opening or {})], "furniture": [SOFA | (piece or {})]}
    return json.dumps({"storeys": [data | (storey or {})]} | (top or {}))


def refusal(text):
    with pytest.raises(SpecError) as error:
        HouseSpec.from_json(text, source="my.json")
    message = str(error.value)
    assert message.startswith("my.json: ") and "\n" not in message and len(message) < 600
    assert not any(word in message for word in JARGON)
    return message.removeprefix("my.json: ")


IN_ROOM = "storeys[0].rooms[0].polygon_m"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (house(room={"label": "kitchn"}), "[0].label (room 'a'): unknown label 'kitchn' (did you mean 'kitchen'?)"),
        (house().replace('"label"', '"lable"'), "storeys[0].rooms[0] (room 'a'): no field 'lable' (did you mean 'label'?)"),
        (house(room={"colour": "red"}), "rooms[0] (room 'a'): no field 'colour'; valid: id, label, polygon_m, seed"),
        (house().replace("4", "NaN", 1), f"{IN_ROOM}[1][0] (room 'a'): is not a number; valid: a number from -1000 to 1000"),
        (house().replace("4", "1e999", 1), f"{IN_ROOM}[1][0] (room 'a'): is infinite"),
        (house().replace("4", "true", 1), f"{IN_ROOM}[1][0] (room 'a'): is true; valid: a number"),
        (house().replace("4", '"4"', 1), f"{IN_ROOM}[1][0] (room 'a'): is '4'; valid: a number"),
        (house(room={"polygon_m": [*SQUARE, [1, 2, 3]]}), f"{IN_ROOM}[4] (room 'a'): has 3 items; valid: a list of 2"),
        (house(room={"polygon_m": [*SQUARE, [1]]}), f"{IN_ROOM}[4] (room 'a'): has 1 items; valid: a list of 2"),
        (house(room={"polygon_m": SQUARE[:3]}), f"{IN_ROOM} (room 'a'): has 3 items; valid: a list of 4 to 64"),
        (house(room={"id": "a/b"}), "storeys[0].rooms[0].id (room 'a/b'): is 'a/b'; valid: a name of 1 to 64 letters"),
        (house(opening={"kind": "dor"}), "storeys[0].openings[0].kind (opening 'a' - 'a'): is 'dor'; valid: door, cased"),
        (house(piece={"size_m": [-2, 1, 1]}), "furniture[0].size_m[0] (furniture 'f'): is -2; valid: a number above 0"),
        (house(storey={"height_m": 9}), "storeys[0].height_m: is 9; valid: a number above 2 and at most 6 [m]"),
        (house(top={"seed": -1}), "seed: is -1; valid: a whole number from 0 to 9223372036854775807"),
        (house(top={"schema": 2}), "schema: is 2; valid: 1"),
        ('{"storeys": [{"rooms": [{"id": "a", "label": "gym"}]}]}', f"{IN_ROOM} (room 'a'): is missing; valid: a list of 4"),
        ('{"storeys": []}', "storeys: has 0 items; valid: a list of 1 to 8, each an object with rooms"),
        ("[]", "is a list of 0; valid: an object with storeys"),
        ('{"format": "lexis-scenario", "seed": 7}', "is a file of the format 'lexis-scenario', and no house; valid: a"),
        ('{"seed": 1,\n"seed": 2}', "has the field 'seed' 2 times"),
        ('{"storeys":\n[,]}', "is not JSON: Expecting value at line 2 column 2"),
    ],
)
def test_each_mistake_is_told_in_plain_words_and_its_place(text, message):
    assert message in refusal(text)


def told(text):
    with pytest.raises(SpecError) as error:
        HouseSpec.from_json(text, source="my.json")
    lines = [str(error.value), *getattr(error.value, "__notes__", ())]
    assert all(line.startswith("my.json: ") and "\n" not in line and len(line) < 400 for line in lines)
    return [line.removeprefix("my.json: ") for line in lines]


def test_every_malformed_field_is_told_in_one_run():
    wrong_corners = [[0, 0], [4, "x"], [4, 3], [0, None]]
    lines = told(
        house(
            room={"polygon_m": wrong_corners, "id": "a/b"},
            opening={"kind": "dor", "end_m": [0]},
            piece={"size_m": [-2, 1, 1]},
            top={"seed": -1},
        )
        .replace('"position_m"', '"positon_m"')
        .replace('"yaw_rad": 0, ', "")
    )
    expected = (
        "seed: is -1; valid: a whole number",
        "storeys[0].rooms[0].id (room 'a/b'): is 'a/b'; valid: a name of 1 to 64",
        f"{IN_ROOM}[1][1] (room 'a/b'): is 'x'; valid: a number",
        f"{IN_ROOM}[3][1] (room 'a/b'): is null; valid: a number",
        "storeys[0].openings[0].kind (opening 'a' - 'a'): is 'dor'",
        "storeys[0].openings[0].end_m (opening 'a' - 'a'): has 1 items; valid: a list of 2",
        "storeys[0].furniture[0].yaw_rad (furniture 'f'): is missing; valid: a number",
        "storeys[0].furniture[0].size_m[0] (furniture 'f'): is -2; valid: a number above 0",
        "storeys[0].furniture[0] (furniture 'f'): no field 'positon_m' (did you mean 'position_m'?); valid:",
    )
    assert len(lines) == len(expected) and all(any(line.startswith(start) for line in lines) for start in expected), lines


def test_malformed_fields_of_several_rooms_and_storeys_are_all_told():
    data = json.loads(house(room={"label": "kitchn"}))
    data["storeys"][0]["rooms"].append(ROOM | {"id": "b", "label": "bedrom"})
    data["storeys"].append({"rooms": [ROOM | {"id": "c"}], "height_m": 9})
    assert [line.split(":")[0] for line in told(json.dumps(data))] == [
        "storeys[0].rooms[0].label (room 'a')",
        "storeys[0].rooms[1].label (room 'b')",
        "storeys[1].height_m",
    ]


def test_all_references_to_rooms_that_are_not_there_are_told():
    lines = told(house(opening={"rooms": ["a", "lost"]}, piece={"room": "away"}))
    assert lines == [
        "storeys[0].openings[0] names room 'lost'; its storey's rooms are a",
        "storeys[0].furniture[0] names room 'away'; its storey's rooms are a",
    ]


def test_the_number_of_further_malformed_fields_is_reported():
    lines = told(json.dumps({"storeys": [{"rooms": [ROOM | {"id": f"a{i}", "seed": -1} for i in range(32)]}]}))
    assert len(lines) == MAX_MISTAKES + 1 == 21 and lines[-1] == "and 12 more malformed fields"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[" * 100_000, "nested too deeply"),
        ("[" * 200_000 + "]" * 200_000, "nested too deeply"),
        (house(room={"polygon_m": 7}).replace("7", "[" * 500 + "]" * 500), "nested too deeply"),
        ('{"storeys":' * 100_000, "nested too deeply"),
        (" " * 16_000_001, "larger than 16 MB"),
        ('{"storeys": [' + "{}," * 3_000_000 + "{}]}", "more than 2000000 values"),
        ('{"storeys": [{"rooms": [' + "{}," * 999_999 + "{}]}]}", "rooms: has 1000000 items; valid: a list of 1 to 200"),
        ('{"seed": ' + "9" * 1_000_000 + "}", "more digits"),
        (json.dumps({"storeys": [{"rooms": [{}] * 200, "furniture": [{}] * 4000}] * 8}), "rooms[0].id: is missing"),
        (json.dumps({f"field {i}": i for i in range(100_000)}), "100000 fields"),
    ],
    ids=[
        "deep lists",
        "deep closed lists",
        "deep in a room",
        "deep objects",
        "large",
        "many values",
        "a million rooms",
        "digits",
        "all wrong",
        "many fields",
    ],
)
def test_what_is_huge_is_refused_before_it_costs_much(text, message):
    assert message in refusal(text)


BITS = st.recursive(
    st.none()
    | st.booleans()
    | st.integers()
    | st.floats()
    | st.text()
    | st.sampled_from(["a", "kitchen", "door", "stairs"]),
    lambda inner: (
        st.lists(inner, max_size=4) | st.dictionaries(st.sampled_from([*ROOM, *DOOR, *SOFA, "leaf"]), inner, max_size=4)
    ),
    max_leaves=6,
)


@given(st.data())
def test_nothing_but_spec_errors_comes_out(data):
    spec = json.loads(house())
    node, path = spec, []
    while isinstance(node, dict | list) and len(node) and (not path or data.draw(st.booleans())):
        key = (
            data.draw(st.sampled_from(sorted(node))) if isinstance(node, dict) else data.draw(st.integers(0, len(node) - 1))
        )
        path.append((node, key))
        node = node[key]
    parent, key = path[-1]
    parent[key] = data.draw(BITS)
    try:
        HouseSpec.from_json(json.dumps(spec))
    except SpecError as error:
        assert "\n" not in str(error)
        assert not any(word in str(error) for word in JARGON if word not in json.dumps(spec))
