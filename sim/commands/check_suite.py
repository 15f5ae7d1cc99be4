"""`lexis-sim check --suite`: checks a SLAM in many scenarios, by claims about its figures and by laws."""

import argparse
import json
import math
import os
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from lexis.files.replace import replaced_file
from sim.commands.run import progress_bar
from sim.commands.slams import is_lexis, program_of, refuse_program_options, replay_of, runner_of, slam_factory
from sim.durations import duration_s
from sim.errors import SimError

if TYPE_CHECKING:
    from sim.harness.results import RunResult
    from sim.suites.checks import NewSlam
    from sim.suites.report import CheckVerdict, SuiteReport
    from sim.verdicts.comparison import Comparison

SUITE_HELP = "check by a suite in place of one run: pr, open-plan or another; an unknown name lists them all"
AGAINST_HELP = "with --suite: results of an earlier version (a file of --json); the check fails if a figure got worse, too"
NO_LAWS_HELP = "with --suite: make claims about single runs only, which is several times faster"
IMAGES_HELP = "with --suite: render all scenarios, for a SLAM that does not accept features"
EXIT_HELP = "with --suite: stop when the first check fails"
JSON_HELP = "with --suite: write the verdicts and all results to a file, which lexis-sim compare reads"
LIMIT_HELP = "with --suite: another limit of a claim, such as labels.accuracy=0.9; may be repeated"
PICTURE_HELP = "with --suite: an SVG of room quality against openness, beside the plain SLAMs that are shipped"
BUDGET_HELP = "with --suite: wall time after which no further scenario is begun, such as 12m (default: no limit)"
WORKERS_HELP = "with --suite: number of processes (default: all processor cores)"
_OPTIONS = ("images", "no_laws", "exitfirst", "json", "against", "limit", "picture", "budget", "workers")
_MOST_WORKERS = 256


def add_suite(parser: argparse.ArgumentParser) -> None:
    """Add the options for suites."""
    parser.add_argument("--suite", metavar="NAME", help=SUITE_HELP)
    parser.add_argument("--images", action="store_true", default=None, help=IMAGES_HELP)
    parser.add_argument("--no-laws", action="store_true", default=None, help=NO_LAWS_HELP)
    parser.add_argument("-x", "--exitfirst", action="store_true", default=None, help=EXIT_HELP)
    parser.add_argument("--json", type=Path, metavar="FILE", help=JSON_HELP)
    parser.add_argument("--against", type=Path, metavar="FILE", help=AGAINST_HELP)
    parser.add_argument("--limit", action="append", type=_limit, metavar="FIGURE=VALUE", help=LIMIT_HELP)
    parser.add_argument("--picture", type=Path, metavar="FILE", help=PICTURE_HELP)
    parser.add_argument("--budget", type=duration_s, metavar="TIME", help=BUDGET_HELP)
    parser.add_argument("--workers", type=_workers, metavar="N", help=WORKERS_HELP)


def refuse_suite_options(arguments: argparse.Namespace) -> None:
    """Raise SimError if an option for suites is given without a suite."""
    for option in _OPTIONS:
        if getattr(arguments, option) is not None:
            raise SimError(f"--{option.replace('_', '-')} is for suites; valid: with --suite")


def run_suite(arguments: argparse.Namespace) -> int:
    """Check the chosen SLAM by the chosen suite, print the verdicts, and return 1 if a check fails."""
    from sim.suites.catalogue import suite_named
    from sim.suites.figure_table import figure_table
    from sim.suites.openness_chart import openness_chart
    from sim.suites.report import check_slam
    from sim.suites.smallest import write_smallest
    from sim.verdicts import load_results

    _refuse_scenario_options(arguments)
    suite = suite_named(arguments.suite).with_limits(dict(arguments.limit or ()))
    suite = suite.without_laws() if arguments.no_laws else suite
    suite = suite.with_images() if arguments.images else suite
    for path in (arguments.json, arguments.picture):
        if path is not None and not path.absolute().parent.is_dir():
            raise SimError(f"{path}: its folder does not exist; valid: a file in an existing folder")
    before = None if arguments.against is None else load_results(arguments.against)
    new_slam, workers = _new_slam(arguments), arguments.workers or os.cpu_count() or 1
    with progress_bar("checking by the suite") as progress:
        budget_s = math.inf if arguments.budget is None else arguments.budget
        report = check_slam(new_slam, suite, arguments.seed, workers, bool(arguments.exitfirst), progress, budget_s)
    for line in _lines(report.failed if arguments.exitfirst and report.failed else report.verdicts):
        print(line)
    for mean in report.means:
        print(f"{mean.outcome:11} {mean.name}")
    print(figure_table(report))
    print(f"{len(report.examined)} of {sum(part.n for part in report.suite.parts)} scenarios were examined")
    comparison = None if before is None else _compared(report, before)
    worse = () if comparison is None else comparison.worse
    if arguments.json is not None:
        _write_json(report, worse, arguments.json)
    if arguments.picture is not None:
        with replaced_file(arguments.picture) as beside:
            beside.write_text(openness_chart(report, workers))
    for verdict in (*report.failed, *report.failed_means):
        print(f"failed: {verdict}", file=sys.stderr)
    if comparison is not None:
        print(comparison)
    elif before is not None:
        print(f"not compared with {arguments.against}, which has none of the scenarios that were completed", file=sys.stderr)
    if worse:
        print(f"failed: {', '.join(worse)} worse than in {arguments.against}", file=sys.stderr)
    if report.failed and arguments.out is None:
        print("--out DIR writes the smallest scenario in which each failed check still fails", file=sys.stderr)
    if arguments.out is not None:
        how = runner_of(arguments), replay_of(arguments), is_lexis(arguments)
        for verdict, others in _by_figure(report.failed):
            print(write_smallest(verdict, new_slam, *how, arguments.out))
            for other in others:
                print(f"{other.name}: not searched, because it is about the same figure")
    return 0 if report.ok and not worse and (before is None or comparison is not None) else 1


