"""`lexis`: every command end to end on a small recording. Bad input gives exit status 2 and one line, never a traceback."""

import json
import os
import re
import signal
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from helpers.map_builder import build_map, corridor_with_offices

from lexis import cli
from lexis.commands import run
from lexis.config import Config, read_config
from lexis.datasets.dataset import DatasetConfig, open_dataset, write_dataset
from lexis.encoder.options import EncoderOptions
from lexis.errors import EncoderError
from lexis.files.tum_trajectory import read_tum, write_tum
from lexis.map.folder import load_map, save_map
from lexis.questions.calibration import Calibration, save_calibration
from lexis.slam import Slam
from lexis.types import Camera, EncoderId, Intrinsics, LoopEdge, Observation


class ColourEncoder:
    """Encodes an image by its mean colour; each room name is a colour of its own."""

    name = fingerprint = "colour"

    def encode_image(self, image):
        mean = image.reshape(-1, 3).mean(axis=0)
        return (mean / np.linalg.norm(mean)).astype(np.float32)

    def encode_rooms(self, names):
        return np.eye(3, dtype=np.float32)[: len(names)]

    def encode_texts(self, texts):
        colours = {"kitchen": [1, 0, 0], "office": [0, 1, 0], "something green": [0, 1, 0]}
        return np.array([colours.get(text, [0, 0, 1]) for text in texts], np.float32)


@pytest.fixture(autouse=True)
def encoders(monkeypatch):
    """Replaces all encoders by one; the fixture's value is the list of the names that were asked for."""
    asked = []

    def load(model, options=None):
        asked.append(model)
        if model == "gone":
            raise EncoderError("encoder 'gone': no model 'gone'")
        return ColourEncoder()

    monkeypatch.setattr("lexis.encoder.open_clip_encoder.load_encoder", load)
    return asked


@pytest.fixture
def dataset(rng, tmp_path):
    """A recording of eight metres forward, with red images at first and then green ones."""
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


@pytest.fixture
def mapped(dataset, tmp_path, capsys):
    """The map made from the recording."""
    assert cli.main(["run", str(dataset), "--rooms", "kitchen, office", "-o", str(tmp_path / "map")]) == 0
    capsys.readouterr()
    return tmp_path / "map"


@pytest.fixture
def calibration(tmp_path):
    path = tmp_path / "calibration.json"
    save_calibration(Calibration("colour", ("kitchen", "office"), base=0.8, slope=0.0, temperature=0.05), path)
    return path


def test_from_a_recording_to_a_map_a_plan_and_an_export(dataset, tmp_path, capsys):
    out, exported = tmp_path / "map", tmp_path / "map.json"
    assert cli.main(["run", str(dataset), "--rooms", "kitchen, office, garage", "-o", str(out)]) == 0
    assert [room.label for room in load_map(out).rooms] == ["kitchen", "office"]
    assert cli.main(["plan", str(out), "--from", "kitchen", "--to", "office"]) == 0
    assert cli.main(["export", str(out), "--format", "json", "-o", str(exported)]) == 0
    assert [room["name"] for room in json.loads(exported.read_text())["rooms"]] == ["kitchen", "office"]
    printed = capsys.readouterr()
    assert "kitchen (floor 0) to office (floor 0): " in printed.out and printed.err == ""
    assert "no room: garage\n" in printed.out and printed.out.endswith(f"{exported}\n")


@pytest.mark.parametrize("place", ["arrays.npz", "map.json", "new.json", "../linked/map.json"])
def test_nothing_is_written_into_a_map_that_is_read(mapped, tmp_path, capsys, place):
    (mapped.parent / "linked").symlink_to(mapped)
    before = {path: path.read_bytes() for path in mapped.iterdir()}
    out = str(mapped / place)
    for command in (
        ["export", str(mapped), "--format", "json", "-o", out],
        ["info", str(mapped), "--picture", f"{out}.svg"],
    ):
        assert cli.main(command) == 2
        assert "which is only read; valid: a place outside of it" in capsys.readouterr().err
    assert {path: path.read_bytes() for path in mapped.iterdir()} == before


