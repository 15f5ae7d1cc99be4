"""Benchmarks of the harness itself: the bugs that a suite finds, and the reducer."""

import argparse
import time
from concurrent.futures import Future, ThreadPoolExecutor, as_completed
from contextlib import closing
from dataclasses import astuple
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from rich.table import Table

from lexis.command_line import positive
from sim.commands.action import Action
from sim.commands.arguments import SEED, argument, folder
from sim.commands.benchmarks.bench_options import console
from sim.commands.earlier_results import EarlierResults
from sim.commands.progress import tracked
from sim.durations import duration_s
from sim.errors import SimError
from sim.output_files import check_output_file
from sim.processes import usable_cores

if TYPE_CHECKING:
    from collections.abc import Callable, Generator, Sequence

    from sim.bench.mutation.grading import Grade
    from sim.bench.mutation.planting import Mutant

_OWN_PYTESTS = 10
"""Approximate number of reduced scenarios whose replay tests pytest also runs in a process of its own."""


def _mutation(arguments: argparse.Namespace) -> int:
    """Print a line for each mutant as soon as it is graded, and a table; return 1 if unchanged LEXIS fails a check."""
    from sim.bench.mutation import MUTANTS, grade
    from sim.bench.mutation.grading import counts, markdown_table, read_grades, usable_grades, write_grade
    from sim.suites.catalogue import suite_named

    laws, before, chosen = not arguments.no_laws, arguments.against, suite_named(arguments.suite)
    wanted = {each.name: each for each in MUTANTS if arguments.only in each.name}
    if not wanted:
        raise SimError(f"--only {arguments.only!r:.60}: no mutant has this text in its name; valid: part of a name")
    if arguments.out is not None:
        check_output_file(arguments.out)
    if before is not None:
        EarlierResults.read(before).refuse_other_scenarios(chosen, arguments.seed)
    graded = partial(grade, suite=arguments.suite, workers=1, laws=laws, smallest=arguments.smallest, before=before)
    suite = arguments.suite if laws else f"{arguments.suite} without laws"
    kept = [] if arguments.out is None else read_grades(arguments.out)
    usable = usable_grades(kept, wanted.values(), suite, arguments.seed, arguments.smallest, before)
    alarms = _false_alarms(graded, arguments)  # first, because they show a wrong set-up
    grades = list(usable.values())
    mutants = [mutant for name, mutant in wanted.items() if name not in usable]
    with closing(_graded(graded, mutants, arguments.seed, arguments.processes)) as found:
        for each in found:
            grades.append(each)
            _print_grade(each, each.mutant, f"caught by {each.caught_by}" if each.is_caught else "not caught")
            if arguments.out is not None:
                write_grade(each, arguments.out)
    print(markdown_table(grades))
    print(f"{counts(grades)}; {alarms} false alarms")
    return int(alarms > 0)


def _false_alarms(graded: "Callable[..., Grade]", arguments: argparse.Namespace) -> int:
    """Check unchanged LEXIS with several seeds, and print what is found; return with how many seeds a check fails."""
    alarms = 0
    for seed in range(arguments.seed, arguments.seed + arguments.unchanged):
        found = graded(None, seed, workers=arguments.processes, before=arguments.against if seed == arguments.seed else None)
        verdict = f"FALSE ALARM by {found.caught_by}: {found.measured}" if found.is_caught else "passes"
        _print_grade(found, f"unchanged LEXIS, seed {seed}", verdict)
        alarms += found.is_caught
    return alarms


def _graded(
    graded: "Callable[..., Grade]", mutants: "Sequence[Mutant]", seed: int, processes: int
) -> "Generator[Grade, None, None]":
    """Grade mutants, as many at once as there are `processes`; yield the grades in the order in which they are found.

    After an error, after Ctrl-C, and if the generator is closed, the suites that are running are ended.
    """
    from sim.bench.mutation.grading import end_suites

    threads = ThreadPoolExecutor(processes)  # the work is done in a process of each mutant
    futures: list[Future[Grade]] = []
    try:  # Ctrl-C may come as soon as the first suite has begun
        for mutant in mutants:
            futures.append(threads.submit(graded, mutant, seed))
        for future in as_completed(futures):
            yield future.result()
    finally:
        threads.shutdown(wait=False, cancel_futures=True)
        while not all(future.done() for future in futures):
            end_suites()  # the suites do not get Ctrl-C themselves, because they are in process groups of their own
            time.sleep(0.1)


