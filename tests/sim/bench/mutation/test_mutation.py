"""Every mutant fits the present code, and planting changes exactly one module."""

import json
import re
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import pytest
from helpers.results import RESULT

import lexis
from sim.bench.mutation import MUTANTS, Mutant
from sim.bench.mutation.grading import (
    COMPARED,
    Grade,
    _changed,
    _graded,
    _stored,
    counts,
    grade,
    markdown_table,
    read_grades,
    usable_grades,
    write_grade,
)
from sim.bench.mutation.planting import mutated_copy
from sim.cli import main
from sim.errors import SimError
from sim.harness.results import FaultFigures
from sim.verdicts import save_results

SOURCE = Path(lexis.__file__).parent


@pytest.mark.parametrize("mutant", MUTANTS, ids=lambda mutant: mutant.name)
def test_every_mutant_is_another_valid_program(mutant):
    text = (SOURCE / mutant.file).read_text()
    changed = mutant.applied(text)
    assert changed != text
    compile(changed, mutant.file, "exec")


def test_there_are_many_different_mutants():
    assert len({mutant.name for mutant in MUTANTS}) == len(MUTANTS) >= 40
    assert len({(mutant.file, mutant.before, mutant.after) for mutant in MUTANTS}) == len(MUTANTS)


def test_a_text_that_is_not_there_once_is_refused():
    with pytest.raises(SimError, match=r"its text occurs 0 times in floors\.py; valid: once"):
        Mutant("no bug", "floors.py", "there is no such text", "").applied("def floors(): ...")


def test_a_fingerprint_tells_mutants_apart_and_changes_with_lexis(monkeypatch):
    assert len({mutant.fingerprint for mutant in MUTANTS}) == len(MUTANTS)
    before = MUTANTS[0].fingerprint
    monkeypatch.setattr("sim.bench.mutation.planting._hash_of_lexis", lambda: "another LEXIS")
    assert MUTANTS[0].fingerprint != before


def test_planting_changes_one_module_of_a_copy_and_nothing_else():
    mutant = MUTANTS[0]
    with mutated_copy(mutant) as folder:
        copies = {path.relative_to(folder / "lexis"): path for path in (folder / "lexis").rglob("*") if path.is_file()}
        changed = [str(name) for name, path in copies.items() if path.read_bytes() != (SOURCE / name).read_bytes()]
        assert changed == [mutant.file]
    assert not folder.exists()


def test_python_imports_the_copy_with_the_mutant():
    mutant = Mutant("three floors", "floors.py", "NO_FLOOR = -1\n", "NO_FLOOR = -3\n")
    with mutated_copy(mutant) as folder:
        code = "import sim.harness, lexis.floors; print(lexis.floors.NO_FLOOR, lexis.floors.__file__)"
        shown = subprocess.run(
            [sys.executable, "-P", "-c", code], capture_output=True, text=True, check=True, env={"PYTHONPATH": str(folder)}
        ).stdout.split()
    assert shown == ["-3", str(folder / "lexis" / "floors.py")]


SHOWN = """holds 3 of 3 homes: labels.accuracy >= 0.5
homes: other: 5 rooms, 80 m -> 1 room, 3 m
  mended by: perfect odometry.
homes: origin: 5 rooms, whole tour -> 2 rooms, 4.1 m
  replay: pytest smallest/homes-origin/test_replay.py
"""


def test_a_grade_names_the_first_check_that_failed():
    failure = {"number": 0, "scenario": "0" * 16, "measured": "floors 0.4"}
    checks = [
        {"part": "homes", "check": "the run completes", "outcome": "undecided", "failures": []},
        {"part": "homes", "check": "origin", "outcome": "fails", "failures": [failure]},
    ]
    start = ("a mutant", "pr", 7)
    graded = _graded(start, {"results": [{}] * 3, "checks": checks, "means": [], "worse": []}, SHOWN, 12.0)
    assert graded == Grade(*start, "homes: origin", 3, 12.0, "floors 0.4", "2 rooms, 4.1 m", blamed="")
    checks[1]["check"] = "other"  # a claim about a figure, for which the blame table has been made
    claim = _graded(start, {"results": [{}] * 3, "checks": checks, "means": [], "worse": []}, SHOWN, 12.0)
    assert (claim.smallest, claim.blamed) == ("1 room, 3 m", "mended by: perfect odometry.")
    assert _graded(start, {"results": [{}], "checks": checks[:1], "means": [], "worse": []}, "", 1.0).caught_by is None
    low = [{"claim": "rooms.pq >= 0.7", "outcome": "fails"}]
    by_mean = _graded(start, {"results": [{}], "checks": checks[:1], "means": low, "worse": ["x"]}, "", 1.0)
    assert by_mean.caught_by == "all parts: mean rooms.pq >= 0.7"
    compared = _graded(start, {"results": [{}], "checks": checks[:1], "means": [], "worse": ["rooms.pq", "x"]}, "", 1.0)
    assert (compared.caught_by, compared.measured) == ("worse than before: rooms.pq", "rooms.pq, x")


