"""`lexis-sim check`: run any SLAM on a scenario or a suite, and exit with status 1 if it crashes or a check fails."""

import argparse
import shlex
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from typing import TYPE_CHECKING

from lexis.command_line import MAX_LINE, Commands, add_command, warn_of_replacement
from lexis.errors import one_line
from sim.commands.arguments import add_scenario, folder, scenario_of_arguments
from sim.commands.check_suite import add_suite, refuse_suite_options, run_suite
from sim.commands.progress import progress_bar
from sim.commands.run import print_gaps, print_result
from sim.commands.slams import add_slam, check_claimable, replay_of, runner_of, slam_options
from sim.errors import EstimateError, SimError

if TYPE_CHECKING:
    from sim.harness import Claim, RunResult, Scenario
    from sim.harness.crash import Crash

OUT_HELP = "folder for the result and its report; with --suite, for the smallest failing scenarios (default: none)"
FAILS_HELP = (
    'condition under which the check fails, such as "labels.accuracy < 0.7"; a null figure fails too; may be repeated'
)


def add_to(commands: Commands) -> None:
    """Add the command `check`."""
    check = add_command(
        commands,
        "check",
        _check,
        "put a SLAM to the test in one run or in a suite: exit status 1 if it crashes or if a figure fails",
        'lexis-sim check --fidelity features --slam sim.harness.adapters:GeometricRooms --fails "floors.accuracy < 0.5"',
    )
    add_scenario(check)
    add_slam(check)
    add_suite(check)
    check.add_argument("--fails", action="append", default=[], metavar="CONDITION", help=FAILS_HELP)
    check.add_argument("-o", "--out", type=folder, metavar="DIR", help=OUT_HELP)


def _check(arguments: argparse.Namespace) -> int:
    if arguments.suite is not None:
        return run_suite(arguments)
    refuse_suite_options(arguments)
    from sim.harness import Claim, evaluate, write_run
    from sim.harness.crash import Crash, attempt, attempt_plans, attempt_write
    from sim.harness.outputs import MARKERS, REPORT
    from sim.harness.shrinking.failure_test import CRASH

    if CRASH in arguments.fails:
        raise SimError(
            f"--fails {CRASH}: a crash always fails check; valid: without it, or lexis-sim shrink --fails {CRASH}"
        )
    claims = [Claim.parse(text, "condition") for text in arguments.fails]
    for claim in claims:
        check_claimable(arguments, claim)
    run, scenario = runner_of(arguments), scenario_of_arguments(arguments)
    if arguments.out is not None:
        warn_of_replacement(arguments.out, *MARKERS)
    with _estimate_kept(scenario, arguments):
        with progress_bar(_work(arguments)) as progress:
            finished = attempt(run, scenario, progress)
        if isinstance(finished, Crash):
            return _crashed(finished, arguments)
        trials = attempt_plans(finished)
    if isinstance(trials, Crash):
        return _crashed(trials, arguments)
    result = evaluate(finished, trials)
    crash = None
    if arguments.out is not None:  # before anything is printed, because standard output may be closed
        crash = attempt_write(finished, partial(write_run, finished, result, trials, arguments.out))
    print_result(finished, result, nulls=False, keys=True)
    print_gaps(finished, result)
    if crash is not None:
        return _crashed(crash, arguments)
    if arguments.out is not None:
        print(f"report: {arguments.out / REPORT}")
    failed = [(claim, outcome) for claim in claims if (outcome := claim.outcome(result)) != "fails"]
    for claim, _ in failed:
        print(_failure(claim, result), file=sys.stderr)
    if (true := next((claim for claim, outcome in failed if outcome == "holds"), None)) is not None:
        print(_next_step(true, arguments), file=sys.stderr)
    return 1 if failed else 0


def _work(arguments: argparse.Namespace) -> str:
    """Return what the progress bar shows. A program begins when the bar is full, because it reads a whole recording."""
    return "running the SLAM" if arguments.program is None else "recording the walk, then running the program"


def _next_step(fails: "Claim", arguments: argparse.Namespace) -> str:
    """Return a line that says how to find the smallest scenario in which the condition `fails` is true."""
    if arguments.out is None:
        return "--out DIR keeps the run, so that lexis-sim shrink can find the smallest scenario that fails, with pictures"
    options = *slam_options(arguments), "--fails", str(fails), "-o", "failure"
    return (
        f"smallest scenario that fails, with pictures: {shlex.join(['lexis-sim', 'shrink', str(arguments.out), *options])}"
    )


def _crashed(crash: "Crash", arguments: argparse.Namespace) -> int:
    """Print the traceback of a crash and one line about it, and write its folder if `--out` is given; return status 1."""
    print(crash.traceback, end="", file=sys.stderr)
    print(one_line(f"failed: {crash.sentence}", MAX_LINE), file=sys.stderr)
    _write_crash(f"The SLAM {crash.what}", crash, arguments)
    return 1


@contextmanager
def _estimate_kept(scenario: "Scenario", arguments: argparse.Namespace) -> Iterator[None]:
    """If the estimate of the SLAM is refused in the block, write the folder of `--out`, then pass the error on."""
    from sim.harness.crash import Crash
    from sim.harness.last_run import noted

    with noted() as last:
        try:
            yield
        except EstimateError as error:
            _write_crash("The estimate of the SLAM is not valid", Crash(scenario, error, None, last.slam_name), arguments)
            raise


def _write_crash(title: str, crash: "Crash", arguments: argparse.Namespace) -> None:
    """Write the folder of a crash, whose page has this title, if `--out` is given."""
    from sim.harness.failures.failure_folder import replay_test
    from sim.harness.failures.why_page import WHY, crash_page
    from sim.harness.outputs import write_crash
    from sim.harness.world_tests import TEST_REPLAY

    if arguments.out is not None:
        replay = replay_test(None, replay_of(arguments))
        write_crash(crash, arguments.out, {TEST_REPLAY: replay.encode(), **crash_page(title, crash).files})
        print(f"why: {arguments.out / WHY}")


def _failure(fails: "Claim", result: "RunResult") -> str:
    """Return one line that says that the condition `fails` is true, or that it cannot be judged."""
    if fails.value(result) is None:
        null = " or ".join(fails.figures)
        why = "the SLAM does not estimate what it needs, or for too few frames only, or nothing in the run calls for it"
        return f"failed: {null} is null: {why}; it cannot be judged by {str(fails)!r}"
    return f"failed: {fails.described(result)}, and fails if {fails}"
