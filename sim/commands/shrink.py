"""`lexis-sim shrink`: finds the smallest scenario that fails in the same way, and which part of the run is to blame."""

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from lexis.command_line import Commands, add_command, interrupted_later, warn_of_replacement
from sim.commands.arguments import folder
from sim.commands.slams import add_slam, check_claimable, is_lexis, replay_of, runner_of, runner_of_class
from sim.durations import duration_s
from sim.errors import SimError

if TYPE_CHECKING:
    from sim.harness.failures.blame_table import BlameRow
    from sim.harness.shrinking.reducer import TriedCandidate

FAILS_HELP = 'what is true of a failing run, such as "labels.accuracy < 0.7"; or the word crash, for a SLAM that raises'
DEADLINE_HELP = "such as 90s or 3m; the smallest failure so far is kept (default: 3m; 10m with --command)"
REFERENCE_HELP = (
    "a SLAM without the failure, such as an earlier version or sim.harness.adapters:Lexis; a smaller scenario counts only "
    "if this SLAM passes there"
)
KEEP_HELP = 'a step that is not tried, such as "drop furniture" or "simplest labels"; may be repeated'
_PROGRAM_DEADLINE_S = 600.0
"""Default deadline for programs [s]. It is long, because every candidate has to be recorded for the program."""


def add_to(commands: Commands) -> None:
    """Add the command `shrink`."""
    shrink = add_command(
        commands,
        "shrink",
        _shrink,
        "the smallest scenario that fails in the same way, and what is to blame",
        'lexis-sim shrink lexis-run/scenario.json --fails "rooms.pq < 0.7" -o failure',
    )
    shrink.add_argument("scenario", type=Path, metavar="SCENARIO", help="scenario.json of a run, or the run's folder")
    shrink.add_argument("--fails", required=True, metavar="CONDITION", help=FAILS_HELP)
    add_slam(shrink)
    shrink.add_argument("--reference", metavar="MODULE:CLASS", help=REFERENCE_HELP)
    shrink.add_argument("--deadline", type=duration_s, metavar="TIME", help=DEADLINE_HELP)
    shrink.add_argument("--keep", action="append", default=[], metavar="STEP", help=KEEP_HELP)
    shrink.add_argument("-o", "--out", type=folder, required=True, metavar="DIR", help="folder to write")


def _shrink(arguments: argparse.Namespace) -> int:
    from sim.harness import Scenario, blame
    from sim.harness.failures.failure_folder import write_failure
    from sim.harness.failures.why_page import WHY
    from sim.harness.outputs import MARKERS
    from sim.harness.shrinking.failure_test import FailureTest, check_fails
    from sim.harness.shrinking.reducer import DEADLINE_S, reduce
    from sim.harness.shrinking.reductions import STEPS
    from sim.harness.world_tests import SCENARIO

    reference = None if arguments.reference is None else runner_of_class(arguments.reference, "--reference")
    test = FailureTest.parse(arguments.fails, runner_of(arguments), reference)
    if test.condition is not None:
        check_claimable(arguments, test.condition)
    path = arguments.scenario
    scenario = Scenario.load(path / SCENARIO if path.is_dir() else path)
    if unknown := [name for name in arguments.keep if name not in STEPS]:
        raise SimError(f"--keep {unknown[0]!r:.80}: no such step; valid: {', '.join(STEPS)}")
    steps = {name: step for name, step in STEPS.items() if name not in arguments.keep}
    source = path if path.is_dir() else path.parent
    is_shrunk = (source / WHY).exists()  # a search that goes on from its own result may replace it
    if not is_shrunk and arguments.out.exists() and arguments.out.samefile(source):
        raise SimError(f"-o {arguments.out}: is the folder of the scenario that is read; valid: another folder")
    warn_of_replacement(arguments.out, *MARKERS)
    check_fails(scenario, test)
    tell = _print_progress if sys.stderr.isatty() else None
    deadline_s = arguments.deadline or (DEADLINE_S if arguments.program is None else _PROGRAM_DEADLINE_S)
    reduction = reduce(scenario, test, deadline_s, tell, steps=steps)
    blamed = blame(reduction, test, is_lexis(arguments), None if tell is None else _print_substitution)
    if tell is not None:
        print(file=sys.stderr)
    with interrupted_later():  # Ctrl-C ends the search early, but must not lose what was found
        write_failure(arguments.out, reduction, test, blamed, replay_of(arguments))
    old, new = reduction.sizes
    print(f"{old} -> {new}. {reduction.note}")
    print(str(blamed))
    if blamed.original is not None:
        print(f"in the original scenario: {blamed.original}")
    if blamed.another_error:
        print(blamed.another_error)
    print(f"why: {arguments.out / WHY}")
    return 0


def _print_substitution(row: "BlameRow") -> None:
    print(f"\r{'replaced: ' + row.substitution:<60}", end="", file=sys.stderr)


def _print_progress(tried: "TriedCandidate") -> None:
    print(f"\r{tried.elapsed_s:5.0f} s, {tried.tried} candidates, {tried.step:<20}", end="", file=sys.stderr)
