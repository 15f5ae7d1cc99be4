"""The smallest scenario in which a check of a suite fails, and a test that replays it; for a claim or a crash, its cause."""

import re
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from lexis.errors import LexisError, one_line
from sim.errors import USER_ERRORS, SimError
from sim.harness.adapters.lexis import Lexis
from sim.harness.crash import COMPLETES, Runner
from sim.harness.failures.blame_table import blame
from sim.harness.failures.failure_folder import LEXIS_REPLAY, Replay, not_reproduced, write_failure
from sim.harness.failures.why_page import WHY
from sim.harness.outputs import MARKERS
from sim.harness.run_settings import with_listed_house
from sim.harness.scenario import Scenario
from sim.harness.shrinking.failure_signature import Signature
from sim.harness.shrinking.failure_test import FailureTest
from sim.harness.shrinking.reducer import DEADLINE_S, reduce
from sim.harness.shrinking.reduction import Reduction
from sim.harness.world_tests import TEST_REPLAY, slug_of
from sim.suites import catalogue
from sim.suites.checks import Check, CheckFinding, ClaimCheck, NewSlam
from sim.suites.examination import DIED, finding, replayed_finding
from sim.suites.replay_folder import write_replay_folder
from sim.suites.report import CheckVerdict
from sim.wording import error_text

_NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?")
_REPLAY = '''"""Replays a failure. It fails as long as the check {name!r} fails in the scenario beside it."""

from pathlib import Path

from sim.harness import Scenario
from sim.suites.smallest import finding_of
{imports}


def test_replay():
{before}    scenario = Scenario.load(Path(__file__).with_name("scenario.json"))
    found = finding_of({part!r}, {check!r}, scenario, {new_slam})
    assert found.holds is True, found.measured
'''


def finding_of(part: str, check: str, scenario: Scenario, new_slam: NewSlam | None = None) -> CheckFinding:
    """Evaluate one check of a suite on a scenario.

    Args:
        part: name of the part of a suite that has the check.
        check: name of the check.
        scenario: any scenario.
        new_slam: makes a SLAM, or is a program; None: LEXIS.

    Raises `SimError` for an unknown check and an impossible scenario.
    """
    parts = [each for suite in catalogue.SUITES.values() for each in suite.parts if each.name == part]
    known: dict[str, Check | None] = {COMPLETES: None} | {each.name: each for found in parts for each in found.checks}
    if not parts or check not in known:
        raise SimError(f"no suite has the check {part}: {check}; valid: a check that lexis-sim check --suite prints")
    return replayed_finding(known[check], scenario, new_slam or Lexis)


def smallest_failure(
    check: Check | None, scenario: Scenario, new_slam: NewSlam, deadline_s: float = DEADLINE_S
) -> Reduction:
    """Make a scenario smaller while a check fails in it; None stands for the check that the run completes.

    Raises `SimError` if the check does not fail in the scenario.
    """

    def fails(candidate: Scenario) -> Signature | None:
        return _signature(check, finding(check, candidate, new_slam))

    return reduce(scenario, fails, deadline_s)


@dataclass(frozen=True)
class SlamUnderSearch:
    """The SLAM whose failures are searched, in the forms that the parts of a search need."""

    new_slam: NewSlam
    """Makes the SLAM, or is a program."""
    runner: Runner
    """Runs the same SLAM on a scenario."""
    replay: Replay
    """Python code that runs the same SLAM."""
    is_lexis: bool
    reference: Runner | None = None
    """Runs a SLAM without the failures. Where it fulfils a claim in the original scenario, a smaller scenario counts only if
    it does so there, too."""


