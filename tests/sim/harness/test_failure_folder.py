"""The folder of a failure: it says why, and its test fails now and passes once the SLAM is mended."""

import runpy

import pytest
from helpers.planted import OpenPlanBug, planted

from sim.cli import main
from sim.harness import Claim, FailureTest, Scenario, blame, reduce, write_failure
from sim.harness.failure_folder import Replay
from worlds.presets import sample_from_rooms

SCENARIO = Scenario(
    house=sample_from_rooms(("kitchen", "living room"), seed=4, openness=0.6),
    seed=5,
    length_m=20.0,
    frame_rate_hz=2.0,
    fidelity="features",
    encoder="oracle",
)


@pytest.fixture(scope="module")
def failure(tmp_path_factory):
    out = tmp_path_factory.mktemp("failures") / "failure"
    test = FailureTest(Claim.parse("labels.accuracy < 0.9"), planted(OpenPlanBug))
    reduction = reduce(SCENARIO, test, 1e9)
    replay = Replay("from helpers.planted import OpenPlanBug, planted", "planted(OpenPlanBug)(scenario, None)")
    write_failure(out, reduction, test, blame(reduction.scenario, test), replay)
    return out, reduction


def test_the_folder_is_complete_and_the_scenarios_load(failure):
    out, reduction = failure
    for name in ("house.json", "result.json", "report.html", "test_replay.py", "why.md"):
        assert (out / name).is_file()
    assert Scenario.load(out / "scenario.json") == reduction.scenario
    assert Scenario.load(out / "original.json") == reduction.original


def test_why_names_frame_step_and_cure(failure):
    text = (failure[0] / "why.md").read_text()
    assert "Mended by: openness 0." in text and "Not mended by" not in text.partition("openness 0.")[0]
    assert "claimed living room" in text or "claimed kitchen" in text or "claimed corridor" in text
    assert "- simpler openings: without the opening" in text


def test_the_replay_fails_now_and_passes_once_mended(failure):
    path = failure[0] / "test_replay.py"
    with pytest.raises(AssertionError, match=r"labels.accuracy is 0.*; wanted: labels.accuracy >= 0.9"):
        runpy.run_path(str(path))["test_replay"]()
    mended = path.with_name("test_mended.py")
    mended.write_text(path.read_text().replace("OpenPlanBug", "Planted"))
    runpy.run_path(str(mended))["test_replay"]()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--fails", "labels.accuracy < 0"], "it does not fail; valid: a scenario of which the failure is true"),
        (["--fails", "wrong"], "claim 'wrong' is not understood"),
        (["--fails", "labels.acc < 1"], "no figure 'acc'"),
        (["--fails", "labels.accuracy < 1", "--keep", "rooms"], "--keep 'rooms': no such step; valid: drop storeys, "),
        (["--fails", "labels.accuracy < 1", "--deadline", "soon"], "'soon'; valid: a time such as 90s, 3m or 1h"),
    ],
)
def test_bad_input_is_named_in_one_line(arguments, message, tmp_path, capsys):
    SCENARIO.save(tmp_path / "scenario.json")
    try:
        status = main(["shrink", str(tmp_path), "-o", str(tmp_path / "out"), *arguments])
    except SystemExit as stopped:
        status = stopped.code
    said = capsys.readouterr().err
    assert status == 2 and message in said and "Traceback" not in said and not (tmp_path / "out").exists()


def test_the_command_shrinks_a_failure_of_lexis(tmp_path, capsys):
    SCENARIO.save(tmp_path / "scenario.json")
    claim = "labels.accuracy <= 1"  # true of every run
    assert main(["shrink", str(tmp_path), "--fails", claim, "--deadline", "60s", "-o", str(tmp_path / "out")]) == 0
    said = capsys.readouterr().out
    assert "rooms 3 -> 1" in said and "mended by: nothing." in said
    assert (tmp_path / "out" / "why.md").is_file()
