"""Every damaged file leads to one of the package's own errors, within limits on time and memory.

Damage is drawn with fixed seeds. The normal suite tries a few inputs of every kind, the nightly suite thousands.
"""

import contextlib
import json
import os
import shutil

import numpy as np
import pytest
from helpers import damage, small_inputs
from helpers.survey import MEMORY_BYTES, PROCESSOR_S, survey

from lexis import cli
from lexis.datasets.dataset import open_dataset
from lexis.errors import LexisError
from lexis.map.export import FORMATS, export_map
from lexis.map.folder import load_map, save_map
from lexis.map.interchange import read_spark_dsg
from lexis.planning import plan
from sim.cli import main as lexis_sim
from sim.errors import SimError
from sim.feature_sensor.model import load_features
from worlds.errors import WorldsError
from worlds.spec import HouseSpec
from worlds.validation import spec_problems

ERRORS = (LexisError, SimError, WorldsError)


@pytest.fixture(scope="module")
def inputs(tmp_path_factory):
    """Undamaged inputs of every kind, by the name of their file or folder."""
    folder = tmp_path_factory.mktemp("whole")
    small_inputs.write_all(folder)
    return folder


def many(smoke, nightly):
    """Numbers of inputs in the normal suite and in the nightly one."""
    return pytest.mark.parametrize("cases", [smoke, pytest.param(nightly, marks=pytest.mark.slow)])


def hold(found):
    """Assert that no foreign exception occurred, limits were kept, and at least a fifth of the damage was noticed."""
    print(found)
    assert not found.foreign, "\n".join([str(found), *found.examples[:20]])
    assert found.longest_s <= PROCESSOR_S and found.peak_bytes <= MEMORY_BYTES
    assert found.refused > 0.2 * found.tried


@many(50, 5000)
def test_damaged_houses(cases, tmp_path):
    whole = small_inputs.houses()

    def attempt(rng, folder):
        text = damage.damaged_json(rng, whole[rng.integers(len(whole))])
        (folder / "house.json").write_bytes(
            damage.damaged_bytes(rng, text.encode()) if rng.random() < 0.1 else text.encode()
        )
        spec = HouseSpec.load(folder / "house.json")
        for problem in spec_problems(spec):
            raise WorldsError(problem)

    hold(survey(attempt, cases, 1, ERRORS, tmp_path))


@many(50, 3000)
def test_damaged_maps(cases, inputs, tmp_path):
    with np.load(inputs / "map" / "arrays.npz") as whole:
        arrays = {name: whole[name] for name in whole.files}

    def attempt(rng, folder):
        shutil.copytree(inputs / "map", folder / "map")
        if rng.random() < 0.7:
            (folder / "map" / "arrays.npz").write_bytes(damage.damaged_npz(rng, arrays))
        else:
            damage.damaged_file(rng, folder / "map" / str(rng.choice(["map.json", "map.json", "arrays.npz"])))
        lexis_map = load_map(folder / "map")
        for form in FORMATS:  # an accepted file must be usable for everything
            export_map(lexis_map, form, folder / form)
        plan(lexis_map, "kitchen", "office")

    hold(survey(attempt, cases, 2, ERRORS, tmp_path))


@many(50, 3000)
def test_damaged_scene_graphs(cases, inputs, tmp_path):
    whole = json.loads((inputs / "graph.json").read_text())

    def attempt(rng, folder):
        text = damage.damaged_json(rng, whole).encode()
        (folder / "graph.json").write_bytes(damage.damaged_bytes(rng, text) if rng.random() < 0.1 else text)
        lexis_map = read_spark_dsg(folder / "graph.json")
        save_map(lexis_map, folder / "map")
        plan(load_map(folder / "map"), "kitchen", "office")

    hold(survey(attempt, cases, 6, ERRORS, tmp_path))


@many(50, 3000)
def test_damaged_feature_models(cases, inputs, tmp_path):
    with np.load(inputs / "features.npz") as whole:
        arrays = {name: whole[name] for name in whole.files}

    def attempt(rng, folder):
        path = folder / "features.npz"
        if rng.random() < 0.9:
            path.write_bytes(damage.damaged_npz(rng, arrays))
        else:
            shutil.copy(inputs / "features.npz", path)
            damage.damaged_file(rng, path)
        load_features(path)

    hold(survey(attempt, cases, 3, ERRORS, tmp_path))


@many(40, 1600)
def test_damaged_recordings(cases, inputs, tmp_path):
    def attempt(rng, folder):
        shutil.copytree(inputs / str(rng.choice(["tum", "euroc", "euroc", "bag", "mcap"])), folder / "run")
        files = [path for path in sorted(folder.rglob("*")) if path.is_file()]
        few = [path for path in files if path.suffix != ".png"]
        for path in rng.choice(few if rng.random() < 0.8 else files, 1 + int(rng.random() < 0.2), replace=False):
            damage.damaged_file(rng, path)
        for observation in open_dataset(folder / "run"):
            assert observation.image.shape == (24, 32, 3)

    hold(survey(attempt, cases, 4, ERRORS, tmp_path))