def test_a_query_asks_the_encoder_of_the_map_and_lists_rooms_and_keyframes(mapped, encoders, calibration, capsys):
    query = ["query", str(mapped), "something green", "--keyframes", "2", "--top", "1", "--calibration", str(calibration)]
    assert cli.main(query) == 0
    printed = capsys.readouterr()
    assert encoders[-1] == "colour" and printed.err == ""
    room, *keyframes = printed.out.splitlines()
    assert re.match(r"office \(floor 0\) +probability 0\.[5-9]\d  similarity 0\.\d+  keyframe \d+$", room)
    assert len(keyframes) == 2 and all(line.startswith("keyframe ") and line.endswith("(floor 0)") for line in keyframes)


def test_a_query_says_when_nothing_fits(mapped, calibration, capsys):
    assert cli.main(["query", str(mapped), "an elephant", "--calibration", str(calibration)]) == 0
    assert capsys.readouterr().out == "nothing in this map fits (best: kitchen (floor 0), probability 0.00)\n"


def test_several_questions_are_answered_one_after_the_other(mapped, encoders, calibration, capsys):
    texts = ["something green", "an elephant"]
    options = ["--top", "1", "--calibration", str(calibration)]
    alone = []
    for text in texts:
        assert cli.main(["query", str(mapped), text, *options]) == 0
        alone.append(f"{text}:\n{capsys.readouterr().out}")
    loaded = len(encoders)
    assert cli.main(["query", str(mapped), *texts, *options]) == 0
    assert capsys.readouterr().out == "".join(alone) and len(encoders) == loaded + 1


def test_without_a_calibration_there_are_similarities_and_a_word_about_it(mapped, capsys):
    assert cli.main(["query", str(mapped), "an elephant"]) == 0
    printed = capsys.readouterr()
    assert len(printed.out.splitlines()) == 2 and printed.out.count("similarity") == 2
    assert printed.err.count("\n") == 1 and "no calibration" in printed.err


def test_other_names_need_no_recording(mapped, tmp_path, capsys):
    rooms = tmp_path / "rooms.json"
    rooms.write_text(json.dumps({"labels": ["hall", "shop", "depot"]}))
    assert cli.main(["relabel", str(mapped), "--rooms", str(rooms), "-o", str(tmp_path / "other")]) == 0
    assert [room.label for room in load_map(tmp_path / "other").rooms] == ["hall", "shop"]
    assert "rooms: hall, shop\nno room: depot\n" in capsys.readouterr().out


def test_a_note_says_which_map_will_be_replaced(mapped, tmp_path, capsys):
    out = tmp_path / "other"
    save_map(load_map(mapped), out)
    assert cli.main(["relabel", str(mapped), "--rooms", "kitchen,hall", "-o", str(out)]) == 0
    assert f"note: {out} holds an earlier result" in capsys.readouterr().err


def test_a_map_is_not_replaced_by_a_map_that_is_made_from_it(mapped, tmp_path, capsys):
    other, link = tmp_path / "other", tmp_path / "link"
    save_map(load_map(mapped), other)
    link.symlink_to(mapped)
    before = {path: path.read_bytes() for path in mapped.iterdir()}
    for command in (
        ["relabel", str(mapped), "--rooms", "kitchen,hall"], ["merge", str(mapped), str(other)],
        ["merge", str(other), str(mapped)],
    ):  # fmt: skip
        for out in (mapped, link):
            assert cli.main([*command, "-o", str(out)]) == 2
            assert f"{out}: is the folder that is read; valid: another one" in capsys.readouterr().err
    assert {path: path.read_bytes() for path in mapped.iterdir()} == before


