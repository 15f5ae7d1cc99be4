"""`lexis-sim`: bad input gives one line and exit status 2, and leaves no files behind."""

import json
import math
import re
import subprocess
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest
from helpers.command_line import status_of

from lexis.config import Config, PlannerConfig
from lexis.files.replace import write_contents
from sim.bench.odometry import OdometryRow
from sim.bench.peers.difficulty_sweep import SweepRow
from sim.bench.peers.labels import LabelRow
from sim.bench.peers.room_methods import MethodRow
from sim.bench.peers.trajectories import TrajectoryRow
from sim.bench.pose_graphs.kernels import KernelRow
from sim.bench.rigs import RigRow
from sim.bench.segmentation import SegmentationRow
from sim.bench.speed import Section, SpeedFigure
from sim.bench.stage_costs import StageRow
from sim.cli import main
from sim.commands.run import DEMO_SEED
from sim.errors import SimError
from sim.faults import FAULTS, parse_fault
from sim.harness import Scenario
from sim.harness.run_settings import tour_config
from sim.odometry.imu import ImuConfig
from sim.render.lens import Distortion
from sim.render.rig import RigConfig, build_rig
from sim.tours.tour import TourConfig
from worlds.house import build_house
from worlds.presets import sample_from_rooms, sample_house
from worlds.spec import HouseSpec


@pytest.mark.parametrize(
    ("argv", "hint"),
    [
        (["run", "--preset", "castle"], "valid: home, ori"),
        (["run", "--odometry", "gps"], "valid: perfect"),
        (["run", "--house", "missing.json"], "missing.json"),
        (["run", "--house", "broken.json"], "broken.json"),
        (["run", "--encoder", "no-such-model"], "mini"),
        (["run", "--seed", "-1"], "whole number"),
        (["run", "--out", "file.txt/inside"], "valid"),
        (["run", "--out", "file.txt"], "file.txt: is a file; valid: the name of a folder"),
        (["run", "--out", "/proc/nowhere"], "valid"),
        (["run", "--out", "occupied"], "valid"),
        (["run", "--out", ""], "the name of a folder"),
        (["run", "--out", "loop"], "loop"),
        (["run", "--out", 300 * "a"], "File name too long; valid: the name of a folder"),
        (["orb-vocabulary", "--out", 300 * "a"], "cannot be written: File name too long; valid: a file in a folder"),
        (["house", "variant", "loop", "-o", "loop"], "loop"),
        (["record", "--out", f"occupied/{300 * 'a'}/recording"], "File name too long; valid: the name of a folder"),
        (["demo", "--out", "/proc/nowhere"], "cannot be written"),
        (["train-encoder", "--work", "/proc/nowhere"], "/proc/nowhere: cannot be written"),
        (["train-encoder", "--work", "occupied", "--out", "file.txt/mini"], "file.txt: cannot be written"),
        (["house", "generate", "--rooms", "kitchen,dungeon", "-o", "h.json"], "valid: kitchen"),
        (["house", "generate", "--rooms", "", "-o", "h.json"], "valid"),
        (["house", "generate", "-o", "no/such/folder/h.json"], "valid"),
        (["house", "check", "broken.json"], "broken.json"),
        (["bench", "speed", "--preset", "castle"], "home"),
        (["bench", "planning", "--pictures", "file.txt"], "file.txt: is a file; valid: the name of a folder"),
        (["bench", "odometry", "--cases", "lost"], "unknown case 'lost'; valid: 'multicam', 'mono', 'degraded'"),
        (["bench", "planning", "--drivers", "LEXIS, deaf"], "valid: 'truth', 'LEXIS', 'odometry', 'LEXIS, blind'"),
        (["bench", "stages", "--presets", "home", "ori", "home"], "--presets: 'home' is given twice; valid: each name once"),
        (["bench", "rigs", "--rigs", "four", "four"], "--rigs: 'four' is given twice"),
        (["bench", "openness", "--values", "0", "0.5", "0.0"], "--values: 0 is given twice; valid: each number once"),
        (["bench", "sweep"], "required: DIFFICULTY"),
        (["completion"], "required: SHELL"),
        (["bench", "encoders", "--work", "/proc/nowhere"], "/proc/nowhere: cannot be written"),
        (["bench", "all", "--out", "a" * 300], "File name too long; valid: the name of a folder"),
        (["bench", "openness", "--out", "a" * 300 + ".csv"], "cannot be written: File name too long"),
        (["run", "--house", "/dev/zero"], "/dev/zero: cannot be read: is a device or a pipe"),
        (["run", "--preset", "hom"], "unknown preset 'hom' (did you mean 'home'?); valid: home"),
        (["run", "--odometry", "multicm"], "unknown odometry 'multicm' (did you mean 'multicam'?); valid: perfect"),
        (["run", "--rig", "sterio"], "unknown rig 'sterio' (did you mean 'stereo'?); valid: wide"),
        (["house", "generate", "--rooms", "kitchn", "-o", "h.json"], "a 'kitchn' (did you mean 'kitchen'?); valid: kitchen"),
        (["house", "prove", "--preset", "skool"], "unknown preset 'skool' (did you mean 'school'?); valid: home"),
        (["run", "--overconfidence", "0.5"], "--overconfidence: '0.5'; valid: a number from 1 (honest) to 1e+06"),
        (["run", "--overconfidence", "nan"], "--overconfidence: 'nan'; valid: a number from 1 (honest)"),
        (["record", "--length", "-5"], "--length: '-5'; valid: a number from 1 to 100000"),
        (["record", "--rate", "0"], "--rate: '0'; valid: a number from 2 to 120"),
        (["record", "--lever-arm", "1,2"], "--lever-arm: '1,2'; valid: numbers X,Y,Z[,ROLL,PITCH,YAW]"),
        (["record", "--lever-arm", "1,2,nan"], "--lever-arm: '1,2,nan'; valid: numbers"),
        (["record", "--lever-arm", "1,0,0"], "up to 0.15 m from the IMU"),
        (["record", "--distortion=-0.3"], "--distortion: '-0.3'; valid: numbers K1,K2,P1,P2, or barrel"),
        (["record", "--distortion=-2,0,0,0"], "valid: weaker coefficients, or a narrower field of view"),
        (["record", "--imu-bias", "-1"], "--imu-bias: '-1'; valid: a number from 0 to 10"),
        (["run", "--tour", "scenic"], "both-ways"),
        (["run", "--sway", "drunken"], "hand-held"),
        (["record", "--length", "far"], "--length: 'far'; valid: a number from 1 to 100000"),
        (["house", "gallery", "--houses", "99999999999", "-o", "g.png"], "valid: a whole number from 1 to 1000"),
        (["house", "gallery", "--houses", "1", "-o", "g.pdf"], "valid: a name that ends in .png"),
        (["house", "import", "plan.svg", "--snap", "9", "-o", "h.json"], "--snap: '9'; valid: a number from 0.001 to 0.3"),
        ([], "COMMAND"),
        (["fly"], "demo"),
    ],
)
def test_bad_input(argv, hint, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "broken.json").write_text('{"storeys": [{"rooms": 3}]}')
    (tmp_path / "file.txt").write_text("a file, not a folder")
    (tmp_path / "loop").symlink_to("loop")
    (tmp_path / "occupied").mkdir()
    (tmp_path / "occupied" / "thesis.txt").write_text("years of work")
    before = sorted(tmp_path.rglob("*"))
    assert status_of(argv) == 2
    printed = capsys.readouterr()
    assert hint in printed.err and printed.err.count("\n") == 1 and "Traceback" not in printed.err and printed.out == ""
    assert sorted(tmp_path.rglob("*")) == before