def write_smallest(verdict: CheckVerdict, slam: SlamUnderSearch, out: Path) -> tuple[str, bool]:
    """Write the smallest scenario in which a check fails into a folder of its own in `out`.

    Return what was found, as text, and whether the user has interrupted the search. The smallest failure so far is written
    then, too.

    For a claim or a crash, the folder is like one of `lexis-sim shrink`, with a page that says why the SLAM fails. For any
    other check, it holds the scenario, a short page, and a test that replays the failure. If the failure did not come back,
    the text says so.

    An exception, for example because the folder cannot be written, becomes part of the text, and the search goes on with the
    next check.
    """
    try:
        return _written(verdict, slam, out)
    except (SimError, LexisError) as error:
        return f"{verdict.name}: no smallest scenario: {error}", False
    except USER_ERRORS as error:  # such as an exception in the SLAM's method `save`
        return f"{verdict.name}: no smallest scenario: {one_line(error_text(error), 160)}", False


def _written(verdict: CheckVerdict, slam: SlamUnderSearch, out: Path) -> tuple[str, bool]:
    folder = out / slug_of(verdict.name)
    check = verdict.checked
    if check is None and verdict.failures[0].findings[COMPLETES].measured == DIED:
        raise SimError(f"{DIED}, and the search runs in this process; valid: lexis-sim shrink with a program (--command)")
    scenario = verdict.failures[0].scenario
    test, note = _failure_test(check, scenario, slam.runner, slam.reference)
    if test is not None:
        reduction = reduce(scenario, test, DEADLINE_S)
        blamed = blame(reduction, test, slam.is_lexis)
        write_failure(folder, reduction, test, blamed, slam.replay)
        found, interrupted = f"{blamed}{note}\n  why: {folder / WHY}", blamed.interrupted
    else:
        reduction = smallest_failure(check, scenario, slam.new_slam)
        imports = "" if slam.replay == LEXIS_REPLAY else slam.replay.imports
        names = {"name": verdict.name, "part": verdict.failures[0].part, "check": verdict.check}
        smallest = finding(check, reduction.scenario, slam.new_slam)
        if _signature(check, smallest) != reduction.signature:
            raise not_reproduced(reduction)
        replay = _REPLAY.format(**names, imports=imports, before=slam.replay.before, new_slam=slam.replay.new_slam)
        write_replay_folder(folder, reduction.scenario, _why(verdict, smallest.measured, reduction), replay, MARKERS)
        found, interrupted = f"replay: pytest {folder / TEST_REPLAY}", reduction.ended == "interrupted"
    old, new = reduction.sizes
    return f"{verdict.name}: {old} -> {new}\n  {found}", interrupted


def _failure_test(
    check: Check | None, scenario: Scenario, runner: Runner, reference: Runner | None
) -> tuple[FailureTest | None, str]:
    """Return the test with which `lexis-sim shrink` would search, and a line that says why the reference is not used, or "".

    The test is None for a law, for an invalid estimate, and if the SLAM cannot be made. The reference is used for a claim
    that it fulfils in the scenario.
    """
    if isinstance(check, ClaimCheck):
        test, listed = FailureTest(check.claim.opposite, runner, reference), with_listed_house(scenario)
        if reference is None or test(listed) != Signature(str(test)).of_reference:
            return test, ""
        note = f"\n  the reference is not used, because it fails, too: {test.reference_fails(listed)}"
        return FailureTest(test.condition, runner), note
    crash = FailureTest(None, runner)
    with suppress(*USER_ERRORS):
        if check is None and crash(with_listed_house(scenario)) is not None:
            return crash, ""
    return None, ""


def _signature(check: Check | None, found: CheckFinding) -> Signature | None:
    """Return the signature of a check that fails, from what it found; None if it does not fail.

    If no run was completed, the signature is what was found without its numbers, because a smaller scenario has others.
    """
    if found.holds is not False:
        return None
    return Signature(_NUMBER.sub("...", found.measured.partition("; valid:")[0]) if check is None else check.name)


def _why(verdict: CheckVerdict, measured: str, reduction: Reduction) -> tuple[str, ...]:
    """Return the paragraphs of the page about a failed law: what the law demands, and what was measured."""
    old, new = reduction.sizes
    return (
        f"# {verdict.name}",
        verdict.says,
        f"In the smallest scenario ({new}): {measured}",
        f"In the original scenario ({old}): {verdict.failures[0].findings[verdict.check].measured}",
        "Run `pytest PATH/test_replay.py`, with the path of this folder, where the suite was started. It checks this again.",
    )