def test_no_note_says_that_a_map_will_be_replaced_if_the_command_fails_at_once(mapped, dataset, tmp_path, capsys):
    out, none = ["-o", str(mapped)], str(tmp_path / "none")
    for command in (
        ["run", none, "--rooms", "kitchen"],
        ["run", str(dataset)],
        ["run", str(dataset), "--rooms", "kitchen,kitchen"],
        ["run", str(dataset), "--rooms", "kitchen", "--config", none],
        ["run", str(dataset), "--map", str(mapped)],
        ["merge", str(mapped), none],
        ["relabel", str(mapped), "--rooms", "kitchen,kitchen"],
        ["relabel", str(mapped), "--rooms", "kitchen", "--config", none],
        ["import", none],
    ):
        assert cli.main([*command, *out]) == 2
        assert capsys.readouterr().err.count("\n") == 1


def test_a_map_whose_encoder_is_gone_says_so(mapped, capsys):
    save_map(replace(load_map(mapped), encoder=EncoderId("gone", "1")), mapped)
    assert cli.main(["query", str(mapped), "x"]) == 2
    assert "made with encoder 'gone', which cannot be loaded" in capsys.readouterr().err


def test_info_prints_figures_or_json_and_draws(mapped, tmp_path, capsys):
    picture = tmp_path / "map.svg"
    assert cli.main(["info", str(mapped), "--picture", str(picture)]) == 0
    assert "\nkitchen       0" in capsys.readouterr().out and picture.read_text().startswith("<svg")
    assert cli.main(["info", str(mapped), "--json"]) == 0
    assert [room["name"] for room in json.loads(capsys.readouterr().out)["rooms"]] == ["kitchen", "office"]


def test_a_plan_leads_to_the_room_that_a_description_names(mapped, calibration, capsys):
    command = ["plan", str(mapped), "--from", "kitchen", "--calibration", str(calibration), "--json", "--to"]
    assert cli.main([*command, "office"]) == 0
    named = capsys.readouterr().out
    assert cli.main([*command, "something green"]) == 0
    assert capsys.readouterr().out == named


def test_a_room_with_a_number_that_does_not_exist_is_no_description(mapped, calibration, capsys):
    command = ["plan", str(mapped), "--from", "kitchen", "--calibration", str(calibration), "--to"]
    for goal in ("office 7", "office 0", "kitchen 99"):
        assert cli.main([*command, goal]) == 2
        assert f"{goal!r}" in capsys.readouterr().err


def test_a_description_without_a_calibration_is_no_goal(mapped, capsys):
    assert cli.main(["plan", str(mapped), "--from", "kitchen", "--to", "something green"]) == 2
    assert "need a calibration" in capsys.readouterr().err


def test_a_plan_prints_directions_and_on_demand_keyframes_or_json(mapped, capsys):
    command = ["plan", str(mapped), "--from", "kitchen", "--to", "office"]
    assert cli.main(command) == 0
    plain = capsys.readouterr().out.splitlines()
    assert plain[0].startswith("kitchen (floor 0) to office (floor 0): ")
    assert [line.split("m  ")[1] for line in plain[1:]] == [
        "start in kitchen (floor 0)",
        "enter office (floor 0)",
        "arrive in office (floor 0)",
    ]
    assert cli.main([*command, "--json"]) == 0
    ids = [keyframe["id"] for keyframe in json.loads(capsys.readouterr().out)["keyframes"]]
    assert cli.main([*command, "--keyframes"]) == 0
    listed = capsys.readouterr().out.splitlines()
    assert listed[: len(plain)] == plain and [int(line.split()[1]) for line in listed[len(plain) :]] == ids


def test_a_plan_is_made_with_the_settings_of_the_planner(rng, tmp_path, capsys):
    interrupted = np.array([0.0, 0.5, 4.5, 5.0])[:, None] * [1.0, 0.0, 0.0]
    rooms = [("office", [0]), ("corridor", [1, 2]), ("kitchen", [3])]
    save_map(build_map(interrupted, [0, 1, 1, 2], rooms, ("office", "corridor", "kitchen"), rng), tmp_path / "map")
    command = ["plan", str(tmp_path / "map"), "--from", "office", "--to", "kitchen"]
    assert cli.main(command) == 2 and "the walk was interrupted" in capsys.readouterr().err
    (tmp_path / "settings.json").write_text(json.dumps({"planner": {"shortcut_m": 4.5}}))
    assert cli.main([*command, "--config", str(tmp_path / "settings.json")]) == 0
    assert capsys.readouterr().out.startswith("office (floor 0) to kitchen (floor 0): 5.0 m")