@pytest.mark.parametrize(
    ("module", "heavy"), [("sim.cli", {"torch", "open_clip", "mujoco", "gtsam"}), ("sim.harness", {"torch", "open_clip"})]
)
def test_help_and_runs_without_pixels_wait_for_nothing_heavy(module, heavy):
    """This runs in a separate process, because here everything is already imported."""
    code = f"import sys, {module}; print(*{heavy} & set(sys.modules))"
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split() == []


def test_the_seed_of_a_run_is_the_harness_s():
    assert Scenario().seed == DEMO_SEED


def test_generated_houses_check_and_show(tmp_path, capsys):
    house, plan = tmp_path / "home.json", tmp_path / "home.png"
    assert status_of(["house", "generate", "--preset", "home", "--seed", 3, "-o", house]) == 0
    assert HouseSpec.load(house) == sample_house("home", 3)
    assert status_of(["house", "check", house]) == 0
    assert status_of(["house", "show", house, "-o", plan]) == 0
    assert plan.read_bytes().startswith(b"\x89PNG")


def test_a_house_that_cannot_be_walked_fails_its_check(tmp_path, capsys):
    data = json.loads(sample_house("home", 3).to_json())
    data["storeys"][0]["openings"] = [o for o in data["storeys"][0]["openings"] if "kitchen 0.1" not in o["rooms"]]
    house = tmp_path / "closed.json"
    house.write_text(json.dumps(data))
    assert status_of(["house", "check", house]) == 1
    assert "kitchen 0.1" in capsys.readouterr().out
    assert build_house(HouseSpec.load(house))


