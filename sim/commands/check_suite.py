"""`lexis-sim check --suite`: checks a SLAM in many scenarios, by claims about its figures and by laws."""

import argparse
import json
import math
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from lexis.files.replace import replaced_file
from sim.commands.arguments import given_options_of_a_run, whole_number
from sim.commands.earlier_results import EarlierResults
from sim.commands.progress import progress_bar
from sim.commands.slams import (
    is_lexis,
    program_of,
    refuse_program_options,
    replay_of,
    runner_of,
    runner_of_class,
    slam_factory,
)
from sim.commands.suite_lines import suite_lines
from sim.durations import duration_s
from sim.errors import SimError
from sim.output_files import check_ending, check_output_file, make_output_folder
from sim.processes import usable_cores

if TYPE_CHECKING:
    from sim.harness.crash import Runner
    from sim.suites.checks import NewSlam
    from sim.suites.report import CheckVerdict, SuiteReport
    from sim.suites.suite import Suite

SUITE_HELP = (
    "check by a suite in place of one run: pr, open-plan, homes, twins, stairs, revisits, no-drift, language, faults, long "
    "or images"
)
AGAINST_HELP = "with --suite: results of an earlier version (a file of --json); the check also fails if a figure got worse"
NO_LAWS_HELP = "with --suite: check the claims about figures only, in about a third of the time"
IMAGES_HELP = "with --suite: render all scenarios, for a SLAM that does not accept features"
EXIT_HELP = "with --suite: stop after the first scenario in which a check fails; show only the checks failed by then"
JSON_HELP = "with --suite: write the verdicts and all results to a file, which lexis-sim compare reads"
LIMIT_HELP = (
    "with --suite: replace the limit for a figure, such as labels.accuracy=0.9; if a part makes several claims about it, "
    "only the claim that has to hold in the most scenarios is checked; may be repeated"
)
PICTURE_HELP = "with --suite: an SVG of room quality against openness, beside the plain SLAMs that are shipped"
BUDGET_HELP = (
    "with --suite: wall time after which no further scenario is begun, such as 12m (default: no limit); one of the last "
    "lines says how many checks could not fail with so few scenarios"
)
EXPECT_FAILURE_HELP = (
    'with --suite: a check that is known to fail, as the output names it, or a pattern such as "revisits: trajectory.*"; it '
    "does not count as failed, but has to fail; may be repeated"
)
KNOWN_FAILURES_HELP = (
    "with --suite: a file of --json; the checks that fail there are known to fail, as if each were given to --expect-failure"
)
REFERENCE_HELP = (
    "with --suite and --out: a SLAM without the failures, such as sim.harness.adapters:Lexis; where it passes, a smaller "
    "scenario counts only if it passes there, too"
)
WORKERS_HELP = "with --suite: number of processes (default: one for each core that this process may use)"
_OPTIONS = (
    *("reference", "images", "no_laws", "exitfirst", "json", "against", "limit", "expect_failure", "known_failures"),
    *("picture", "budget", "workers"),
)
_EXPECTED = "as --expect-failure says"
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
    parser.add_argument("--expect-failure", action="append", metavar="CHECK", help=EXPECT_FAILURE_HELP)
    parser.add_argument("--known-failures", type=Path, metavar="FILE", help=KNOWN_FAILURES_HELP)
    parser.add_argument("--picture", type=Path, metavar="FILE", help=PICTURE_HELP)
    parser.add_argument("--budget", type=duration_s, metavar="TIME", help=BUDGET_HELP)
    parser.add_argument("--reference", metavar="MODULE:CLASS", help=REFERENCE_HELP)
    parser.add_argument("--workers", type=whole_number(1, _MOST_WORKERS), metavar="N", help=WORKERS_HELP)


def refuse_suite_options(arguments: argparse.Namespace) -> None:
    """Raise SimError if an option for suites is given without a suite."""
    for option in _OPTIONS:
        if getattr(arguments, option) is not None:
            raise SimError(f"--{option.replace('_', '-')} is for suites; valid: with --suite")


