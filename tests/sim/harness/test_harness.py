"""The whole chain on real renders of a small house, compared with its truth."""

import json
from contextlib import closing
from dataclasses import replace

import numpy as np
import pytest

from lexis.evaluation.trajectory import ate_rmse
from lexis.files.replace import CONTENTS
from lexis.files.tum_trajectory import read_tum
from lexis.map.folder import load_map
from sim.faults.delivery import Duplicated
from sim.faults.poses import Kidnap, OdometryNaN
from sim.harness import Scenario, evaluate, run, try_plans, write_run
from sim.harness.loops import edge_truth
from sim.harness.planning import INSIDE_M
from sim.harness.results import FloorFigures
from sim.harness.walk import walk
from sim.render.rig import STEREO_BASELINE_M, RigConfig, RigRenderer, build_rig, build_rig_scene
from sim.session import Session
from worlds.house import build_house
from worlds.presets import sample_from_rooms
from worlds.spec import HouseSpec
from worlds.walkable import polyline_length

CONFIG = Scenario(house=sample_from_rooms(("kitchen", "bedroom"), seed=21), seed=5, length_m=45.0)
BRIEF = replace(CONFIG, length_m=24.0, rig=RigConfig("stereo", 160, 120))
"""A run too short for good results, but otherwise like a full one."""
CONTRACT = {
    "house": {"rooms", "floors", "area_m2", "openness", "spec"},
    "run": {"path_m", "duration_s", "frames", "keyframes"},
    "labels": {"accuracy", "accuracy_baseline", "accuracy_graded", "per_room"},
    "rooms": {
        "pq", "precision", "recall", "hydra_precision", "hydra_recall", "ari", "v_measure", "splits", "merges",
        "count_error",
    },
    "floors": {"accuracy", "count_error"},
    "loops": {"proposed", "verified", "true", "false", "precision", "recall", "error_m", "error_rad"},
    "place_recognition": {"1", "3", "5"},
    "coverage": {"rooms_visited", "rooms", "path_covered"},
    "planning": {"queries", "success", "spl", "collisions"},
    "time": {"house_s", "scene_s", "render_s", "start_s", "slam_s", "stages_s", "realtime_factor"},
}  # fmt: skip


@pytest.fixture(scope="module")
def finished():
    return run(CONFIG)


@pytest.fixture(scope="module")
def trials(finished):
    return try_plans(finished)


@pytest.fixture(scope="module")
def result(finished, trials):
    return evaluate(finished, trials)


def test_the_result_has_every_field_of_the_contract(result):
    data = result.data()
    assert data["schema"] == 1 and data["versions"]
    assert {"seed", "preset", "fidelity", "encoder", "odometry"} <= data.keys()
    assert {"ate_odometry_m", "ate_m"} <= data["trajectory"].keys()
    for section, names in CONTRACT.items():
        assert data[section].keys() == names
    json.dumps(data, allow_nan=False)
    assert result.time.realtime_factor == pytest.approx(result.run.duration_s / result.time.slam_s)


def test_a_figure_is_found_by_its_dotted_name(result):
    assert result["labels.accuracy"] == result.labels.accuracy and result["place_recognition.3.tp"] is not None
    with pytest.raises(KeyError, match=r"'labels.acc': no figure 'acc'; valid: accuracy, accuracy_baseline"):
        result["labels.acc"]
    assert result["faults.frames.blur"] is None and result["faults.refused"] is None
    for name, valid in (("encoder.name", "'encoder'"), ("labels.accuracy.x", "'labels.accuracy'"), ("faults.x", "'faults'")):
        with pytest.raises(KeyError, match=f"valid: {valid}"):
            result[name]


def test_lexis_beats_its_odometry_and_closes_no_false_loop(finished, result):
    assert 0.0 < result.trajectory.ate_m < result.trajectory.ate_odometry_m
    assert result.loops.true >= 5 and result.loops.recall > 0.2
    assert not (finished.estimate.loops.weights[~edge_truth(finished)] > 0.5).any()


def test_labels_are_far_better_than_chance(result):
    assert result.labels.accuracy > 0.55
    assert result.labels.accuracy_graded >= result.labels.accuracy