@pytest.mark.parametrize(("side", "status"), [(0.3, 1), (140.0, 0)])
def test_houses_of_any_size_are_drawn(side, status, tmp_path):
    room = {"id": "a", "label": "office", "polygon_m": [[0, 0], [side, 0], [side, side], [0, side]]}
    house, plan = tmp_path / "house.json", tmp_path / "plan.png"
    house.write_text(json.dumps({"storeys": [{"rooms": [room], "furniture": []}]}))
    assert status_of(["house", "check", house]) == status
    assert status_of(["house", "show", house, "-o", plan]) == 0
    assert cv2.imread(str(plan)).size < 4e7


def test_a_house_that_cannot_be_built_fails_its_check(tmp_path, capsys):
    room = {"id": "a", "label": "office", "polygon_m": [[0, 0], [0, 4], [4, 4], [4, 0]]}
    house = tmp_path / "clockwise.json"
    house.write_text(json.dumps({"storeys": [{"rooms": [room]}]}))
    assert status_of(["house", "check", house]) == 1
    assert "counter-clockwise" in capsys.readouterr().out
    assert status_of(["house", "show", house, "-o", tmp_path / "plan.png"]) == 2


def test_a_benchmark_shows_a_figure_that_a_house_does_not_have(monkeypatch, capsys):
    row = SegmentationRow(0.5, 0.5, 0.5, 1.0, 0.2, 0.1, 1.0, 0, 0, loop_recall=None, plans=1.0, spl=0.9, touched=0)
    monkeypatch.setattr("sim.bench.segmentation.run_houses", lambda scenario, seeds, *rest: ((seed, row) for seed in seeds))
    assert status_of(["bench", "segmentation", "--houses", "2"]) == 0
    assert "–" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("options", "fidelity", "rate_hz", "values"),
    [
        ([], "features", 2.0, 4),
        (["--fidelity", "render"], "render", 10.0, 4),
        (["--values", "0", "0.5"], "features", 2.0, 2),
    ],
)
def test_rooms_against_openness_are_measured_at_the_fidelity_that_is_asked_for(
    options, fidelity, rate_hz, values, monkeypatch, capsys
):
    walked = []
    run_nothing = "sim.bench.peers.difficulty_sweep.run_side_by_side"
    monkeypatch.setattr(run_nothing, lambda scenario, slams: walked.append(scenario) or {})
    assert status_of(["bench", "openness", "--houses", "1", *options]) == 0
    assert {(scenario.fidelity, scenario.frame_rate_hz) for scenario in walked} == {(fidelity, rate_hz)}
    assert len(walked) == values
    assert fidelity in capsys.readouterr().out


@pytest.mark.parametrize(
    ("benchmark", "results"),
    [
        ("rooms", {"peers.room_methods.compare_methods": [MethodRow("a", *[None] * 5)]}),
        ("openness", {"peers.difficulty_sweep.sweep": [SweepRow("home", "features", "a", 0.0, 1, *[None] * 4)]}),
        ("table2", {"peers.labels.compare_labels": [[LabelRow("home", 1, "a", None, None)]]}),
        ("stages", {"stage_costs.measure_stages": [[StageRow("home", 0, "nothing", *[math.nan] * 4)]]}),
        ("settings", {"peers.responses.measure_responses": [[StageRow("home", 0, "nothing", *[math.nan] * 4)]]}),
        ("odometry", {"odometry.measure_odometry": [OdometryRow("mono", 1, *[None] * 4, 3, 1, False)]}),
        ("rigs", {"rigs.measure_rigs": [RigRow("wide", 1, 0, 0, 3, 0, None, None, None, 9.0)]}),
        (
            "kernels",
            {
                "pose_graphs.kernels.mapped_houses": [],
                "pose_graphs.kernels.summarised": [KernelRow("local", 0.0, "dcs", 1, *[None] * 7)],
            },
        ),
    ],
)
def test_a_benchmark_of_figures_that_no_house_has_shows_dashes_and_no_zeros(benchmark, results, monkeypatch, capsys):
    for name, result in results.items():
        monkeypatch.setattr(f"sim.bench.{name}", lambda *_, result=result: iter(result))
    assert status_of(["bench", benchmark]) == 0
    shown = capsys.readouterr().out
    assert "–" in shown and not re.search(r"None|nan|0\.000|0\.0%|[│(±] ?0\.0", shown)