@pytest.mark.parametrize(
    ("grade", "asked", "enough"),
    [
        (Grade("one", "pr", 7, "homes: origin", 2, 9.0, ""), (False, "a"), True),
        (Grade("one", "pr", 7, "homes: origin", 2, 9.0, ""), (True, "a"), False),
        (Grade("one", "pr", 7, "homes: origin", 2, 9.0, "", searched=True), (True, "a"), True),
        (Grade("one", "pr", 7, None, 2, 9.0, ""), (False, "a"), False),
        (Grade("one", "pr", 7, None, 2, 9.0, "", changed=0, against="a"), (False, "a"), True),
        (Grade("one", "pr", 7, None, 2, 9.0, "", changed=0, against="a"), (False, "b"), False),
        (Grade("one", "pr", 7, None, 2, 9.0, "", changed=0, against="a"), (False, ""), True),
        (Grade("one", "pr", 7, f"{COMPARED}: rooms.pq", 2, 9.0, "", changed=9, against="a"), (False, ""), False),
        (Grade("one", "pr", 7, None, 2, 9.0, ""), (False, ""), True),
    ],
)
def test_a_grade_is_used_again_only_if_it_says_what_is_asked(grade, asked, enough):
    assert grade.says(*asked) is enough


def test_the_last_grade_of_each_mutant_counts():
    mutants = MUTANTS[:2]
    grades = [Grade(each.name, "pr", 7, "a", 2, 9.0, "", fingerprint=each.fingerprint) for each in (*mutants, mutants[0])]
    grades[2] = replace(grades[2], searched=True)
    others = [replace(grades[0], seed=8), replace(grades[0], suite="homes"), replace(grades[1], fingerprint="old")]
    usable = usable_grades([*grades, *others], mutants, "pr", 7, smallest=False, before=None)
    assert usable == {mutants[0].name: grades[2], mutants[1].name: grades[1]}


def test_a_mutant_is_equivalent_if_no_figure_differs():
    before = [{"scenario": "a", "labels": {"accuracy": 0.5}, "time": 1}, {"scenario": "b", "labels": None, "time": 1}]
    slower = [each | {"time": 2, "versions": {"x": "1"}} for each in before]
    assert _changed([each | {"versions": {}} for each in before], slower[::-1]) == 0
    assert _changed(before, [before[0], {"scenario": "b", "labels": {"accuracy": 0.5}, "time": 1}]) == 1
    with pytest.raises(SimError, match="of other scenarios; valid: those of the same suite and seed"):
        _changed(before, [{"scenario": "c"}])
    same, other = (Grade("one", "pr", 7, None, 2, 9.0, "", changed=count) for count in (0, 1))
    assert "| equivalent: no figure differs |" in markdown_table([same])
    assert "| **not caught**; figures of 1 differ |" in markdown_table([other])


def test_results_that_were_stored_and_read_are_not_changed(tmp_path):
    faulty = replace(RESULT, scenario="f" * 16, faults=FaultFigures(("dropped:0.1",), {"dropped": 3}, 90, 0))
    save_results([RESULT, faulty], tmp_path / "all.json")
    stored = json.loads((tmp_path / "all.json").read_text())["results"]
    assert _changed(_stored(tmp_path / "all.json"), stored) == 0


def test_mutants_are_counted_by_how_they_are_found():
    ways = [
        ("homes: origin", None),
        ("the suite ends with status -6", None),
        ("the suite does not end", None),
        (f"{COMPARED}: rooms.pq", None),
        ("all parts: mean rooms.pq >= 0.7", 0),
        (None, 3),
        (None, None),
        (None, 0),
    ]
    grades = [Grade(str(k), "pr", 7, by, 9, 9.0, "", changed=changed) for k, (by, changed) in enumerate(ways)]
    assert counts(grades) == (
        "of 8 mutants, 2 are caught by a check, 2 abort without verdicts, and 1 are caught by the comparison with "
        "unchanged LEXIS; 2 pass, and 1 change no figure"
    )


def _ends_with(monkeypatch, status, errors):
    """Let the command that checks a mutant end without verdicts."""
    monkeypatch.setattr("sim.bench.mutation.grading._check", lambda folder, options: (status, "", errors))