def test_a_plan_avoids_all_rooms_that_are_named(rng, tmp_path, capsys):
    """The only way from the kitchen to the bathroom leads through the office."""
    names, positions = ("kitchen", "office", "bathroom"), 0.5 * np.arange(9)[:, None] * [1.0, 0.0, 0.0]
    rooms = [("kitchen", [0, 1, 2]), ("office", [3, 4, 5]), ("bathroom", [6, 7, 8])]
    save_map(build_map(positions, np.repeat([0, 1, 2], 3), rooms, names, rng), tmp_path / "map")
    command = ["plan", str(tmp_path / "map"), "--from", "kitchen", "--to", "bathroom"]
    assert cli.main(command) == 0
    assert cli.main([*command, "--avoid", "office"]) == 2
    capsys.readouterr()
    assert cli.main([*command, "--avoid", "garage", "--avoid", "office"]) == 2
    assert "garage" in capsys.readouterr().err


def test_the_printed_settings_are_settings(tmp_path, capsys):
    assert cli.main(["config"]) == 0
    (tmp_path / "settings.json").write_text(capsys.readouterr().out)
    assert read_config(tmp_path / "settings.json") == Config()


def test_options_of_a_run_reach_the_recording_the_encoder_and_the_map(dataset, tmp_path, monkeypatch):
    opened, loaded = [], []

    def load(model, options=None):
        loaded.append((model, options))
        return ColourEncoder()

    def open_recording(path, config):
        opened.append(config)
        return open_dataset(path)

    monkeypatch.setattr("lexis.encoder.open_clip_encoder.load_encoder", load)
    monkeypatch.setattr("lexis.datasets.dataset.open_dataset", open_recording)
    (tmp_path / "settings.json").write_text('{"keyframes": {"spacing_m": 2.0, "support_spacing_m": 1.0}}')
    command = ["run", str(dataset), "--rooms", "kitchen, office", "-o", str(tmp_path / "map")]
    options = ["--encoder", "other", "--cache", str(tmp_path / "cache"), "--precision", "bf16", "--device", "cpu"]
    options += ["--odometry", "wheels", "--camera", "cam1", "--config", str(tmp_path / "settings.json")]
    assert cli.main([*command, *options]) == 0
    assert opened == [DatasetConfig("wheels", "cam1")]
    assert loaded == [("other", EncoderOptions("cpu", "bf16", cache=tmp_path / "cache"))]
    assert len(load_map(tmp_path / "map").keyframes) == 5  # eight metres


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
        (["info", "{tmp}/nowhere"], "no map there"),
        (["info", "{tmp}/map", "--picture", "{tmp}/map.png"], "valid: a name that ends in .svg"),
        (["query", "{tmp}/map", "x"], "similarities across weights mean nothing"),
        (["query", "{tmp}/map", "x", "--calibration", "{tmp}/none"], "none: cannot be read"),
        (["relabel", "{tmp}/map", "--rooms", "a,a", "-o", "{tmp}/out"], "more than once"),
        (["relabel", "{tmp}/nowhere", "--rooms", "a", "-o", "{tmp}/out"], "no map there"),
        (["run", "{tmp}/run", "--rooms", "kitchen", "-o", "/proc/map"], "/proc/map: cannot be written"),
        (["run", "{tmp}/nowhere", "--rooms", "{tmp}/none.json", "-o", "{tmp}/out"], "nowhere: no dataset there"),
        (["run", "{tmp}/run", "--rooms", "{tmp}/none.json", "-o", "{tmp}/out"], "none.json: cannot be read"),
        (["query", "{tmp}/map", "x", "--top", "0"], "from 1"),
        (["export", "{tmp}/map", "--format", "ply", "-o", "{tmp}/x"], "invalid choice"),
        (["export", "{tmp}/map", "--format", "tum", "-o", "{tmp}/nowhere/x"], "cannot be written"),
        (["run", "{tmp}/run", "--rooms", "kitchen", "-o", "{tmp}/{long}"], "cannot be accessed"),
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


