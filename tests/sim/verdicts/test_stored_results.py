"""Results survive being stored, and `lexis-sim compare` judges stored results."""

import json
import math
import re
from dataclasses import replace

import pytest
from helpers.open_flat import OPEN_FLAT
from helpers.results import RESULT

from lexis.files.temporary_folder import temporary_folder
from sim.cli import main
from sim.errors import SimError
from sim.harness.results import FaultFigures, MatchFigures
from sim.verdicts.stored_results import SuiteResults, load_results, results_data, save_results

MANY = tuple(
    replace(
        RESULT, scenario=f"{i:016x}", seed=i, place_recognition={"1": MatchFigures(1, 2, 3)}, labels=replace(RESULT.labels)
    )
    for i in range(12)
)
WORSE = tuple(replace(each, labels=replace(each.labels, accuracy=0.6)) for each in MANY)


def test_stored_results_are_equal_to_the_originals(tmp_path):
    faulty = replace(MANY[0], scenario="f" * 16, faults=FaultFigures(("dropped:0.1",), {"dropped": 3}, 90, 0))
    save_results((*MANY, faulty), tmp_path / "all.json")
    assert load_results(tmp_path / "all.json") == (*MANY, faulty)


def test_results_are_found_in_the_folders_of_runs(tmp_path):
    for result in MANY[:2]:
        (tmp_path / "runs" / result.scenario).mkdir(parents=True)
        (tmp_path / "runs" / result.scenario / "result.json").write_text(json.dumps(result.data()))
    assert load_results(tmp_path) == MANY[:2]
    assert load_results(tmp_path / "runs" / MANY[1].scenario) == MANY[1:2]
    assert load_results(tmp_path / "runs" / MANY[1].scenario / "result.json") == MANY[1:2]


def test_runs_that_are_still_being_written_are_left_out(tmp_path):
    (tmp_path / "runs" / "done").mkdir(parents=True)
    (tmp_path / "runs" / "done" / "result.json").write_text(json.dumps(MANY[0].data()))
    with temporary_folder(tmp_path / "runs") as folder:
        (folder / "new" / "next").mkdir()
        (folder / "new" / "next" / "result.json").write_text("{")
        assert load_results(tmp_path) == load_results(tmp_path / "runs") == MANY[:1]


def test_a_path_may_be_text(tmp_path):
    save_results(MANY, str(tmp_path / "all.json"))
    (tmp_path / "run").mkdir()
    (tmp_path / "run" / "result.json").write_text(json.dumps(MANY[0].data()))
    for name, results in (("all.json", MANY), ("run", MANY[:1])):
        path = str(tmp_path / name)
        assert load_results(path) == SuiteResults.load(path).results == results


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("[]", "it is no result with schema 1"),
        ('{"format": "lexis-results", "results": {}}', "contains no list of results"),
        ('{"format": "lexis-results", "results": [], "examined": ["a"]}', "contains no result: no scenario was completed"),
        ('{"format": "lexis-results", "results": [3]}', r"results\[0\] is no result"),
        (json.dumps(RESULT.data() | {"labels": 3}), "labels: "),
        (json.dumps(RESULT.data() | {"labels": {"accuracy": "high"}}), "labels.accuracy: "),
        (
            json.dumps(RESULT.data() | {"floors": {"accuracy": math.nan}}),
            "floors.accuracy is nan; a figure that a run does not",
        ),
        (
            json.dumps({"format": "lexis-results", "results": [RESULT.data() | {"floors": {"accuracy": math.inf}}]}),
            r"results\[0\].floors.accuracy is inf; a figure that a run does not have is null",
        ),
    ],
)
def test_a_damaged_file_is_refused_with_its_place(tmp_path, content, message):
    (tmp_path / "bad.json").write_text(content)
    with pytest.raises(SimError, match=f"bad.json: cannot be used: {message}"):
        load_results(tmp_path / "bad.json")


def test_a_folder_without_results_is_refused(tmp_path):
    with pytest.raises(SimError, match=r"contains no result.json; valid: the folder of a run, a folder of such folders, or"):
        load_results(tmp_path)


