"""`lexis`: every command end to end on a small recording; exit 2 with one line for bad input, never a traceback."""

import json
from dataclasses import replace

import numpy as np
import pytest
from map_builder import corridor_with_offices

from lexis import cli
from lexis.datasets import write_dataset
from lexis.map_io import load_map, save_map
from lexis.types import Camera, Intrinsics, Observation


class ColourEncoder:
    """Sees the mean colour; rooms are colours of their own."""

    name = fingerprint = "colour"

    def encode_image(self, image):
        mean = image.reshape(-1, 3).mean(axis=0)
        return (mean / np.linalg.norm(mean)).astype(np.float32)

    def encode_rooms(self, names):
        return np.eye(3, dtype=np.float32)[: len(names)]

    def encode_texts(self, texts):
        return np.tile(np.array([0, 0, 1], np.float32), (len(texts), 1))


@pytest.fixture(autouse=True)
def encoder(monkeypatch):
    monkeypatch.setattr(cli, "_encoder", lambda model, options=None: ColourEncoder())


@pytest.fixture
def dataset(rng, tmp_path):
    """Eight metres forward: red at first, then green."""
    poses = np.tile(np.eye(4), (81, 1, 1))
    poses[:, 0, 3] = 0.1 * np.arange(81)
    images = rng.integers(0, 60, (81, 48, 64, 3), dtype=np.uint8)
    images[:40, ..., 0] += 190
    images[40:, ..., 1] += 190
    camera = Camera(Intrinsics(64, 48, 40.0, 40.0, 31.5, 23.5), np.eye(4))
    write_dataset(
        tmp_path / "run", camera, [Observation(i, 0.1 * i, images[i], poses[i], 1e-6 * np.eye(6)) for i in range(81)]
    )
    return tmp_path / "run"


def test_from_a_recording_to_a_map_a_plan_an_answer_and_an_export(dataset, tmp_path, capsys):
    out = tmp_path / "map"
    assert cli.main(["run", str(dataset), "--rooms", "kitchen, office", "-o", str(out)]) == 0
    assert [room.label for room in load_map(out).rooms] == ["kitchen", "office"]
    assert cli.main(["plan", str(out), "--from", "kitchen", "--to", "office"]) == 0
    assert cli.main(["query", str(out), "something green", "--top", "1"]) == 0
    assert cli.main(["export", str(out), "--format", "json", "-o", str(tmp_path / "map.json")]) == 0
    assert [room["name"] for room in json.loads((tmp_path / "map.json").read_text())["rooms"]] == ["kitchen", "office"]
    printed = capsys.readouterr()
    assert "kitchen (floor 0) to office (floor 0): " in printed.out and printed.err == ""


@pytest.mark.parametrize(
    ("floor", "says"), [(2, "office 1 (floor 2) to office 1 (floor 2)"), (None, "office 1 (between floors) to office 1 (")]
)
def test_a_plan_says_which_rooms_on_which_floors_it_joins(rng, tmp_path, capsys, floor, says):
    lexis_map = corridor_with_offices(rng)
    rooms = (lexis_map.rooms[0], replace(lexis_map.rooms[1], floor=floor), lexis_map.rooms[2])
    save_map(replace(lexis_map, rooms=rooms), tmp_path / "map")
    assert cli.main(["plan", str(tmp_path / "map"), "--from", "office", "--to", "office 1"]) == 0
    assert says in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["run", "{tmp}/nowhere", "--rooms", "kitchen", "-o", "{tmp}/out"], "nowhere: no dataset there"),
        (["run", "{tmp}/run", "--rooms", "kitchen,,office", "-o", "{tmp}/out"], "room names"),
        (["run", "{tmp}/run", "--rooms", "kitchen,kitchen", "-o", "{tmp}/out"], "more than once"),
        (["run", "{tmp}/run", "--rooms", "kitchen", "-o", "{tmp}/run"], "holds no map.json"),
        (["run", "{tmp}/run", "-o", "{tmp}/out"], "--rooms"),
        (["plan", "{tmp}/nowhere", "--from", "office", "--to", "corridor"], "no map there"),
        (["plan", "{tmp}/map", "--from", "garage", "--to", "corridor"], "valid: corridor, office 1, office 2"),
        (["query", "{tmp}/map", " "], "blank"),
        (["query", "{tmp}/map", "x"], "16 dimensions, the encoder's 3"),
        (["query", "{tmp}/map", "x", "--top", "0"], "from 1"),
        (["export", "{tmp}/map", "--format", "spark-dsg", "-o", "{tmp}/x"], "invalid choice"),
        (["export", "{tmp}/map", "--format", "tum", "-o", "{tmp}/nowhere/x"], "cannot be written"),
        (["run", "{tmp}/run", "--rooms", "kitchen", "-o", "{tmp}/{long}"], "cannot be looked into"),
        (["run", "{tmp}/{long}", "--rooms", "kitchen", "-o", "{tmp}/out"], "no dataset there"),
        (["plan", "{tmp}/{long}", "--from", "office", "--to", "corridor"], "no map there"),
        (["export", "{tmp}/map", "--format", "tum", "-o", "{tmp}/{long}"], "cannot be written"),
        (["fly"], "invalid choice"),
        ([], "COMMAND"),
    ],
)
def test_bad_input_is_one_line_and_exit_2(dataset, tmp_path, rng, capsys, arguments, says):
    save_map(corridor_with_offices(rng), tmp_path / "map")
    try:
        status = cli.main([argument.format(tmp=tmp_path, long="a" * 300) for argument in arguments])
    except SystemExit as left:
        status = left.code
    printed = capsys.readouterr()
    assert status == 2
    assert says in printed.err and printed.err.count("\n") == 1 and printed.err.startswith("lexis")
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("command", ["run", "plan", "query", "export"])
def test_help_has_an_example(command, capsys):
    with pytest.raises(SystemExit) as left:
        cli.main([command, "--help"])
    assert left.value.code == 0
    assert f"lexis {command} " in capsys.readouterr().out.split("example:")[1]