@pytest.mark.parametrize(
    ("status", "errors", "caught_by"),
    [
        (-6, "Fatal Python error: Aborted", "the suite ends with status -6"),
        (1, "ZeroDivisionError: division by zero", "the suite ends with status 1"),
        (None, "", "the suite does not end"),
    ],
)
def test_a_mutant_with_which_lexis_ends_its_process_is_caught(status, errors, caught_by, monkeypatch):
    _ends_with(monkeypatch, status, errors)
    graded = grade(MUTANTS[0])
    assert (graded.caught_by, graded.scenarios) == (caught_by, 0)


@pytest.mark.parametrize(
    "errors",
    [
        "lexis-sim: all.json: has no results of the suite pr with seed 0; valid: a file of lexis-sim check",
        "lexis-sim: verdicts.json: cannot be written: No space left on device; valid: a place with room for it",
    ],
)
def test_a_suite_that_cannot_run_is_no_grade_of_a_mutant(errors, monkeypatch):
    _ends_with(monkeypatch, 2, errors)
    message = f"mutant {MUTANTS[0].name!r}: the suite ends with status 2: {errors}"
    with pytest.raises(SimError, match=re.escape(message)):
        grade(MUTANTS[0])


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--only", "no such bug"], "no mutant has this text in its name; valid: part of a name"),
        (["-o", "missing/grades.jsonl"], "missing/grades.jsonl: its folder does not exist; valid: a file in a folder"),
        (["--suite", "prr"], "unknown suite 'prr' (did you mean 'pr'?)"),
        (
            ["--suite", "homes", "--against", "other.json"],
            "has no results of the suite homes with seed 0; valid: a file of lexis-sim check",
        ),
    ],
    ids=["no mutant", "no folder", "no suite", "other scenarios"],
)
def test_a_wrong_set_up_is_refused_before_anything_is_graded(tmp_path, monkeypatch, capsys, options, said):
    monkeypatch.chdir(tmp_path)
    save_results([RESULT], Path("other.json"))
    assert main(["bench", "mutation", "--out", "grades.jsonl", *options]) == 2
    assert said in capsys.readouterr().err and not Path("grades.jsonl").exists()


_COMMAND = """#!{python}
import json, pathlib, sys, time
here = pathlib.Path(__file__).parent
if not (here / "unchanged").exists():  # the first suite checks unchanged LEXIS
    (here / "unchanged").touch()
    verdicts = dict(checks=[], results=[], means=[], worse=[])
    pathlib.Path(sys.argv[sys.argv.index("--json") + 1]).write_text(json.dumps(verdicts))
    sys.exit(0)
(here / "begun").touch()
time.sleep(20)
(here / "ended").touch()
"""
_MAIN = """
import signal, sys
from sim.cli import main
signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell ignores Ctrl-C in what it runs in the background
sys.executable = sys.argv[1]
sys.exit(main(sys.argv[2:]))
"""


def test_ctrl_c_ends_the_suites_that_are_running(tmp_path):
    command = tmp_path / "python"
    command.write_text(_COMMAND.format(python=sys.executable))
    command.chmod(0o755)
    options = ["bench", "mutation", "--only", "loop", "--processes", "2", "--out", str(tmp_path / "grades.jsonl")]
    with subprocess.Popen([sys.executable, "-c", _MAIN, str(command), *options]) as process:
        for _ in range(2400):  # two minutes
            if (tmp_path / "begun").exists() or process.poll() is not None:
                break
            time.sleep(0.05)
        assert (tmp_path / "begun").exists()
        process.send_signal(signal.SIGINT)
    assert process.returncode == 130
    assert not (tmp_path / "ended").exists() and not (tmp_path / "grades.jsonl").exists()


def test_grades_are_kept_in_a_file_to_go_on_from(tmp_path):
    grades = [
        Grade("one", "pr", 7, "homes: origin", 3, 12.0, "x", "2 rooms, 4 m", also=("stairs: origin",)),
        Grade("other", "pr", 7, None, 96, 300.0, ""),
    ]
    assert read_grades(tmp_path / "grades.jsonl") == []
    for each in grades:
        write_grade(each, tmp_path / "grades.jsonl")
    assert read_grades(tmp_path / "grades.jsonl") == grades
    (tmp_path / "bad.jsonl").write_text('{"mutant": "one"}\n')
    (tmp_path / "binary").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(SimError, match=r"binary: cannot be read: .* valid: a file that this benchmark has written"):
        read_grades(tmp_path / "binary")
    with pytest.raises(SimError, match=r"bad\.jsonl: line 1 is no grade; valid: a file that"):
        read_grades(tmp_path / "bad.jsonl")
    rows = markdown_table(grades).splitlines()
    assert rows[2:] == [
        "| one | homes: origin | 3 | 12 | 2 rooms, 4 m |  |",
        "| other | **not caught** | 96 | 300 |  |  |",
    ]