def run_suite(arguments: argparse.Namespace) -> int:
    """Check the chosen SLAM by the chosen suite, and print the verdicts.

    Return 1 if a check fails unexpectedly, if a check that is expected to fail does not, if a figure got worse, or if no
    scenario was completed both in this run and in the earlier run of `--against`; otherwise 0. Raises `SimError` before the
    run for options that cannot be used. Once the results so far are written and printed, raises `KeyboardInterrupt` after
    Ctrl-C, and the error that has ended the suite, if there is one.
    """
    from sim.suites.report import check_slam, runnable

    _refuse_scenario_options(arguments)
    _refuse_to_replace_what_is_read(arguments)
    new_slam, workers = _new_slam(arguments), arguments.workers or usable_cores()
    suite, reference = _suite(arguments), _reference(arguments)
    expected = _expected_failures(arguments)
    _check_output_files(arguments)
    before = None if arguments.against is None else EarlierResults.read(arguments.against)
    if before is not None:
        before.refuse_other_scenarios(runnable(suite, new_slam), arguments.seed)
    with progress_bar("checking by the suite") as progress:
        budget_s = math.inf if arguments.budget is None else arguments.budget
        stop = bool(arguments.exitfirst)
        report = check_slam(new_slam, suite, arguments.seed, workers, stop, progress, budget_s, expected)
    comparison = None if before is None else before.compared_with(report)
    worse = () if comparison is None else comparison.worse
    if arguments.json is not None:  # before anything is printed, because the reader of a pipe may close it
        _write_results(report, worse, arguments.json)
    for line in suite_lines(report, failed_alone=bool(arguments.exitfirst)):
        print(line)
    for failure in (*report.failed, *report.failed_means, *report.unmet_expectations):
        print(f"failed: {failure}", file=sys.stderr)
    if comparison is not None:
        print(comparison)
    elif before is not None:
        print(f"not compared with {arguments.against}: no scenario was completed in both runs", file=sys.stderr)
    if worse:
        print(f"failed: {', '.join(worse)} worse than in {arguments.against}", file=sys.stderr)
    if report.interrupted:
        raise KeyboardInterrupt("the results are those of the scenarios before Ctrl-C")
    if report.error is not None:
        report.error.add_note("the results are those of the scenarios before this error")
        raise report.error
    if arguments.picture is not None:
        _draw(report, workers, arguments.picture)
    _search_smallest(report, new_slam, reference, arguments)
    return 0 if report.ok and not worse and (before is None or comparison is not None) else 1


def _expected_failures(arguments: argparse.Namespace) -> dict[str, str]:
    """Return the reason for each check that is known to fail."""
    from sim.suites.expected_failures import known_failures

    given = dict.fromkeys(arguments.expect_failure or (), _EXPECTED)
    if arguments.known_failures is None:
        return given
    return known_failures(arguments.known_failures, arguments.suite, arguments.seed) | given


def _refuse_to_replace_what_is_read(arguments: argparse.Namespace) -> None:
    written = {path.resolve() for path in (arguments.json, arguments.picture) if path is not None}
    for option, read in (("--against", arguments.against), ("--known-failures", arguments.known_failures)):
        if read is not None and read.resolve() in written:
            raise SimError(f"{option} {read}: would be replaced by the new results; valid: another file for these")


def _check_output_files(arguments: argparse.Namespace) -> None:
    """Raise SimError unless the results, the picture and the smallest scenarios can be written where the options say."""
    paths = [path for path in (arguments.json, arguments.picture) if path is not None]
    for path in paths:
        check_output_file(path)
    if len({path.resolve() for path in paths}) < len(paths):
        raise SimError(f"--json and --picture are both {arguments.json}; valid: two files")
    if arguments.picture is not None:
        check_ending(arguments.picture, [".svg"])
    if arguments.out is not None:
        make_output_folder(arguments.out)


