"""The proof of the reducer: what it says of sound reductions, and that each law is found broken where it is."""

import pickle
from dataclasses import replace

import pytest
from helpers.open_flat import OPEN_FLAT

from sim.bench import prove
from sim.bench.failing_scenarios import FAMILIES, failing_scenario
from sim.bench.planted_bugs import BUGS, MENDED, no_bug, planted
from sim.bench.shrinking import ProofPlan, ReductionProof, broken_laws, broken_replays, family_of, summaries
from sim.cli import main
from sim.errors import SimError
from sim.faults.poses import OdometryNaN
from sim.harness import Scenario, evaluate, reduce, write_run
from sim.harness.shrinking.scenario_size import size

OPEN_PLAN = FAMILIES[0]


@pytest.fixture(scope="module")
def reduction():
    return reduce(OPEN_FLAT, OPEN_PLAN.test(), 1e9)


def broken(reduction, folder, test=None):
    return list(broken_laws(reduction, test or OPEN_PLAN.test(), OPEN_PLAN.bug, folder / "failure", False))


def test_there_is_a_family_for_every_bug_and_scenarios_take_turns():
    assert {family.bug for family in FAMILIES} == set(BUGS) - {"no bug", MENDED}
    assert [family_of(k) for k in range(2 * len(FAMILIES))] == [*FAMILIES, *FAMILIES]


def test_scenarios_are_drawn_again_and_differ_by_number():
    first, again, other = (failing_scenario(OPEN_PLAN, 0, number, 2) for number in (0, 0, 16))
    assert first == again != other


def test_too_few_rooms_for_a_bug_are_named(monkeypatch):
    monkeypatch.setattr("sim.bench.failing_scenarios._DRAWS", 1)
    with pytest.raises(SimError, match=r"of up to 1 rooms fails by 'twins'; valid: more rooms"):
        failing_scenario(next(each for each in FAMILIES if each.bug == "twins"), 0, 0, 1)


@pytest.mark.slow
def test_reductions_of_mixed_scenarios_keep_all_laws(tmp_path, capsys):
    arguments = ["--scenarios", "4", "--rooms", "2", "--processes", "1", "--out", str(tmp_path), "--deadline", "1h"]
    assert main(["bench", "shrinking", *arguments]) == 0
    rows = [line.split("│") for line in capsys.readouterr().out.splitlines() if "│" in line]
    assert [row[1].strip() for row in rows] == [*(family.bug for family in FAMILIES[:4]), "all"]
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("bug", ["open plan", "revisits", "wrong side", "nan poses"])
def test_a_sound_reduction_breaks_no_law(bug, tmp_path):
    family = next(family for family in FAMILIES if family.bug == bug)
    scenario, test = replace(OPEN_FLAT, **family.settings), family.test()
    sound = reduce(scenario, test, 1e9)
    assert size(sound.scenario).rooms == max(family.rooms, 1) and sound.ended == "smallest"
    assert list(broken_laws(sound, test, bug, tmp_path / "failure", False)) == []


def test_an_invalid_house_breaks_a_law(reduction, tmp_path):
    house = reduction.scenario.house
    closed = house.model_copy(update={"storeys": tuple(s.model_copy(update={"openings": ()}) for s in house.storeys)})
    assert broken(replace(reduction, scenario=replace(reduction.scenario, house=closed)), tmp_path)[0].startswith("valid:")


def test_another_signature_breaks_a_law(reduction, tmp_path):
    mended = planted(no_bug)
    found = broken(reduction, tmp_path, replace(OPEN_PLAN.test(), runner=mended))
    assert found == ["same signature: None instead of labels.accuracy < 0.9"]


def test_a_larger_scenario_breaks_a_law(reduction, tmp_path):
    swapped = replace(reduction, original=reduction.scenario, scenario=reduction.original)
    assert [law.partition(":")[0] for law in broken(swapped, tmp_path)] == ["no larger"]


def test_a_replay_that_always_passes_or_always_fails_breaks_a_law(tmp_path):
    replay = tmp_path / "test_replay.py"
    replay.write_text("def test_replay():\n    pass\n")
    assert list(broken_replays(tmp_path, "drift", own_pytest=True)) == [
        "replays: test_replay.py passes, although the bug is there",
        "replays: pytest test_replay.py ends with status 0 instead of 1",
    ]
    replay.write_text("def test_replay():\n    assert False\n")
    assert list(broken_replays(tmp_path, "drift", False)) == ["replays: test_replay.py fails without the bug"]


def test_a_broken_law_is_printed_and_its_scenario_kept(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("sim.bench.shrinking.is_valid", lambda scenario: False)
    arguments = ["--scenarios", "1", "--rooms", "2", "--processes", "1", "--out", str(tmp_path), "--deadline", "0.001s"]
    assert main(["bench", "shrinking", *arguments]) == 1
    kept = tmp_path / "open-plan-0.json"
    assert f"{kept}: valid: the house of the smallest scenario breaks a rule" in capsys.readouterr().out.replace("\n", "")
    assert OPEN_PLAN.test()(Scenario.load(kept)) is not None


def test_a_search_that_was_cut_short_is_counted(tmp_path):
    proofs = list(prove(ProofPlan(0, 1e-9, 2, tmp_path, 0), 1, 1))
    assert pickle.loads(pickle.dumps(proofs)) == proofs  # as they come from another process
    family, everything = summaries(proofs)
    assert (family.family, family.scenarios, family.in_time, family.broken) == ("open plan", 1, 0, 0)
    assert family.rooms[0] == family.rooms_before and everything.least_rooms is None


def test_the_summary_gives_the_median_also_of_an_even_number_of_reductions():
    rooms = ((2, 1), (3, 1), (6, 2), (9, 4))
    proofs = [ReductionProof(0, each, (10.0, 10.0 * each[1]), 5, 1.0, True, ()) for each in rooms]
    family, _ = summaries(proofs)
    assert (family.rooms_before, family.rooms, family.walk_m) == (4.5, (1.5, 4.0, 4.0), (15.0, 40.0, 40.0))


def test_poses_that_are_not_finite_are_held_in_figures_and_report(tmp_path):
    finished = planted(no_bug)(replace(OPEN_FLAT, faults=(OdometryNaN(0.3), OdometryNaN(1.0, at_s=0.0, for_s=1.0))), None)
    assert any("odometry-nan" in truth.faults for truth in finished.delivered)
    result = evaluate(finished)
    assert result.trajectory.ate_m == pytest.approx(0.0, abs=1e-6) and 0.0 < result.trajectory.ate_odometry_m < 5.0
    write_run(finished, result, (), tmp_path / "run")
    assert "nan" not in (tmp_path / "run" / "odometry.tum").read_text()
