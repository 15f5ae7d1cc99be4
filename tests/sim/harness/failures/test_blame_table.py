"""Blame by substitution: for a LEXIS with one planted bug, the stage with the bug is the one whose truth mends it."""

from dataclasses import replace

import numpy as np
import pytest

from lexis.config import Config, PoseGraphConfig
from lexis.evaluation.loops import true_edges
from lexis.types import LoopEdge
from lexis.verification import Verification
from sim.feature_sensor.oracle import Oracle
from sim.harness import Claim, FailureTest, Scenario, Signature, blame, reduce, run
from sim.harness.adapters import Lexis, OdometryOnly
from sim.harness.adapters.true_stages import TrueStages
from sim.harness.failures.blame_table import BlameRow, BlameTable, substitutions
from sim.harness.run_settings import with_listed_house
from sim.harness.shrinking.house_edits import keep_furniture
from sim.harness.shrinking.reductions import STEPS
from sim.render.rig import RigConfig
from worlds.presets import sample_from_rooms
from worlds.truth import room_at
from worlds.validation import built_and_checked

SCENARIO = Scenario(
    house=keep_furniture(sample_from_rooms(("kitchen", "bedroom"), seed=21, openness=0.0), set()),
    seed=5,
    length_m=40.0,
    frame_rate_hz=2.0,
    odometry="degraded",
    fidelity="features",
    encoder="oracle",
)
STAGES = ("oracle encoder", "true labels", "oracle place recognition", "oracle verification", "oracle loops", "loops off")


class Swapped(Oracle):
    """An encoder that mixes up the words for kitchens and bedrooms."""

    def encode_rooms(self, names):
        return super().encode_rooms([{"kitchen": "bedroom", "bedroom": "kitchen"}.get(name, name) for name in names])


def credulous(query, candidates, graph, camera, config):
    """A verifier that confirms every candidate, and takes it for the very place of the query."""
    return Verification(tuple(LoopEdge(query.id, match, np.eye(4), 1e-4 * np.eye(6), 100) for match in candidates))


def blind(query, label, rooms, graph, config):
    """A place recognition that proposes nothing."""
    return ()


def one_label(keyframes):
    """A labeller that takes every room for the first."""
    return np.zeros(len(keyframes), int)


def blamed(claim, **stages):
    """What the table says of each stage of a LEXIS in which some stages are replaced."""
    settings = {"encoder": "oracle"} | stages
    test = FailureTest(Claim.parse(claim), lambda scenario, progress: run(scenario, Lexis(**settings), progress))
    reduction = reduce(SCENARIO, test, steps={})
    return {row.substitution: row.effect for row in blame(reduction, test, is_lexis=True).rows}


def test_an_encoder_that_swaps_two_labels():
    said = blamed("labels.accuracy < 0.5", encoder=Swapped())
    mending = {name for name in said if said[name] == "mends"}
    assert mending == {"oracle encoder", "true labels"}


def test_a_verifier_that_accepts_everything():
    said = blamed("loops.precision < 0.9", verifier=credulous)
    assert {name for name in STAGES if said[name] == "mends"} == {"oracle verification", "oracle loops"}
    assert said["oracle encoder"] == "changes nothing" and said["loops off"] == "cannot be told"


def test_a_place_recognition_that_proposes_nothing():
    said = blamed("loops.recall < 0.2", place_recogniser=blind)
    assert {name for name in STAGES if said[name] == "mends"} == {"oracle place recognition", "oracle loops"}


def test_labels_that_are_lost_before_clustering():
    said = blamed("rooms.pq < 0.7", labeller=one_label)
    assert {name for name in STAGES if said[name] == "mends"} == {"true labels"}


class Drifting:
    """Fails where the odometry drifts; counts the runs, and is interrupted in one of them."""

    def __init__(self, stop_at=None):
        self.runs, self.stop_at = 0, stop_at

    def __call__(self, scenario):
        self.runs += 1
        if self.runs == self.stop_at:
            raise KeyboardInterrupt
        return None if scenario.odometry == "perfect" else Signature("drifts")


def test_a_failure_of_any_kind_is_blamed_without_access_to_the_slam():
    fails = Drifting()
    reduction = reduce(SCENARIO, fails, steps={})
    rows = blame(reduction, fails).rows
    assert [(row.substitution, row.effect) for row in rows if row.effect != "changes nothing"] == [
        ("perfect odometry", "mends")
    ]
    assert [row.substitution for row in blame(reduction, fails, is_lexis=True).rows][len(rows) :] == ["oracle encoder"]


@pytest.mark.parametrize("stop_at", [2, 3])
def test_after_an_interruption_of_the_search_or_of_blame_nothing_more_is_run(stop_at):
    fails = Drifting(stop_at)
    reduction = reduce(SCENARIO, fails, steps={"drop drift": STEPS["drop drift"]})
    assert (reduction.ended == "interrupted") == (stop_at == 2)
    table = blame(reduction, fails)
    assert table.interrupted and not table.rows and fails.runs == stop_at
    assert str(table) == "what mends it is unknown, because Ctrl-C ended the search."


def test_blame_that_is_interrupted_keeps_the_rows_that_are_finished():
    reduction = reduce(replace(SCENARIO, encoder="mini"), Drifting(), steps={})
    whole = blame(reduction, Drifting(), is_lexis=True)
    found = blame(reduction, Drifting(stop_at=2), is_lexis=True)  # in the run with the oracle encoder, which is the last one
    assert found.interrupted and not whole.interrupted
    assert found.rows == whole.rows[:-1] and "mends" in {row.effect for row in found.rows}


