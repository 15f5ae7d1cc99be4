"""Failures of LEXIS on rendered images are made smaller for real."""

from dataclasses import replace

import pytest

from sim.harness import Claim, FailureTest, Scenario, reduce, run, write_failure
from sim.harness.failures.blame_table import BlameTable
from sim.harness.shrinking.reductions import STEPS
from sim.harness.shrinking.scenario_size import size
from sim.render.rig import RigConfig
from worlds.presets import sample_from_rooms

pytestmark = pytest.mark.slow
SCENARIO = Scenario(seed=5, length_m=12.0, frame_rate_hz=2.0, rig=RigConfig(width=240, height=180))
KITCHEN, LIVING = "kitchen", "living room"


def shrunk(scenario, claim, *steps):
    """The reduction of a failure of LEXIS by some steps, its test, and the fidelities on which LEXIS was run."""
    ran = []

    def runner(scenario, progress):
        ran.append(scenario.fidelity)
        return run(scenario, None, progress)

    test = FailureTest(Claim.parse(claim), runner)
    return reduce(scenario, test, 1e9, steps={name: STEPS[name] for name in steps}), test, ran


def test_what_fails_on_features_too_is_searched_there_and_confirmed(tmp_path):
    scenario = replace(SCENARIO, house=sample_from_rooms((KITCHEN, LIVING), seed=4, openness=0.6))
    reduction, test, ran = shrunk(scenario, "labels.accuracy < 0.8", "drop drift", "shorten the tour", "drop furniture")
    assert reduction.searched_on == "features" and reduction.confirmed and reduction.scenario.fidelity == "render"
    assert size(reduction.scenario) < size(reduction.original) and ran.count("render") <= 4
    runs = len(ran)
    write_failure(tmp_path / "failure", reduction, test, BlameTable(()))
    text = (tmp_path / "failure" / "why.md").read_text()
    assert len(ran) == runs and "the result was confirmed on rendered images" in text
    assert (tmp_path / "failure" / "first-wrong.png").is_file() and "Most similar room names: " in text


def test_what_fails_on_images_alone_is_searched_there():
    # On these small images PnP confirms no loop, so that the drift stays; the feature sensor's model confirms two.
    scenario = replace(SCENARIO, house=sample_from_rooms((KITCHEN, "bedroom"), seed=21, openness=0.0))
    reduction, _, ran = shrunk(scenario, "trajectory.ate_m > 0.06", "drop windows", "daylight", "drop drift")
    assert reduction.searched_on == "render" and ran[1] == "features" and set(ran[2:]) == {"render"}
    assert "because the failure does not exist on feature fidelity" in reduction.note
    assert size(reduction.scenario) < size(reduction.original) and reduction.scenario.odometry != "perfect"
    assert "drop drift" in {change.step for change in reduction.passing}