@pytest.mark.parametrize("buffering", [-1, 1], ids=["at the end", "line by line"])
@pytest.mark.parametrize("arguments", [["plan", "{map}", "--from", "office", "--to", "corridor"], ["--help"]])
def test_a_full_standard_output_is_one_line_and_exit_2(tmp_path, rng, capsys, monkeypatch, arguments, buffering):
    save_map(corridor_with_offices(rng), tmp_path / "map")
    with open("/dev/full", "w", encoding="utf-8", buffering=buffering) as full:
        monkeypatch.setattr(sys, "stdout", full)
        assert cli.main([argument.format(map=tmp_path / "map") for argument in arguments]) == 2
    error = capsys.readouterr().err
    assert error.startswith("lexis: standard output cannot be written: No space left") and error.count("\n") == 1


def test_no_standard_output_is_no_error(tmp_path, rng, monkeypatch):
    save_map(corridor_with_offices(rng), tmp_path / "map")
    monkeypatch.setattr(sys, "stdout", None)
    assert cli.main(["plan", str(tmp_path / "map"), "--from", "office", "--to", "corridor"]) == 0


@pytest.mark.parametrize(
    ("content", "says"),
    [
        ("[" * 200_000, "nested too deeply"),
        ('{"labels": [' * 50_000, "nested too deeply"),
        ("9" * 5000, "too many digits"),
        ('{"labels": {}}', 'has no list "labels"'),
        ("[]", 'has no list "labels"'),
        (" " * 2_000_000, "larger than 1 MB"),
    ],
)
def test_files_of_room_names_are_read_with_care(content, says, tmp_path, rng, capsys):
    (tmp_path / "rooms.json").write_text(content)
    save_map(corridor_with_offices(rng), tmp_path / "map")
    assert cli.main(["relabel", str(tmp_path / "map"), "--rooms", str(tmp_path / "rooms.json"), "-o", "out"]) == 2
    said = capsys.readouterr().err
    assert says in said and said.count("\n") == 1


@pytest.mark.parametrize("start", ["x" * 1_000_000, "x\n" * 1000])
def test_a_message_is_one_line_of_bounded_length(start, tmp_path, rng, capsys):
    save_map(corridor_with_offices(rng), tmp_path / "map")
    assert cli.main(["plan", str(tmp_path / "map"), "--from", start, "--to", "office"]) == 2
    said = capsys.readouterr().err
    assert (
        said.count("\n") == 1
        and len(said) <= 401
        and said.endswith("office 2, or a label for its nearest room; only --to takes a description\n")
    )
    with pytest.raises(SystemExit):
        cli.main(["export", str(tmp_path / "map"), "--format", start, "-o", "out"])
    said = capsys.readouterr().err
    assert said.count("\n") == 1 and len(said) <= 401 and said.endswith("see lexis export --help\n")


def test_names_of_files_need_not_be_text(tmp_path, rng):
    """This runs in a separate process, whose standard output is as strict about encoding as a terminal."""
    save_map(corridor_with_offices(rng), tmp_path / "map")
    out = os.fsencode(tmp_path) + b"/\xff.tum"
    line = [sys.executable, "-m", "lexis", "export", tmp_path / "map", "--format", "tum", "-o", out]
    done = subprocess.run(line, capture_output=True, env=os.environ | {"PYTHONIOENCODING": "utf-8:strict"})
    assert (done.returncode, done.stderr) == (0, b"") and os.path.exists(out)
    assert done.stdout.endswith(b"/\\udcff.tum\n")


