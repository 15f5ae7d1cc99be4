"""`lexis-sim check`: run any SLAM on a scenario, and exit with status 1 if a figure fails a condition."""

import argparse
import sys
from typing import TYPE_CHECKING

from lexis.command_line import Commands, add_command, warn_of_replacement
from sim.commands.arguments import add_scenario, folder, scenario_of_arguments
from sim.commands.run import print_result, progress_bar
from sim.commands.slams import add_slam, check_claimable, runner_of

if TYPE_CHECKING:
    from sim.harness import Claim, RunResult

FAILS_HELP = 'when the check fails, such as "labels.accuracy < 0.7"; may be repeated. A figure that is null fails too'


def add_to(commands: Commands) -> None:
    """Add the command `check`."""
    check = add_command(
        commands,
        "check",
        _check,
        "put a SLAM to the test in one run: exit status 1 names the figures that failed",
        'lexis-sim check --fidelity features --slam sim.harness.adapters:GeometricRooms --fails "floors.accuracy < 0.5"',
    )
    add_scenario(check)
    add_slam(check)
    check.add_argument("--fails", action="append", default=[], metavar="FIGURE", help=FAILS_HELP)
    check.add_argument("--out", type=folder, metavar="DIR", help="folder for the result and its report (default: none)")


def _check(arguments: argparse.Namespace) -> int:
    from sim.harness import Claim, evaluate, try_plans, write_run
    from sim.harness.outputs import MARKER

    claims = [Claim.parse(text) for text in arguments.fails]
    for claim in claims:
        check_claimable(arguments, claim)
    run, scenario = runner_of(arguments), scenario_of_arguments(arguments)
    if arguments.out is not None:
        warn_of_replacement(arguments.out, MARKER)
    with progress_bar("running the SLAM") as progress:
        finished = run(scenario, progress)
    trials = try_plans(finished)
    result = evaluate(finished, trials)
    if arguments.out is not None:
        write_run(finished, result, trials, arguments.out)
    print_result(finished, result)
    if arguments.out is not None:
        print(f"report: {arguments.out / 'report.html'}")
    failures = [line for claim in claims if (line := failure(claim, result))]
    print(*failures, sep="\n", end="\n" if failures else "", file=sys.stderr)
    return 1 if failures else 0


def failure(fails: "Claim", result: "RunResult") -> str:
    """Describe in one line how the figure fails; return "" if it does not."""
    value = fails.value(result)
    if value is None:
        return f"failed: {fails.figure} is null, because the run has no such figure; it cannot be judged by {str(fails)!r}"
    return f"failed: {fails.figure} is {value:g}, and fails if {fails}" if fails.outcome(result) == "holds" else ""
