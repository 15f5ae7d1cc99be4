"""The folder of a failure: it says why, and its test fails now and passes once the SLAM is mended."""

import runpy
from collections import Counter
from dataclasses import replace
from io import BytesIO

import numpy as np
import pytest
from helpers.open_flat import OPEN_FLAT
from PIL import Image

from sim.bench.planted_bugs import drift, open_plan, planted
from sim.cli import main
from sim.errors import GraphicsError
from sim.faults import parse_fault
from sim.harness import Claim, FailureTest, Scenario, blame, reduce, write_failure
from sim.harness.failures.blame_table import BlameTable
from sim.harness.failures.failure_folder import Replay
from sim.harness.failures.why_page import wrong_frame_page
from sim.harness.shrinking.reductions import STEPS
from sim.pytest_plugin.execution import Reason
from sim.render.rig import RigConfig


@pytest.fixture(scope="module")
def failure(tmp_path_factory):
    out = tmp_path_factory.mktemp("failures") / "failure"
    test = FailureTest(Claim.parse("labels.accuracy < 0.9"), planted(open_plan))
    reduction = reduce(OPEN_FLAT, test, 1e9)
    replay = Replay("from sim.bench.planted_bugs import no_bug, open_plan, planted", "planted(open_plan)(scenario, None)")
    write_failure(out, reduction, test, blame(reduction, test), replay)
    return out, reduction


def test_the_folder_is_complete_and_the_scenarios_load(failure):
    out, reduction = failure
    pictures = ("first-wrong.png", "first-wrong-plan.png")
    for name in ("house.json", "result.json", "report.html", "test_replay.py", "why.md", *pictures):
        assert (out / name).is_file()
    assert Scenario.load(out / "scenario.json") == reduction.scenario
    assert Scenario.load(out / "original.json") == reduction.original


def test_why_names_frame_step_and_cure(failure):
    text = (failure[0] / "why.md").read_text()
    assert "Mended by: openness 0." in text and "Not mended by" not in text.partition("openness 0.")[0]
    assert ": labelled " in text and "![the image of the camera](first-wrong.png)" in text
    assert "- without the opening" in text
    assert "Each dot is a frame at its true position, in the colour of the SLAM's estimate; later frames are small." in text


def test_no_scenario_is_run_twice_and_the_values_are_those_of_the_runs(tmp_path):
    ran = []

    def runner(scenario, progress):
        ran.append(scenario.content_hash)
        return planted(open_plan)(scenario, progress)

    test = FailureTest(Claim.parse("labels.accuracy < 0.9"), runner)
    reduction = reduce(OPEN_FLAT, test, 1e9, steps={name: STEPS[name] for name in ("drop rooms", "drop drift")})
    write_failure(tmp_path / "failure", reduction, test, BlameTable(()))
    assert len(set(ran)) == len(ran) > 2
    kept, text = test.observe(reduction.scenario), (tmp_path / "failure" / "why.md").read_text()
    assert kept.run.scenario == reduction.scenario and len(set(ran)) == len(ran)
    assert f"is **{kept.value:.4g}** in" in text and f"it is {reduction.signature.value:.4g}." in text


def test_without_opengl_the_page_does_without_the_image(failure, monkeypatch):
    def lost(session, frames):
        raise GraphicsError("no off-screen OpenGL: install EGL")

    monkeypatch.setattr("sim.session.Session.pictures", lost)
    page = wrong_frame_page(planted(open_plan)(failure[1].scenario, None), "labels.accuracy")
    assert list(page.pictures) == ["first-wrong-plan.png"]
    assert "The image of the camera is left out: no off-screen OpenGL: install EGL." in page.lines[-1]


def test_the_picture_is_large_enough_to_recognise_a_room_if_the_slam_was_given_no_images():
    for width, height, shown in ((240, 180, (480, 360)), (600, 300, (600, 300)), (64, 32, (480, 240))):
        scenario = replace(OPEN_FLAT, rig=RigConfig(width=width, height=height))
        page = wrong_frame_page(planted(open_plan)(scenario, None), "labels.accuracy")
        assert Image.open(BytesIO(page.pictures["first-wrong.png"])).size == shown


def test_the_most_frequent_wrong_label_is_named_for_figures_of_labels_only():
    run = planted(open_plan)(OPEN_FLAT, None)
    names, pairs = run.room_names, zip(run.true_labels.tolist(), run.estimate.labels.tolist(), strict=True)
    wrong = Counter((names[truth], names[claim]) for truth, claim in pairs if truth != claim)
    (said,) = (line for line in wrong_frame_page(run, "labels.accuracy").lines if line.startswith("The most frequent"))
    counts = {f"{truth} is labelled {claim}, in {count} of {wrong.total()}" for (truth, claim), count in wrong.items()}
    assert any(each in said for each in counts) and f" in {max(wrong.values())} of " in said
    assert not any(line.startswith("The most frequent") for line in wrong_frame_page(run, "rooms.pq").lines)