def test_the_help_of_run_says_what_a_dataset_must_hold(capsys):
    with pytest.raises(SystemExit):
        cli.main(["run", "--help"])
    said = capsys.readouterr().out
    for name in ("rgb.txt", "odometry.tum", "camera.json", "mav0/cam0", "mav0/odom0", "metadata.yaml", "/odom"):
        assert name in said


@pytest.mark.parametrize(("loops", "says"), [(0, "0 loop edges"), (1, "1 loop edge"), (2, "2 loop edges")])
def test_a_count_of_one_is_singular(mapped, tmp_path, capsys, loops, says):
    edges = tuple(LoopEdge(8 + i, i, np.eye(4), np.eye(6), 20) for i in range(loops))
    candidates = tuple((edge.query, (edge.match,)) for edge in edges)
    looped = replace(load_map(mapped), loops=edges, loop_weights=np.ones(loops), candidates=candidates)
    save_map(looped, tmp_path / "looped")
    assert cli.main(["relabel", str(tmp_path / "looped"), "--rooms", "kitchen,hall", "-o", str(tmp_path / "other")]) == 0
    assert f"keyframes, {says}, rooms: " in capsys.readouterr().out


@pytest.fixture
def textured(rng, tmp_path):
    """A recording of four metres with key points in every image, none of which is seen twice."""
    poses = np.tile(np.eye(4), (41, 1, 1))
    poses[:, 0, 3] = 0.1 * np.arange(41)
    images = np.kron(rng.integers(0, 256, (41, 12, 16, 1), np.uint8), np.ones((1, 10, 10, 3), np.uint8))
    camera = Camera(Intrinsics(160, 120, 100.0, 100.0, 79.5, 59.5), np.eye(4))
    write_dataset(
        tmp_path / "textured", camera, [Observation(i, 0.1 * i, images[i], poses[i], 1e-6 * np.eye(6)) for i in range(41)]
    )
    return tmp_path / "textured"


def test_a_recording_in_millimetres_is_warned_of(dataset, tmp_path, capsys):
    words = ["--rooms", "kitchen, office", "-o", str(tmp_path / "map")]
    assert cli.main(["run", str(dataset), *words]) == 0 and "warning" not in capsys.readouterr().out
    stamps, poses = read_tum(dataset / "odometry.tum")
    poses[:, :3, 3] *= 1000.0
    write_tum(dataset / "odometry.tum", stamps, poses)
    assert cli.main(["run", str(dataset), *words]) == 0
    assert "warning: the camera moves at 1000 m/s on average; positions have to be in metres" in capsys.readouterr().out


def test_a_run_that_is_cut_off_leaves_the_last_complete_map(dataset, tmp_path, monkeypatch):
    process = Slam.process

    def cut_off(slam, observation):
        if observation.index == 60:
            raise KeyboardInterrupt
        process(slam, observation)

    monkeypatch.setattr(Slam, "process", cut_off)
    out = tmp_path / "map"
    assert cli.main(["run", str(dataset), "--rooms", "kitchen, office", "--save-every", "3", "-o", str(out)]) != 0
    saved = load_map(out)
    assert 3 <= len(saved.keyframes) <= 12 and len(saved.labels) == len(saved.keyframes)


def test_a_run_that_ends_at_an_image_that_cannot_be_read_leaves_the_map_until_then(dataset, tmp_path, capsys):
    """A recorder that is cut off often leaves half of an image."""
    damaged, out = dataset / "rgb" / "000060.png", tmp_path / "map"
    damaged.write_bytes(damaged.read_bytes()[:200])
    command = ["run", str(dataset), "--rooms", "kitchen, office", "-o", str(out)]
    assert cli.main(command) == 2
    told, error = capsys.readouterr().err.splitlines()
    assert told == f"lexis: the run ended early; {out} holds the map until then, 12 keyframes"
    assert error.endswith("000060.png: is not a readable PNG or JPEG")
    assert [k.observation_index for k in load_map(out).keyframes] == list(range(0, 60, 5))
    first = dataset / "rgb" / "000000.png"
    first.write_bytes(b"")
    assert cli.main([*command[:-1], str(tmp_path / "none")]) == 2
    assert len(capsys.readouterr().err.splitlines()) == 1 and not (tmp_path / "none").exists()