def drifts_in_long_walks(scenario):
    """Fail in long walks where the odometry drifts, and in short walks always."""
    mended = scenario.odometry == "perfect" and (scenario.length_m or 0.0) > 20.0
    return None if mended else Signature("fails")


def test_what_mends_the_original_is_told_beside_what_mends_the_smallest():
    reduction = reduce(SCENARIO, drifts_in_long_walks, steps={"shorten the tour": STEPS["shorten the tour"]})
    table = blame(reduction, drifts_in_long_walks)
    assert table.named("mends") == () and "perfect odometry" in table.named("does not mend")
    assert table.original.named("mends") == ("perfect odometry",) and table.original.original is None
    assert blame(reduction, drifts_in_long_walks, original_s=0.0) == replace(table, original=None)
    assert blame(reduce(SCENARIO, drifts_in_long_walks, steps={}), drifts_in_long_walks).original is None


@pytest.mark.parametrize(
    ("effects", "summary"),
    [
        (["mends", "does not mend", "cannot be told"], "mended by: a. Not mended by: b."),
        (["does not mend", "changes nothing"], "mended by: nothing. Not mended by: a."),
        (["cannot be told", "changes nothing"], "no replacement could be judged (a: why)."),
        (["changes nothing", "changes nothing"], "the failure needs no error of a or error of b."),
        ([], "no change was tried."),
    ],
)
def test_the_summary_says_no_more_than_the_table(effects, summary):
    rows = [BlameRow(name, effect, detail="why") for name, effect in zip("abc", effects, strict=False)]
    assert str(BlameTable(tuple(rows))) == summary


def table(**effects):
    return tuple(BlameRow(name.replace("_", " "), effect) for name, effect in effects.items())


@pytest.mark.parametrize("in_original", ["mends", "changes nothing", "cannot be told"])
def test_a_change_that_mends_the_smallest_scenario_alone_tells_of_another_error(in_original):
    smallest = table(perfect_odometry="mends", no_clutter="does not mend")
    other = BlameTable(smallest, BlameTable(table(perfect_odometry="does not mend", no_clutter="does not mend")))
    assert "perfect odometry mends only the smallest scenario" in other.another_error
    same = BlameTable(smallest, BlameTable(table(perfect_odometry=in_original, no_clutter="does not mend")))
    assert same.another_error == "" == BlameTable(smallest).another_error


def test_what_the_scenario_lacks_is_named_as_what_the_failure_does_not_need():
    rows = [BlameRow(each.name, "changes nothing") for each in substitutions(SCENARIO, None)]
    assert str(BlameTable(tuple(rows))) == "the failure needs no drift, fault, clutter or open wall."
    mended = BlameTable((BlameRow("perfect odometry", "mends"), *rows[1:2]))
    assert mended.not_needed == "no fault"


def test_the_true_stages_close_true_loops_between_revisits_alone():
    truth = TrueStages.of(SCENARIO)
    finished = run(SCENARIO, Lexis("oracle", place_recogniser=truth.propose, verifier=truth.verify))
    claims = finished.estimate.loops
    assert len(claims.query) > 5
    assert true_edges(claims.query, claims.match, claims.T_match_query, finished.true_poses).all()
    everything = lambda query, label, rooms, graph, config: tuple(range(query.id))  # noqa: E731
    verified = run(SCENARIO, Lexis("oracle", place_recogniser=everything, verifier=truth.verify)).estimate.loops
    apart = finished.true_poses[verified.query, :3, 3] - finished.true_poses[verified.match, :3, 3]
    assert len(verified.query) > 5 and np.linalg.norm(apart, axis=1).max() <= 1.0


def test_the_true_label_of_a_frame_is_that_of_the_room_of_its_first_camera():
    """The camera is 0.15 m ahead of the body, so that it is in the next room before the body is."""
    scenario = replace(SCENARIO, frame_rate_hz=8.0, rig=RigConfig("wide", lever_arm_m=(0.15, 0.0, 0.0)))
    finished = run(scenario, OdometryOnly())
    truth = TrueStages.of(scenario).labels[finished.estimate.frames]
    np.testing.assert_array_equal(truth, finished.true_labels)
    of_body = room_at(finished.house, finished.true_poses[:, :3, 3])
    assert (of_body != finished.true_rooms).any()


def test_the_true_stages_propose_no_keyframe_that_has_retired():
    scenario = replace(SCENARIO, length_m=120.0, odometry="perfect", frame_rate_hz=4.0)
    truth, retired = TrueStages.of(scenario), 0

    def watched(query, label, rooms, graph, config):
        nonlocal retired
        retired = len(graph.retired)
        found = truth.propose(query, label, rooms, graph, config)
        assert set(found) <= set(graph.active.tolist())
        return found

    config = Config(pose_graph=PoseGraphConfig(window=20, growth=0.1, copies=2, retire_above=0))
    run(scenario, Lexis("oracle", config, place_recogniser=watched, verifier=truth.verify))
    assert retired > 5


def test_a_lexis_with_other_stages_keeps_its_settings():
    lexis = Lexis("oracle", refine=False, place_recogniser=blind)
    other = lexis.with_stages(labeller=one_label)
    assert other.config == lexis.config and run(SCENARIO, other).estimate.loops.query.size == 0
    assert (other.map.labels == 0).all()


def test_every_substitution_has_a_valid_house_even_where_a_new_door_would_open_into_furniture():
    """In home 500, a door in the place of an open boundary would hit listed coat hooks, so furniture is placed anew."""
    scenario = with_listed_house(Scenario(preset="home", seed=500, fidelity="features"))
    names = [each.name for each in substitutions(scenario, None) if built_and_checked(each.scenario.house)]
    assert names == ["perfect odometry", "no faults", "no clutter", "openness 0, furnished anew"]