@pytest.mark.parametrize(
    ("first_is_right", "said"),
    [
        (True, "to the true name, as in {} of {} wrong frames; the error comes after the encoder."),
        (False, "to a wrong name, as in {} of {} wrong frames."),
    ],
)
def test_a_wrong_label_is_blamed_on_the_encoder_only_where_the_image_alone_misleads(first_is_right, said):
    run = planted(open_plan)(OPEN_FLAT, None)
    wrong = np.flatnonzero(run.estimate.labels != run.true_labels)
    alike = run.true_labels.copy()
    alike[wrong[1:3]] = run.estimate.labels[wrong[1:3]]
    alike[wrong[0]] = (run.true_labels if first_is_right else run.estimate.labels)[wrong[0]]
    similarities = np.eye(len(run.room_names))[alike]
    lines = wrong_frame_page(
        replace(run, estimate=replace(run.estimate, similarities=similarities)), "labels.accuracy"
    ).lines
    count = sum(alike[wrong] == run.true_labels[wrong]) if first_is_right else 3
    assert f"The image alone is most similar {said.format(count, len(wrong))}" in lines
    assert not any(line.startswith("The image alone") for line in wrong_frame_page(run, "labels.accuracy").lines)


def test_faults_are_named_with_the_time_of_their_first_frame():
    faults = parse_fault("kidnap:5,skip_s=8"), parse_fault("odometry-jump:at_s=9")
    scenario = replace(OPEN_FLAT, length_m=40.0, faults=faults)
    page = wrong_frame_page(planted(drift)(scenario, None), "trajectory.ate_m")
    (said,) = (line for line in page.lines if line.startswith("Faults of this run: "))
    times = [float(text.partition(" s")[0]) for text in said.split("first at ")[1:]]
    assert said.startswith("Faults of this run: kidnap, first at ") and "; odometry-jump, first at " in said
    assert 4.0 <= times[0] <= 15.0 and times[1] > times[0]
    assert not any("Faults" in line for line in wrong_frame_page(planted(drift)(OPEN_FLAT, None), "trajectory.ate_m").lines)


def test_pytest_shows_of_the_replay_what_the_page_shows(failure):
    out, _ = failure
    statement = next(line for line in (out / "test_replay.py").read_text().splitlines() if "assert" in line)
    assert Reason("AssertionError", "", 1, "", statement, "", AssertionError()).figure == "labels.accuracy"


def test_the_replay_fails_now_and_passes_once_mended(failure):
    path = failure[0] / "test_replay.py"
    with pytest.raises(AssertionError, match=r"labels.accuracy is 0.*; wanted: labels.accuracy >= 0.9"):
        runpy.run_path(str(path))["test_replay"]()
    mended = path.with_name("test_mended.py")
    mended.write_text(path.read_text().replace("planted(open_plan)", "planted(no_bug)"))
    runpy.run_path(str(mended))["test_replay"]()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--fails", "labels.accuracy < 0"], "; valid: a condition that is true of the scenario"),
        (["--fails", "wrong"], "condition 'wrong' is not understood"),
        (["--fails", "labels.acc < 1"], "no figure 'acc'"),
        (["--fails", "labels.accuracy < 1", "--keep", "rooms"], "--keep 'rooms': no such step; valid: drop storeys, "),
        (
            ["--fails", "trajectory.ate_m > 0", "--reference", "sim.harness.adapters:OdometryOnly"],
            "reference: it fails in the scenario, too: trajectory.ate_m is 0.",
        ),
        (
            ["--fails", "crash", "--reference", "sim.harness.adapters:Lexis"],
            "reference: the failure is 'crash'; valid: with a figure",
        ),
        (
            ["--fails", "labels.accuracy <= 1", "--reference", "nowhere"],
            "--reference 'nowhere': is no MODULE:CLASS; valid: ",
        ),
        (["--fails", "labels.accuracy < 1", "--deadline", "soon"], "'soon'; valid: a time such as 90s, 3m or 1h"),
    ],
)
def test_bad_input_is_named_in_one_line(arguments, message, tmp_path, capsys):
    OPEN_FLAT.save(tmp_path / "scenario.json")
    try:
        status = main(["shrink", str(tmp_path), "-o", str(tmp_path / "out"), *arguments])
    except SystemExit as stopped:
        status = stopped.code
    said = capsys.readouterr().err
    assert status == 2 and message in said and "Traceback" not in said and not (tmp_path / "out").exists()


def test_the_command_shrinks_a_failure_of_lexis(tmp_path, capsys):
    OPEN_FLAT.save(tmp_path / "scenario.json")
    claim = "labels.accuracy <= 1"  # true of every run
    assert main(["shrink", str(tmp_path), "--fails", claim, "--deadline", "60s", "-o", str(tmp_path / "out")]) == 0
    said = capsys.readouterr().out
    assert " -> 1 room, " in said and "mended by: nothing." in said
    assert (tmp_path / "out" / "why.md").is_file()
