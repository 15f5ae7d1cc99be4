"""The folder of a failure: the smallest scenario, a test that replays it, and a page that says why it fails."""

import json
from dataclasses import dataclass
from pathlib import Path

from sim.errors import SimError
from sim.harness.claims import Claim
from sim.harness.crash import Crash
from sim.harness.diagnosis.first_wrong import shown_failure
from sim.harness.failures.blame_table import BlameTable
from sim.harness.failures.why_page import why_page
from sim.harness.outputs import write_crash, write_run
from sim.harness.shrinking.failure_test import FailureTest
from sim.harness.shrinking.reduction import Reduction
from sim.harness.world_tests import TEST_REPLAY


@dataclass(frozen=True)
class Replay:
    """Python code by which a test runs the SLAM: import lines, and an expression that runs it on the variable `scenario`."""

    imports: str = "from sim.harness import run"
    run: str = "run(scenario)"
    new_slam: str = "None"
    """An expression for a function that makes the SLAM, or for a program; "None" for LEXIS."""
    before: str = ""
    """Lines of the test before it reads the scenario; "" for none. They import the module of a SLAM, because this module may
    declare the furniture of the scenario."""


LEXIS_REPLAY = Replay()


def write_failure(
    out: Path, reduction: Reduction, test: FailureTest, blamed: BlameTable, replay: Replay = LEXIS_REPLAY
) -> None:
    """Write the folder of the failure; a folder of an earlier run is replaced.

    The folder contains the files of `write_run` or, after a crash, of `write_crash`, and also original.json, test_replay.py,
    and why.md with its pictures. Except for original.json, all files are about the run of the smallest scenario. If `test`
    has not kept this run, the scenario is run once more. Raises `SimError` if the failure does not come back, `LexisError`
    where `out` holds anything else or cannot be written, and what the SLAM's `save` raises.
    """
    smallest = test.outcome(reduction.scenario)
    if test.signature_of(smallest) != reduction.signature:
        raise not_reproduced(reduction)
    original = json.dumps(reduction.original.data(), indent=1) + "\n"
    files = {"original.json": original.encode(), TEST_REPLAY: replay_test(test.condition, replay).encode()}
    reference = test.reference_run(reduction.scenario)
    files |= why_page(reduction, test, blamed, smallest, reference).files
    if isinstance(smallest, Crash):
        write_crash(smallest, out, files)
    else:
        assert test.condition is not None
        failure = shown_failure(
            smallest.run,
            f"{test.condition}: {test.condition.described(smallest.result)}",
            test.condition.figure,
            reference,
        )
        write_run(smallest.run, smallest.result, smallest.trials, out, files, failure)


def not_reproduced(reduction: Reduction) -> SimError:
    """Return the error for a failure that does not come back in another run of the smallest scenario."""
    again = "valid: a SLAM that does the same in the same scenario"
    return SimError(f"the failure ({reduction.signature}) did not come back in the smallest scenario; {again}")


def replay_test(claim: Claim | None, replay: Replay) -> str:
    """Return the text of a pytest file that runs the scenario of the same folder and fails until the SLAM is mended.

    `claim` describes the failure, such as "labels.accuracy < 0.7", and the test asserts that the claim is false. None stands
    for an exception of the SLAM: the test then asserts nothing, and fails while the SLAM raises an exception, be it in the
    run or in a plan.
    """
    return _replay_of_claim(claim, replay) if claim else _replay_of_exception(replay)


def _replay_of_exception(replay: Replay) -> str:
    return f'''"""Replays a failure. It fails as long as the SLAM crashes on the scenario beside it."""

from pathlib import Path

from sim.harness import Scenario, try_plans
{replay.imports}


def test_replay():
{replay.before}    scenario = Scenario.load(Path(__file__).with_name("scenario.json"))
    try_plans({replay.run})
'''


def _replay_of_claim(claim: Claim, replay: Replay) -> str:
    plans = claim.is_about_plans
    imports = "Claim, Scenario, evaluate" + (", try_plans" if plans else "")
    trials = ", try_plans(finished)" if plans else ""
    return f'''"""Replays a failure. It fails as long as {str(claim)!r} is true of the scenario beside it."""

from pathlib import Path

from sim.harness import {imports}
{replay.imports}


def test_replay():
{replay.before}    scenario = Scenario.load(Path(__file__).with_name("scenario.json"))
    finished = {replay.run}
    result = evaluate(finished{trials})
    wanted = Claim.parse("{claim.opposite}")
    assert wanted.outcome(result) == "holds", f"{claim.figure} is {{wanted.value(result)}}; wanted: {{wanted}}"
'''