ONE_HOUSE = {
    "openness": ("peers.difficulty_sweep.sweep", [SweepRow("home", "features", "a", 0.0, 500, 0.5, 0.5, 1, 1)]),
    "table2": ("peers.labels.compare_labels", [[LabelRow("home", 500, "a", 0.5, 0.5)]]),
    "table3": ("peers.trajectories.compare_trajectories", [TrajectoryRow("home", 500, "LEXIS", 0.5, 0.7)]),
    "stages": ("stage_costs.measure_stages", [[StageRow("home", 500, "nothing", *[0.5] * 4)]]),
    "settings": ("peers.responses.measure_responses", [[StageRow("home", 500, "nothing", *[0.5] * 4)]]),
}


@pytest.mark.parametrize("benchmark", ONE_HOUSE)
def test_one_house_has_no_spread_and_one_seed(benchmark, monkeypatch, capsys):
    name, result = ONE_HOUSE[benchmark]
    monkeypatch.setattr(f"sim.bench.{name}", lambda *_: iter(result))
    assert status_of(["bench", benchmark, "--houses", "1", "--seed", "500"]) == 0
    shown = capsys.readouterr().out
    assert "± –" in shown and "± 0" not in shown and "seed 500," in shown and "seeds" not in shown


def test_a_method_without_an_error_has_dashes_in_table_3(monkeypatch, capsys):
    rows = [TrajectoryRow("home", 1, "LEXIS", None, None)]
    monkeypatch.setattr("sim.bench.peers.trajectories.compare_trajectories", lambda *_: rows)
    assert status_of(["bench", "table3"]) == 0
    assert re.search(r"LEXIS +│ – \(–\)", capsys.readouterr().out)


SECTION = Section("scene", "ms", (SpeedFigure("House to MjModel", 1.0, 2.0, 3, "<= 500"),))


def test_units_of_the_speed_benchmark_are_shown(monkeypatch, capsys):
    monkeypatch.setattr("sim.bench.speed.measure_speed", lambda preset, houses, seed: [SECTION])
    assert status_of(["bench", "speed"]) == 0
    assert re.search(r"step.*median \[ms\].*worst \[ms\].*runs \[count\]", capsys.readouterr().out)


def test_doctor_is_content_on_a_machine_with_memory_and_two_cores(monkeypatch, capsys):
    monkeypatch.setattr("sim.doctor.available_bytes", lambda: 4 << 30)
    monkeypatch.setattr("sim.doctor.usable_cores", lambda: 2)
    assert status_of(["doctor"]) == 0
    assert "FIX" not in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--fault", "fog"], "unknown fault 'fog'; valid: dropped"),
        (["--fault", "bluer:9"], "unknown fault 'bluer' (did you mean 'blur'?); valid: dropped"),
        (["--fault", "blur:9,for=2"], "'for' is no field of blur (did you mean 'for_s'?); valid: pixels, at_s, for_s"),
        (["--fault", "dropped:2"], "share is 2.0; valid: 0 to 1"),
        (["--fault", "dropped:0.1,share=0.2"], "share is given twice; valid: once"),
    ],
)
def test_bad_faults_cost_one_line(arguments, message, capsys):
    assert main(["run", *arguments]) == 2
    error = capsys.readouterr().err
    assert message in error and error.count("\n") == 1


@pytest.mark.parametrize(("command", "marker"), [("demo", "result.json"), ("run", "result.json"), ("record", "rooms.json")])
def test_what_will_be_replaced_is_said_before_the_work(command, marker, tmp_path, monkeypatch, capsys):
    def work(*_, **__):
        raise SimError("so far")

    monkeypatch.setattr("sim.harness.run", work)
    monkeypatch.setattr("sim.record.record", work)
    assert status_of([command, "--out", tmp_path]) == 2
    assert capsys.readouterr().err == "lexis-sim: so far\n"
    (tmp_path / marker).write_text("{}")
    write_contents(tmp_path)
    assert status_of([command, "--out", tmp_path]) == 2
    note = f"note: {tmp_path} holds an earlier result; the new one will replace it\n"
    assert capsys.readouterr().err == f"{note}lexis-sim: so far\n"


@pytest.mark.parametrize(("command", "work"), [("run", "sim.harness.run"), ("record", "sim.record.record")])
def test_options_of_the_walk_reach_the_run(command, work, tmp_path, monkeypatch, capsys):
    seen = []

    def stop(config, *_, **__):
        seen.append(config)
        raise SimError("so far")

    monkeypatch.setattr(work, stop)
    options = [
        "--tour",
        "both-ways",
        "--length",
        "30",
        "--sway",
        "quadruped",
        "--rate",
        "20",
        "--start-manoeuvre",
        "--reverse",
    ]
    assert status_of([command, *options, "--out", tmp_path]) == status_of([command, "--out", tmp_path]) == 2
    tour, usual = (tour_config(config) for config in seen)
    assert tour == TourConfig("both ways", 30.0, reverse=True, frame_rate_hz=20.0, sway="quadruped", start_manoeuvre=True)
    assert usual == tour_config(Scenario()) == TourConfig("rooms", 140.0)


