"""`--rooms` takes names, or a JSON file with names; other files and folders are refused."""

import json

import pytest

from lexis.commands.arguments import room_names
from lexis.errors import LexisError


def test_names_and_files_with_names_are_read(tmp_path):
    (tmp_path / "rooms.json").write_text(json.dumps({"labels": ["kitchen", "stairs"]}))
    assert room_names(str(tmp_path / "rooms.json")) == room_names("kitchen, stairs") == ("kitchen", "stairs")
    assert room_names("kitchen/diner") == ("kitchen/diner",)
    assert len(room_names(",".join(["bedroom"] * 1000))) == 1000


def test_a_recording_or_another_file_is_not_the_name_of_a_room(tmp_path):
    (tmp_path / "rooms.json").write_text(json.dumps({"labels": ["kitchen"]}))
    with pytest.raises(LexisError, match=r"is a folder; valid: .*rooms\.json"):
        room_names(str(tmp_path))
    (tmp_path / "rooms.txt").write_text("kitchen")
    with pytest.raises(LexisError, match=r"is a file; valid: a file that ends with \.json"):
        room_names(str(tmp_path / "rooms.txt"))