def _suite(arguments: argparse.Namespace) -> "Suite":
    """Return the chosen suite, changed as the options say."""
    from sim.suites.catalogue import suite_named

    suite = suite_named(arguments.suite).with_limits(dict(arguments.limit or ()))
    suite = suite.without_laws() if arguments.no_laws else suite
    return suite.with_images() if arguments.images else suite


def _write_results(report: "SuiteReport", worse: Sequence[str], path: Path) -> None:
    """Write the results of all scenarios, the verdicts, and the names of the figures that got worse."""
    from sim.verdicts.stored_results import results_data

    data = results_data(report.results) | report.data() | {"worse": list(worse)}
    with replaced_file(path) as beside:
        beside.write_text(json.dumps(data, indent=1) + "\n", encoding="utf-8")


def _draw(report: "SuiteReport", workers: int, path: Path) -> None:
    """Draw room quality against openness. The baselines in the picture are run first, without images."""
    from sim.suites.openness_chart import openness_chart

    with replaced_file(path) as beside:
        beside.write_text(openness_chart(report, workers), encoding="utf-8")


def _reference(arguments: argparse.Namespace) -> "Runner | None":
    """Return a function that runs the SLAM of `--reference`; None without the option."""
    if arguments.reference is None:
        return None
    if arguments.out is None:
        raise SimError("--reference is for the search of smallest scenarios; valid: with --out")
    return runner_of_class(arguments.reference, "--reference")


def _search_smallest(
    report: "SuiteReport", new_slam: "NewSlam", reference: "Runner | None", arguments: argparse.Namespace
) -> None:
    """Write the smallest scenario of each failed check into the folder that `--out` names, and print what was found.

    With `-x`, only the first failed check is searched, because each search takes up to three minutes.
    """
    from sim.suites.smallest import SlamUnderSearch, write_smallest

    if report.failed and arguments.out is None:
        print("--out DIR writes the smallest scenario in which each failed check still fails", file=sys.stderr)
    if not report.failed or arguments.out is None:
        return
    slam = SlamUnderSearch(new_slam, runner_of(arguments), replay_of(arguments), is_lexis(arguments), reference)
    for verdict, others in _by_cause(report.failed)[: 1 if arguments.exitfirst else None]:
        found, interrupted = write_smallest(verdict, slam, arguments.out)
        print(found)
        for other in others:
            print(f"{other.name}: not searched, because it is about the same figure or law")
        if interrupted:
            print("interrupted: the other failed checks were not searched")
            return


def _by_cause(failed: "Sequence[CheckVerdict]") -> "list[tuple[CheckVerdict, list[CheckVerdict]]]":
    """Return the failed checks for which the smallest scenario is searched, each with the others of the same cause.

    Claims of one part about one figure mostly fail for the same reason, and so does a law in several parts. The first of
    them stands for all. Crashes in different parts may have different causes.
    """
    from sim.suites.checks import ClaimCheck

    groups: dict[tuple[str, str], list[CheckVerdict]] = {}
    for verdict in failed:
        check = verdict.checked
        where = verdict.part.name if check is None or isinstance(check, ClaimCheck) else ""
        what = check.claim.figure if isinstance(check, ClaimCheck) else verdict.check
        groups.setdefault((where, what), []).append(verdict)
    return [(first, others) for first, *others in groups.values()]


def _new_slam(arguments: argparse.Namespace) -> "NewSlam":
    from sim.harness import Lexis

    if arguments.program is not None:
        return program_of(arguments)
    refuse_program_options(arguments)
    return Lexis if arguments.slam is None else slam_factory(arguments.slam)


def _refuse_scenario_options(arguments: argparse.Namespace) -> None:
    """Raise SimError for an option that describes a single run, except the seed."""
    given = [name for name in given_options_of_a_run(arguments) if name != "seed"]
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