def test_all_options_of_a_run_reach_it(tmp_path, monkeypatch, capsys):
    seen = []

    def stop(scenario, slam, *_):
        seen.append((scenario, slam))
        raise SimError("so far")

    monkeypatch.setattr("sim.harness.run", stop)
    monkeypatch.setattr("sim.harness.adapters.Lexis", lambda *options, **switches: (options, switches))
    (tmp_path / "settings.json").write_text('{"planner": {"shortcut_m": 0.4}}')
    options = ["--preset", "office", "--seed", "9", "--odometry", "mono", "--overconfidence", "2", "--fault", "dropped:0.1"]
    options += ["--fault", "late", "--encoder", "oracle", "--fidelity", "features", "--feature-model", "own.npz"]
    options += ["--rig", "stereo", "--config", tmp_path / "settings.json"]
    for switch in ([], ["--no-loops"], ["--no-refine"]):
        assert status_of(["run", *options, *switch, "--out", tmp_path / "out"]) == 2
    scenario = Scenario(
        preset="office",
        seed=9,
        odometry="mono",
        overconfidence=2.0,
        faults=(parse_fault("dropped:0.1"), parse_fault("late")),
        encoder="oracle",
        fidelity="features",
        feature_model=Path("own.npz"),
        rig=RigConfig("stereo"),
    )
    config = Config(planner=PlannerConfig(shortcut_m=0.4))
    switches = [(True, True), (False, True), (True, False)]
    assert seen == [(scenario, (("oracle", config), {"loops": loops, "refine": refine})) for loops, refine in switches]


def test_a_run_that_saw_almost_nothing_and_faults_that_did_nothing_are_told(tmp_path, capsys):
    options = ["--fidelity", "features", "--encoder", "oracle", "--rate", "2", "--length", "15", "--out", tmp_path / "out"]
    house = tmp_path / "house.json"
    house.write_text(sample_from_rooms(("kitchen", "bedroom"), seed=21).to_json())
    assert status_of(["run", "--house", house, *options]) == 0
    assert "warning: " not in capsys.readouterr().out
    late = ["--fault", "dropped:0.95", "--fault", "stamp-jump:at_s=900"]
    assert status_of(["run", "--house", house, *options, *late]) == 0
    said = [line for line in capsys.readouterr().out.splitlines() if line.startswith("warning: ")]
    assert len(said) == 2 and "stamp-jump" in said[1]


def test_options_of_the_calibration_reach_the_recording(tmp_path, monkeypatch, capsys):
    seen = []

    def stop(config, *_, **options):
        seen.append((build_rig(config.rig).front.T_B_C, options["imu_config"], options["distortion"]))
        raise SimError("so far")

    monkeypatch.setattr("sim.record.record", stop)
    options = ["--lever-arm=-0.05,0.02,0.1,0,0,90", "--imu-bias", "--distortion", "barrel"]
    assert status_of(["record", *options, "--out", tmp_path]) == status_of(["record", "--out", tmp_path]) == 2
    (place, imu, lens), (ideal_place, ideal_imu, no_lens) = seen
    np.testing.assert_allclose(place[:3], [[1, 0, 0, -0.05], [0, 0, 1, 0.02], [0, -1, 0, 0.1]], atol=1e-12)
    assert (imu.gyroscope_turn_on, imu.accelerometer_turn_on) == (np.radians(0.5), 20e-3 * 9.81)
    assert lens == Distortion(-0.1, 0.008, 0.0005, -0.0003)
    np.testing.assert_array_equal(ideal_place, build_rig(Scenario().rig).front.T_B_C)
    assert ideal_imu == ImuConfig() and no_lens is None


def test_help_lists_every_fault(capsys):
    with pytest.raises(SystemExit):
        main(["run", "--help"])
    shown = capsys.readouterr().out
    assert all(f"\n  {name}:" in shown for name in FAULTS)


def test_a_full_standard_output_is_one_line_and_exit_2(monkeypatch, capsys):
    with open("/dev/full", "w", encoding="utf-8") as full:
        monkeypatch.setattr(sys, "stdout", full)
        assert status_of(["--help"]) == 2
    error = capsys.readouterr().err
    assert error.startswith("lexis-sim: standard output cannot be written: No space left") and error.count("\n") == 1
