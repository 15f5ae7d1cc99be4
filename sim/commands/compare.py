"""`lexis-sim compare`: compare the results of two SLAMs on the same scenarios; exit status 1 if the second is worse."""

import argparse
import sys
from dataclasses import replace
from pathlib import Path

from lexis.command_line import Commands, add_command
from lexis.errors import one_line
from sim.commands.arguments import number
from sim.errors import SimError
from sim.wording import counted

CLAIM_HELP = 'a claim that is compared besides the figures, such as "rooms.pq >= 0.6"; may be repeated'
CONFIDENCE_HELP = "1 minus the largest probability that a difference is stated where there is none (default: 0.95)"

_MOST = 160
"""Largest number of letters in the description of how two scenarios differ."""


def add_to(commands: Commands) -> None:
    """Add the command `compare`."""
    parser = add_command(
        commands,
        "compare",
        _compare,
        "whether a SLAM does worse than another on the same scenarios: exit status 1 if it does",
        'lexis-sim compare before.json after.json --claim "rooms.pq >= 0.6"',
    )
    stored = "a file that `check --json` has written, the folder of a run, or a folder of such folders"
    parser.add_argument("a", type=Path, metavar="A", help=f"results to compare with: {stored}")
    parser.add_argument("b", type=Path, metavar="B", help="results that are judged, on the same scenarios")
    parser.add_argument("--claim", action="append", default=[], metavar="CLAIM", help=CLAIM_HELP)
    parser.add_argument("--confidence", type=number(0.51, 0.9999), default=0.95, metavar="SHARE", help=CONFIDENCE_HELP)


def _compare(arguments: argparse.Namespace) -> int:
    from sim.harness import Claim
    from sim.verdicts import SuiteResults

    claims = [Claim.parse(text) for text in arguments.claim]
    a, b = SuiteResults.load(arguments.a), SuiteResults.load(arguments.b, may_be_empty=True)
    comparison = a.compared_with(b, claims, arguments.confidence)
    if comparison is None:
        if not a.completed & b.known:
            counts = f"{arguments.a} ({counted(len(a.known), 'scenario')}) and {arguments.b} ({len(b.known)})"
            raise SimError(
                f"{counts} have no completed scenario in common{_difference(arguments.a, arguments.b)}; "
                "valid: results of two SLAMs on the same scenarios"
            )
        print(f"failed: {arguments.b} has no result for any completed scenario of {arguments.a}", file=sys.stderr)
        return 1
    first, second = comparison.names
    print(replace(comparison, names=(f"{first} ({arguments.a})", f"{second} ({arguments.b})")))
    if comparison.worse:
        print(f"failed: {', '.join(comparison.worse)} of {arguments.b} worse than of {arguments.a}", file=sys.stderr)
    return 1 if comparison.worse else 0


def _difference(a: Path, b: Path) -> str:
    """Say how the scenarios of two runs differ, for the folders of single runs.

    The text is empty for other results, and for equal scenarios.
    """
    from sim.harness import Scenario
    from sim.harness.run_settings import with_listed_house
    from sim.harness.shrinking.scenario_difference import difference
    from sim.harness.world_tests import SCENARIO

    files = a / SCENARIO, b / SCENARIO
    if not all(file.is_file() for file in files):
        return ""
    first, second = (with_listed_house(Scenario.load(file)) for file in files)
    if first == second:
        return ""
    return f" (from the first to the second: {one_line(difference(first, second), _MOST)})"