def _by_figure(failed: "Sequence[CheckVerdict]") -> "list[tuple[CheckVerdict, list[CheckVerdict]]]":
    """Return the failed checks for which the smallest scenario is searched, each with the others of the same figure.

    Claims of one part about one figure mostly fail for the same reason. The first of them stands for all.
    """
    from sim.suites.checks import ClaimCheck

    groups: dict[tuple[str, str], list[CheckVerdict]] = {}
    for verdict in failed:
        check = verdict.checked
        figure = check.claim.figure if isinstance(check, ClaimCheck) else verdict.check
        groups.setdefault((verdict.part.name, figure), []).append(verdict)
    return [(first, others) for first, *others in groups.values()]


def _compared(report: "SuiteReport", before: "Sequence[RunResult]") -> "Comparison | None":
    """Compare the results with earlier results of the same scenarios; None if no scenario has results of both."""
    from sim.verdicts import compare_results

    examined = {each.scenario.content_hash for each in report.examined}
    earlier = [result for result in before if result.scenario in examined]
    common = {result.scenario for result in report.results} & {result.scenario for result in earlier}
    return compare_results(earlier, report.results) if common else None


def _lines(verdicts: "Sequence[CheckVerdict]") -> Iterator[str]:
    """Yield a line for each check of the parts that have begun, and a line with the names of the other parts."""
    for verdict in verdicts:
        if verdict.is_begun:
            held, wanted = len(verdict.examined) - len(verdict.failures), 1.0 if verdict.rate is None else verdict.rate
            yield f"{verdict.outcome:11} {held:3} of {len(verdict.examined):<3} wanted: {wanted:4.0%}  {verdict.name}"
    if missing := dict.fromkeys(verdict.part.name for verdict in verdicts if not verdict.is_begun):
        yield f"not examined: {', '.join(missing)}"


def _write_json(report: "SuiteReport", worse: Sequence[str], path: Path) -> None:
    from sim.verdicts.stored_results import results_data

    with replaced_file(path) as beside:
        data = results_data(report.results) | report.data() | {"worse": list(worse)}
        beside.write_text(json.dumps(data, indent=1) + "\n")


def _new_slam(arguments: argparse.Namespace) -> "NewSlam":
    from sim.harness import Lexis

    if arguments.program is not None:
        return program_of(arguments)
    refuse_program_options(arguments)
    return Lexis if arguments.slam is None else slam_factory(arguments.slam)


def _refuse_scenario_options(arguments: argparse.Namespace) -> None:
    """Raise SimError for an option that describes a single run, except the seed."""
    given = [n for n, value in arguments.defaults_of_a_run.items() if n != "seed" and getattr(arguments, n) != value]
    given += ["scenario"] if arguments.scenario is not None else []
    given += ["fails"] if arguments.fails else []
    if given:
        option = f"--{given[0].replace('_', '-')}"
        raise SimError(f"{option} is given beside --suite; valid: one of the two, since a suite has scenarios of its own")


def _limit(text: str) -> tuple[str, float]:
    name, _, value = text.partition("=")
    try:
        return name, float(value)
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r:.60} is no limit; valid: such as labels.accuracy=0.9") from None


def _workers(text: str) -> int:
    if not text.isdigit() or not 1 <= int(text) <= _MOST_WORKERS:
        raise argparse.ArgumentTypeError(f"{text!r:.60} is no number of processes; valid: 1 to {_MOST_WORKERS}")
    return int(text)
