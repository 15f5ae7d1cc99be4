"""`lexis-sim shrink`: the smallest scenario that fails in the same way, and what is to blame."""

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from lexis.command_line import Commands, add_command, warn_of_replacement
from sim.commands.arguments import folder
from sim.errors import SimError

if TYPE_CHECKING:
    from sim.harness.reducer import Attempt

FAILS_HELP = 'what is true of a failing run, such as "labels.accuracy < 0.7"'
DEADLINE_HELP = "such as 90s or 3m; the smallest failure so far is kept (default: 3m)"
KEEP_HELP = 'a step that is not tried, such as "drop furniture" or "simplest labels"; may be repeated'
_UNITS_S = {"s": 1.0, "m": 60.0, "h": 3600.0}


def add_to(commands: Commands) -> None:
    """Add the command."""
    shrink = add_command(
        commands,
        "shrink",
        _shrink,
        "the smallest scenario that fails in the same way, and what is to blame",
        'lexis-sim shrink lexis-run/scenario.json --fails "rooms.pq < 0.7" -o failure',
    )
    shrink.add_argument("scenario", type=Path, metavar="SCENARIO", help="scenario.json of a run, or the run's folder")
    shrink.add_argument("--fails", required=True, metavar="CLAIM", help=FAILS_HELP)
    shrink.add_argument("--deadline", type=duration, default=180.0, metavar="TIME", help=DEADLINE_HELP)
    shrink.add_argument("--keep", action="append", default=[], metavar="STEP", help=KEEP_HELP)
    shrink.add_argument("-o", "--out", type=folder, required=True, metavar="DIR", help="folder to write")


def duration(text: str) -> float:
    """Seconds from a text such as 90s, 3m or 1h, for `type=`."""
    number, unit = (text[:-1], text[-1:]) if text[-1:] in _UNITS_S else (text, "s")
    try:
        seconds = float(number) * _UNITS_S[unit]
    except ValueError:
        seconds = -1.0
    if not 0.0 < seconds < 1e7:
        raise argparse.ArgumentTypeError(f"{text!r}; valid: a time such as 90s, 3m or 1h")
    return seconds


def _shrink(arguments: argparse.Namespace) -> int:
    from sim.harness import Claim, Scenario, blame, run
    from sim.harness.failure_folder import write_failure
    from sim.harness.failure_signature import FailureTest
    from sim.harness.outputs import MARKER
    from sim.harness.reducer import reduce
    from sim.harness.reductions import STEPS

    test = FailureTest(Claim.parse(arguments.fails), lambda scenario, progress: run(scenario, None, progress))
    path = arguments.scenario
    scenario = Scenario.load(path / "scenario.json" if path.is_dir() else path)
    if unknown := [name for name in arguments.keep if name not in STEPS]:
        raise SimError(f"--keep {unknown[0]!r:.80}: no such step; valid: {', '.join(STEPS)}")
    steps = {name: step for name, step in STEPS.items() if name not in arguments.keep}
    warn_of_replacement(arguments.out, MARKER)
    tell = _print_progress if sys.stderr.isatty() else None
    reduction = reduce(scenario, test, arguments.deadline, tell, steps=steps)
    blamed = blame(reduction.scenario, test, is_lexis=True)
    write_failure(arguments.out, reduction, test, blamed)
    old, new = reduction.sizes
    print(f"rooms {old.rooms} -> {new.rooms}, walk {old.length_m:g} -> {new.length_m:g} m. {reduction.note}")
    print(str(blamed))
    print(f"why: {arguments.out / 'why.md'}")
    return 0


def _print_progress(attempt: "Attempt") -> None:
    print(f"\r{attempt.elapsed_s:5.0f} s, {attempt.tried} candidates, {attempt.step:<20}", end="", file=sys.stderr)