def test_a_single_floor_is_one_floor(result):
    assert result.floors == FloorFigures(accuracy=1.0, count_error=0)


def test_every_plan_reaches_its_room(finished, result, trials):
    assert result.planning.queries == len(trials) > 0
    assert result.planning.success == 1.0 and result.planning.collisions == 0
    for trial in trials:
        direct_m = polyline_length(finished.walkable.path(trial.path[0], trial.path[-1]))
        assert trial.travelled_m >= 0.99 * direct_m
        # The shortest path ends `INSIDE_M` inside the room. A robot may stop earlier.
        assert trial.travelled_m + INSIDE_M >= 0.99 * trial.shortest_m


def test_the_same_seed_gives_the_same_result_apart_from_times():
    first, again = run(BRIEF), run(BRIEF)
    figures = [evaluate(each, try_plans(each)).data() | {"time": None} for each in (first, again)]
    assert figures[0] == figures[1]
    np.testing.assert_array_equal(first.estimate.T_W_B, again.estimate.T_W_B)
    np.testing.assert_array_equal(first.estimate.similarities, again.estimate.similarities)


def test_lexis_sees_what_the_cameras_of_the_rig_see():
    rig = build_rig(BRIEF.rig)
    assert [camera.T_B_C[1, 3] for camera in rig.front.rig] == [STEREO_BASELINE_M / 2, -STEREO_BASELINE_M / 2]
    walked = walk(BRIEF)
    session = Session(walked.house, walked.tour, walked.odometry, rig.front)
    with closing(iter(session)) as pairs, RigRenderer(build_rig_scene(walked.house, rig), rig) as renderer:
        observation, truth = next(pairs)
        for image, rendered in zip(observation.images, renderer.rgb(truth.T_W_B).values(), strict=True):
            np.testing.assert_array_equal(image, rendered)


def test_the_folder_holds_what_the_result_says(finished, result, trials, tmp_path):
    (tmp_path / "elsewhere").mkdir()
    out = tmp_path / "out"
    out.symlink_to("elsewhere")
    write_run(finished, result, trials, out)
    assert {path.name for path in out.iterdir()} == {
        "result.json", "scenario.json", "house.json", "report.html", "trajectory.tum", "ground_truth.tum", "odometry.tum",
        "map", CONTENTS,
    }  # fmt: skip
    assert json.loads((out / "result.json").read_text()) == json.loads(json.dumps(result.data()))
    assert Scenario.load(out / "scenario.json") == finished.scenario
    assert build_house(HouseSpec.load(out / "house.json")).spec == finished.house.spec
    poses = {name: read_tum(out / f"{name}.tum")[1][:, :3, 3] for name in ("trajectory", "ground_truth", "odometry")}
    assert ate_rmse(poses["trajectory"], poses["ground_truth"]) == pytest.approx(result.trajectory.ate_m, abs=1e-6)
    assert ate_rmse(poses["odometry"], poses["ground_truth"]) == pytest.approx(result.trajectory.ate_odometry_m, abs=1e-6)
    assert np.array_equal(load_map(out / "map").labels, finished.estimate.labels)
    assert "http://" not in (out / "report.html").read_text().replace("http://www.w3.org", "")


def test_faults_are_counted_and_what_lexis_refuses_is_left_out():
    faults = (OdometryNaN(0.05), Duplicated(0.1), Kidnap(at_s=10.0, skip_s=5.0))
    finished = run(replace(BRIEF, faults=faults))
    result = evaluate(finished, [])
    counted = result.faults
    assert counted.given[1] == "duplicated:share=0.1" and counted.frames.keys() == {f.name for f in faults}
    touched = [truth for truth in finished.delivered if {"odometry-nan", "duplicated"} & set(truth.faults)]
    assert counted.refused == len(finished.refused) == len(touched) > 10
    assert counted.delivered == len(finished.delivered) > len(finished.estimate.frames)
    np.testing.assert_array_equal(finished.true_poses, finished.session.tour.T_W_B[finished.estimate.frames])
    json.dumps(result.data(), allow_nan=False)


def test_without_faults_the_result_does_not_mention_them(result):
    assert result.faults is None and "faults" not in result.data()