def _print_grade(found: "Grade", of: str, verdict: str) -> None:
    print(f"{found.scenarios:4} scenarios {found.seconds:6.0f} s  {of}: {verdict}", flush=True)


def _shrinking(arguments: argparse.Namespace) -> int:
    """Print a line for each broken law and a table of the families of bugs; return 1 if a law is broken, else 0."""
    from sim.bench.shrinking import ProofPlan, folder_of, prove, summaries

    one_in = arguments.scenarios // _OWN_PYTESTS
    plan = ProofPlan(arguments.seed, arguments.deadline, arguments.rooms, arguments.out, one_in)
    proofs = []
    for proof in tracked(prove(plan, arguments.scenarios, arguments.processes), arguments.scenarios, "scenarios"):
        proofs.append(proof)
        for law in proof.broken:
            print(f"{folder_of(proof.number, plan)}.json: {law}")
    headers = ("family", "scenarios", "in time", "broken", "needs", "rooms before", "rooms", "walk before, m", "walk, m")
    title = "reductions: median, 90 % and worst after it; before it, and what the bug needs at least"
    table = Table(*headers, "candidates", "seconds", title=title, title_justify="left")
    for row in summaries(proofs):
        table.add_row(*map(_spread, astuple(row)))
    console().print(table)
    return int(any(proof.broken for proof in proofs))


def _spread(value: object) -> str:
    """Return a figure as text, with at most one decimal.

    The figures of a tuple are joined by slashes; None gives "" (empty).
    """
    if isinstance(value, tuple):
        return " / ".join(map(_spread, value))
    if value is None:
        return ""
    return f"{value:.1f}".removesuffix(".0") if isinstance(value, float) else str(value)


_PROCESSES = argument(
    "--processes", type=positive, default=usable_cores(), help="number of processes (default: one for each usable core)"
)
BENCHMARKS = (
    Action(
        "mutation",
        _mutation,
        "planted bugs of LEXIS that a suite finds; exit status 1 if unchanged LEXIS fails a check",
        "lexis-sim bench mutation --only loop",
        (
            argument("--only", default="", metavar="TEXT", help="mutants whose name contains this text (default: all)"),
            argument("--suite", default="pr", metavar="NAME", help="the suite (default: %(default)s)"),
            argument("--no-laws", action="store_true", help="let the suite check claims only, without laws"),
            argument("--against", type=Path, metavar="FILE", help="results of unchanged LEXIS, to compare with"),
            argument("--smallest", action="store_true", help="also look for the smallest scenario that shows each mutant"),
            argument("--unchanged", type=positive, default=1, metavar="N", help="seeds for unchanged LEXIS (default: 1)"),
            argument(
                "-o",
                "--out",
                type=Path,
                metavar="FILE",
                help="file for the grades; mutants in it are not graded again unless they or LEXIS have changed",
            ),
            _PROCESSES,
            SEED,
        ),
    ),
    Action(
        "shrinking",
        _shrinking,
        "reductions of scenarios in which planted bugs show; exit status 1 if one of them breaks a law",
        "lexis-sim bench shrinking --scenarios 200",
        (
            argument("--scenarios", type=positive, default=32, help="number of scenarios (default: %(default)s)"),
            argument("--deadline", type=duration_s, default=60.0, metavar="TIME", help="for each reduction (default: 60s)"),
            argument(
                "--rooms", type=positive, default=10, help="greatest number of rooms in a house (default: %(default)s)"
            ),
            _PROCESSES,
            argument(
                "--out",
                type=folder,
                default=Path("broken-reductions"),
                metavar="DIR",
                help="scenarios whose reductions break a law are kept here (default: %(default)s)",
            ),
            SEED,
        ),
    ),
)