def test_a_run_that_ends_early_leaves_an_earlier_map_and_saves_its_part_beside_it(dataset, tmp_path, capsys):
    out = tmp_path / "map"
    command = ["run", str(dataset), "--rooms", "kitchen, office", "-o", str(out)]
    assert cli.main(command) == 0
    earlier = (out / "map.json").read_bytes()
    (dataset / "rgb" / "000060.png").write_bytes(b"")
    for beside in ("map-1", "map-2"):
        capsys.readouterr()
        assert cli.main(command) == 2
        assert (out / "map.json").read_bytes() == earlier and len(load_map(tmp_path / beside).keyframes) == 12
        told = f"lexis: the run ended early; {tmp_path / beside} holds the map until then, 12 keyframes; {out} is unchanged"
        assert told in capsys.readouterr().err.splitlines()


def signal_at_image_59(monkeypatch, number):
    """Let LEXIS get a signal while it processes the image 59."""
    process = Slam.process

    def signalled(slam, observation):
        if observation.index == 59:
            os.kill(os.getpid(), number)
        process(slam, observation)

    monkeypatch.setattr(Slam, "process", signalled)


def test_ctrl_c_ends_a_run_after_the_present_image_and_leaves_the_map_until_then(dataset, tmp_path, capsys, monkeypatch):
    signal_at_image_59(monkeypatch, signal.SIGINT)
    out = tmp_path / "map"
    assert cli.main(["run", str(dataset), "--rooms", "kitchen, office", "-o", str(out)]) == 130
    told = f"lexis: the run ended early; {out} holds the map until then, 12 keyframes\ninterrupted\n"
    assert capsys.readouterr().err == told
    assert [k.observation_index for k in load_map(out).keyframes] == list(range(0, 60, 5))
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


@pytest.mark.parametrize("handler", [signal.default_int_handler, signal.SIG_IGN], ids=["usual", "ignored"])
def test_sigterm_ends_a_run_as_ctrl_c_does_even_where_ctrl_c_is_ignored(dataset, tmp_path, capsys, monkeypatch, handler):
    signal_at_image_59(monkeypatch, signal.SIGTERM)
    out, before = tmp_path / "map", signal.signal(signal.SIGINT, handler)
    try:
        command = ["run", str(dataset), "--rooms", "kitchen, office", "--save-every", "3", "-o", str(out)]
        assert cli.main(command) == 130
    finally:
        signal.signal(signal.SIGINT, before)
    assert capsys.readouterr().err.endswith("interrupted\n") and len(load_map(out).keyframes) >= 9
    assert signal.getsignal(signal.SIGTERM) is signal.SIG_DFL


@pytest.mark.parametrize("step", ["finish", "save"])
@pytest.mark.parametrize("presses", [1, 2])
def test_one_ctrl_c_while_the_map_is_finished_or_saved_does_not_lose_it(
    dataset, tmp_path, capsys, monkeypatch, step, presses
):
    owner, name = (Slam, "finish") if step == "finish" else (run, "save_map")
    usual = getattr(owner, name)

    def interrupted(*arguments):
        for _ in range(presses):
            os.kill(os.getpid(), signal.SIGINT)
        return usual(*arguments)

    monkeypatch.setattr(owner, name, interrupted)
    out = tmp_path / "map"
    status = cli.main(["run", str(dataset), "--rooms", "kitchen, office", "-o", str(out)])
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    if presses == 1:
        assert status == 0 and capsys.readouterr().out.startswith(f"{len(load_map(out).keyframes)} keyframes")
    else:
        assert status == 130 and not out.exists()


