"""The folder of a failed test: the scenario, the figures and report of the run, and a test that replays the failure."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from lexis.files.replace import replaced_folder
from sim.harness.outputs import fill_run_folder
from sim.harness.planning import Trial
from sim.harness.results import RunResult
from sim.harness.runner import Run
from sim.harness.scenario import Scenario
from sim.harness.world_tests import SCENARIO, slug_of

_REPLAY = '''"""Replays a failure of {test}: run pytest on this file, anywhere below the folder that holds {file}."""

import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
TEST_FILE = {file!r}
TEST = {test!r}
OPTIONS = {options!r}


def test_replay():
    places = [*HERE.parents, Path.cwd(), *Path.cwd().parents]
    top = next((place for place in places if (place / TEST_FILE).exists()), None)
    assert top is not None, f"{{TEST_FILE}} is not found from {{HERE}}; valid: a place below the folder that holds the file"
    command = [sys.executable, "-m", "pytest", TEST, *OPTIONS, "--lexis-replay", str(HERE), "--lexis-out", str(HERE.parent)]
    done = subprocess.run(command, cwd=top, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
'''


@dataclass(frozen=True, eq=False)
class FinishedRun:
    """What is known about a run that came to its end."""

    run: Run
    result: RunResult
    trials: Sequence[Trial]


def folder_of(out: Path, name: str, scenario: Scenario) -> Path:
    """The folder for a failure of a test on a scenario: the same failure gets the same folder."""
    return out / f"{slug_of(name)}-{scenario.content_hash}"


def write_failed_test(
    folder: Path,
    name: str,
    options: Sequence[str],
    scenario: Scenario,
    finished: FinishedRun | None,
    original: Scenario | None = None,
) -> None:
    """Write scenario.json and test_replay.py, and the files of `write_run` if the run came to its end.

    `name` is the test as pytest names it, file and function without parameters, such as "tests/test_slam.py::test_rooms".
    `options` are the options of pytest that a replay needs besides the scenario. `original` is the scenario before it was
    made smaller, if it was. An earlier folder of the same failure is replaced. Raises `LexisError` where `folder` holds
    anything else or cannot be written.
    """
    with replaced_folder(folder, SCENARIO) as new:
        if finished is not None:
            fill_run_folder(finished.run, finished.result, finished.trials, new)
        scenario.save(new / SCENARIO)
        if original is not None:
            original.save(new / "original.json")
        (new / "test_replay.py").write_text(_REPLAY.format(test=name, file=name.partition("::")[0], options=list(options)))