def test_the_command_fails_where_the_second_slam_is_worse(tmp_path, capsys):
    before, after = str(tmp_path / "before.json"), str(tmp_path / "after.json")
    save_results(MANY, tmp_path / "before.json")
    save_results(WORSE, tmp_path / "after.json")
    assert main(["compare", before, after, "--claim", "labels.accuracy >= 0.7"]) == 1
    shown = capsys.readouterr()
    assert re.search(r"^labels.accuracy +0.900 +0.600 +-0.300 \(-0.300 to -0.300\)", shown.out, re.MULTILINE)
    assert "failed: labels.accuracy, labels.accuracy >= 0.7 of" in shown.err
    assert main(["compare", after, before]) == 0
    assert main(["compare", before, before]) == 0


def stored(path, results, begun):
    """Write results as a suite does that began these scenarios."""
    path.write_text(json.dumps(results_data(results) | {"examined": [each.scenario for each in begun]}))
    return path


def comparable(first, second):
    a, b = SuiteResults.load(first), SuiteResults.load(second)
    return a.comparable_with(b), b.comparable_with(a)


def test_scenarios_that_were_never_begun_are_no_crashes(tmp_path):
    whole = stored(tmp_path / "whole.json", MANY, MANY)
    early = stored(tmp_path / "early.json", MANY[:3], MANY[:3])
    crashed = stored(tmp_path / "crashed.json", MANY[:3], MANY)
    assert comparable(whole, early) == (MANY[:3], MANY[:3]) == comparable(early, whole)
    assert comparable(whole, crashed) == (MANY, MANY[:3])
    assert main(["compare", str(whole), str(early)]) == main(["compare", str(early), str(whole)]) == 0
    assert main(["compare", str(whole), str(crashed)]) == 1


def test_a_slam_that_completes_no_scenario_is_worse(tmp_path, capsys):
    whole, none = stored(tmp_path / "whole.json", MANY, MANY), stored(tmp_path / "none.json", (), MANY)
    assert main(["compare", str(whole), str(none)]) == 1
    assert f"failed: {none} has no result for any completed scenario of {whole}" in capsys.readouterr().err
    assert main(["compare", str(none), str(whole)]) == 2
    assert "none.json: cannot be used: contains no result: no scenario was completed" in capsys.readouterr().err


def test_results_of_other_scenarios_are_refused_with_their_numbers(tmp_path, capsys):
    ours, theirs = stored(tmp_path / "a.json", MANY[:2], MANY[:2]), stored(tmp_path / "b.json", MANY[2:], MANY[2:])
    assert main(["compare", str(ours), str(theirs)]) == 2
    assert "a.json (2 scenarios) and " in (said := capsys.readouterr().err)
    assert "b.json (10) have no completed scenario in common; valid: results of two SLAMs on the same" in said


def test_single_runs_of_different_scenarios_are_refused_with_the_difference(tmp_path, capsys):
    for name, result, length_m in (("a", MANY[0], 20.0), ("b", MANY[1], 30.0)):
        (tmp_path / name).mkdir()
        (tmp_path / name / "result.json").write_text(json.dumps(result.data()))
        replace(OPEN_FLAT, length_m=length_m).save(tmp_path / name / "scenario.json")
    assert main(["compare", str(tmp_path / "a"), str(tmp_path / "b")]) == 2
    said = capsys.readouterr().err
    assert "a (1 scenario) and " in said
    assert "b (1) have no completed scenario in common (from the first to the second: length_m: 20.0 -> 30.0); valid" in said


def test_a_run_that_was_stopped_before_it_reached_an_earlier_scenario_cannot_be_compared():
    earlier = SuiteResults(MANY[:2], frozenset(each.scenario for each in MANY[:2]))
    stopped = SuiteResults(MANY[2:3], frozenset({MANY[2].scenario}))
    assert earlier.compared_with(stopped) is None
    assert earlier.compared_with(SuiteResults(MANY[1:3])).scenarios == 1


def test_a_slam_is_not_worse_than_one_that_completes_none_of_its_scenarios(tmp_path, capsys):
    crashed = stored(tmp_path / "crashed.json", MANY[:1], MANY)
    assert main(["compare", str(crashed), str(stored(tmp_path / "b.json", MANY[1:], MANY[1:]))]) == 2
    assert "crashed.json (12 scenarios) and " in capsys.readouterr().err