def test_one_ctrl_c_while_the_map_of_a_damaged_recording_is_saved_does_not_lose_it(dataset, tmp_path, monkeypatch):
    finish = Slam.finish

    def interrupted(slam):
        os.kill(os.getpid(), signal.SIGINT)
        return finish(slam)

    monkeypatch.setattr(Slam, "finish", interrupted)
    (dataset / "rgb" / "000060.png").write_bytes(b"")
    out = tmp_path / "map"
    assert cli.main(["run", str(dataset), "--rooms", "kitchen, office", "-o", str(out)]) == 2
    assert len(load_map(out).keyframes) == 12


@pytest.mark.parametrize(
    ("start", "goal", "says"),
    [
        (
            "kitchen",
            "sauna",
            "no room 'sauna' in the map; valid: .*, a label for its nearest room, or a description of several words$",
        ),
        ("kitchen", "Ofice", r"no room 'Ofice' in the map \(did you mean 'office'\?\); valid: "),
        (
            "somewhere to cook",
            "kitchen",
            "no room 'somewhere to cook' .*, or a label for its nearest room; only --to takes a description$",
        ),
    ],
)
def test_an_unknown_room_says_which_option_takes_a_description(start, goal, says, mapped, capsys):
    assert cli.main(["plan", str(mapped), "--from", start, "--to", goal]) == 2
    assert re.search(says, capsys.readouterr().err.strip())


def test_a_session_elsewhere_becomes_a_part_of_its_own(textured, tmp_path, capsys):
    one, other, both, merged = (tmp_path / name for name in ("one", "other", "both", "merged"))
    assert cli.main(["run", str(textured), "--rooms", "kitchen, office", "-o", str(one)]) == 0
    assert "already holds" not in capsys.readouterr().err
    assert cli.main(["run", str(textured), "--map", str(one), "-o", str(both)]) == 0
    shown = capsys.readouterr()
    assert f"note: {one} already holds this recording; the new map will hold it twice" in shown.err
    saved = load_map(one)
    later = tuple(replace(keyframe, stamp=keyframe.stamp + 100.0) for keyframe in saved.keyframes)
    save_map(replace(saved, keyframes=later), other)
    assert cli.main(["merge", str(one), str(other), "-o", str(merged)]) == 0
    for out in (shown.out, capsys.readouterr().out):
        assert out.count("not recognised in the rest of the map: session 1") == 1
    n = len(load_map(one).keyframes)
    for folder in (both, merged):
        assert [keyframe.session for keyframe in load_map(folder).keyframes] == [0] * n + [1] * n
    assert cli.main(["info", str(both)]) == 0 and "not connected with session 0: 1" in capsys.readouterr().out
    for second in (one, both):
        assert cli.main(["merge", str(one), str(second), "-o", str(tmp_path / "twice")]) == 2
        assert "merge: both maps hold the image taken at 0.000 s; valid: maps of different" in capsys.readouterr().err


def test_a_session_needs_a_map_with_key_points_and_equal_room_names(dataset, textured, mapped, tmp_path, capsys):
    assert cli.main(["run", str(dataset), "--map", str(mapped), "-o", str(tmp_path / "both")]) == 2
    assert "the map has no key points to recognise places by; valid: a map that 'lexis run'" in capsys.readouterr().err
    assert cli.main(["run", str(textured), "--rooms", "kitchen, office", "-o", str(tmp_path / "one")]) == 0
    inside = ["run", str(dataset), "--map", str(mapped), "-o", str(mapped / "new")]
    assert cli.main(inside) == 2 and not (mapped / "new").exists()
    assert "is inside" in capsys.readouterr().err
    again = ["run", str(textured), "--map", str(tmp_path / "one"), "--rooms", "kitchen", "-o", str(tmp_path / "both")]
    assert cli.main(again) == 2
    assert "valid: equal names in equal order" in capsys.readouterr().err and not (tmp_path / "both").exists()