LEXIS = (
    ["run", "{whole}/tum", "--rooms", "kitchen,office", "-o", "{here}/out"],
    ["run", "{whole}/euroc", "--rooms", "{whole}/rooms.json", "-o", "{here}/out", "--odometry", "odom0", "--camera", "cam0"],
    ["run", "{whole}/bag", "--rooms", "kitchen,office", "-o", "{here}/out", "--device", "cpu", "--precision", "fp32"],
    ["plan", "{whole}/map", "--from", "kitchen", "--to", "office"],
    ["query", "{whole}/map", "a place to cook", "--top", "2", "--keyframes", "3", "--calibration", "{whole}/rooms.json"],
    ["relabel", "{whole}/map", "--rooms", "{whole}/rooms.json", "-o", "{here}/out"],
    ["export", "{whole}/map", "--format", "g2o", "-o", "{here}/out"],
    ["import", "{whole}/graph.json", "-o", "{here}/out"],
)
LEXIS_SIM = (
    ["house", "check", "{whole}/house.json"],
    ["house", "show", "{whole}/house.json", "-o", "{here}/plan.svg"],
    [
        "house",
        "variant",
        "{whole}/house.json",
        "--openness",
        "0.5",
        "--clutter",
        "1",
        "--rotate",
        "1",
        "-o",
        "{here}/v.json",
    ],
    ["house", "export", "{whole}/house.json", "-o", "{here}/h.geojson"],
    ["house", "import", "{whole}/house.geojson", "--snap", "0.1", "--seed", "3", "-o", "{here}/i.json"],
    ["house", "generate", "--rooms", "kitchen,bath", "--openness", "0.5", "--seed", "1", "-o", "{here}/g.json"],
    ["run", "--house", "{whole}/house.json", "--odometry", "mono", "--fault", "blur:0.5", "--out", "{here}/run"],
    ["run", "--fidelity", "features", "--feature-model", "{whole}/features.npz", "--preset", "home", "--out", "{here}/run"],
    ["record", "--house", "{whole}/house.json", "--rig", "wide", "--format", "tum", "--length", "5", "-o", "{here}/r"],
    ["bench", "planning", "--pictures", "{whole}/rooms.json", "--houses", "1"],
    ["calibrate-queries", "--houses", "1", "-o", "{here}/c.json"],
    ["fit-features", "--houses", "1", "-o", "{here}/f.npz"],
)
PLACES = ("{whole}/map", "{whole}/tum", "{whole}/house.json", "{whole}", "{here}/pipe", "{here}/loop", "/dev/zero")
NUMBERS = ("0", "-1", "1e9", "nan", "9" * 5000)
ODD = ("", " ", "-", "--", "--nonsense", "-o", *NUMBERS, "x" * 100_000, "a\nb", "%s{0}", "\udcff.json", ",,", "...")


class TinyEncoder:
    """An encoder with two dimensions, one for each of two rooms."""

    name = fingerprint = "tiny"

    def encode_image(self, image):
        return np.array([0.6, 0.8], np.float32)

    def encode_rooms(self, names):
        return np.tile(np.array([[0.6, 0.8]], np.float32), (len(names), 1))

    encode_texts = encode_rooms


@many(30, 400)
def test_bad_command_lines(cases, inputs, tmp_path, monkeypatch):
    """All work after reading the input is replaced: nothing is rendered, and no encoder is loaded."""

    def work(*_, **__):
        raise SimError("the work would begin here")

    monkeypatch.chdir(tmp_path)  # damaged lines may name an output folder without a path
    for user in ("lexis.commands.arguments", "lexis.commands.run"):
        monkeypatch.setattr(f"{user}.encoder_named", lambda model, options=None: TinyEncoder())
    for heavy in (
        "sim.harness.run",
        "sim.record.record",
        "lexis.encoder.open_clip_encoder.load_encoder",
        "sim.bench.planning.run",
    ):
        monkeypatch.setattr(heavy, work)

    def attempt(rng, folder):
        os.mkfifo(folder / "pipe")
        (folder / "loop").symlink_to("loop")
        own = bool(rng.random() < 0.5)
        templates = LEXIS if own else LEXIS_SIM
        line = [*templates[rng.integers(len(templates))]]
        for _ in range(rng.integers(0, 3)):
            _damage_line(rng, line)
        argv = [word.replace("{whole}", str(inputs)).replace("{here}", str(folder)) for word in line]
        status, said = _outcome(cli.main if own else lexis_sim, argv, folder)
        assert status in (0, 1, 2), f"status {status}"
        if status == 2:
            lines = said.splitlines()
            assert 1 <= len(lines) <= 25 and all(text.startswith("lexis") and len(text) <= 400 for text in lines), said[:200]
            raise LexisError(said)

    hold(survey(attempt, cases, 5, ERRORS, tmp_path))


def _damage_line(rng, line):
    i = int(rng.integers(len(line)))
    match int(rng.integers(5)):
        case 0 if len(line) > 1:
            del line[i]
        case 1:
            line.insert(i, line[rng.integers(len(line))])
        case 2:
            line[i] = PLACES[rng.integers(len(PLACES))]
        case _:
            line[i] = ODD[rng.integers(len(ODD))]


def _outcome(main, argv, folder):
    """The exit status, and all output on stderr including that of C libraries. The process is a child that ends soon."""
    with (
        (folder / "err").open("w+", errors="backslashreplace") as err,
        (folder / "out.txt").open("w", encoding="utf-8") as out,
    ):
        kept = os.dup(2)
        os.dup2(err.fileno(), 2)
        try:
            with contextlib.redirect_stderr(err), contextlib.redirect_stdout(out):
                status = main(argv)
        except SystemExit as end:
            status = end.code
        finally:
            os.dup2(kept, 2)
            os.close(kept)
        err.flush()
        return status, (folder / "err").read_text()
