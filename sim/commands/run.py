"""`lexis-sim demo` and `lexis-sim run`: one run of LEXIS, the printed table of its figures, and its folder."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from lexis.command_line import Commands, add_command, warn_of_replacement
from sim.commands.arguments import CONFIG_HELP, DEMO_SEED, add_run_seed, add_scenario, folder, scenario_of_arguments
from sim.commands.console import standard_output
from sim.commands.progress import progress_bar

if TYPE_CHECKING:
    from sim.harness import Run, RunResult, Scenario
    from sim.harness.slam_under_test import SlamUnderTest

_WIDE = 110
"""Least width of the terminal, in columns, at which the printed table also explains every figure."""


def add_to(commands: Commands) -> None:
    """Add the commands `demo` and `run`."""
    demo = add_command(
        commands, "demo", _demo, "a house, a walk, LEXIS, a report", f"lexis-sim demo --seed {DEMO_SEED} --out lexis-demo"
    )
    add_run_seed(demo)
    _add_out(demo, Path("lexis-demo"))
    run = add_command(
        commands, "run", _run, "one run with a choice of everything", "lexis-sim run --preset ori --seed 3 --no-loops"
    )
    add_scenario(run)
    _add_out(run, Path("lexis-run"))
    run.add_argument("--config", type=Path, metavar="FILE", help=CONFIG_HELP)
    run.add_argument("--no-loops", action="store_true", help="close no loops")
    run.add_argument("--no-refine", action="store_true", help="keep the labels that single images give")


def _add_out(parser: argparse.ArgumentParser, out: Path) -> None:
    parser.add_argument(
        "-o", "--out", type=folder, default=out, metavar="DIR", help="folder for the result (default: %(default)s)"
    )


def _demo(arguments: argparse.Namespace) -> int:
    from sim.harness import Scenario

    return _run_and_report(Scenario(seed=arguments.seed), None, arguments.out)


def _run(arguments: argparse.Namespace) -> int:
    from lexis.config import read_config
    from sim.harness.adapters import Lexis

    scenario = scenario_of_arguments(arguments)
    config = read_config(arguments.config) if arguments.config else None
    slam = Lexis(scenario.encoder, config, loops=not arguments.no_loops, refine=not arguments.no_refine)
    return _run_and_report(scenario, slam, arguments.out)


def _run_and_report(scenario: "Scenario", slam: "SlamUnderTest | None", out: Path) -> int:
    from sim.harness import evaluate, run, try_plans, write_run
    from sim.harness.outputs import MARKERS, REPORT

    warn_of_replacement(out, *MARKERS)
    with progress_bar("walking and mapping") as progress:
        finished = run(scenario, slam, progress)
    trials = try_plans(finished)
    result = evaluate(finished, trials)
    write_run(finished, result, trials, out)
    print_result(finished, result)
    print_gaps(finished, result)
    if result.planning.success not in (None, 1.0):
        print("Not every plan reached its room: the report lists and draws those that failed.")
    print(f"report: {out / REPORT}")
    return 0


def print_gaps(finished: "Run", result: "RunResult") -> None:
    """Print what the figures do not show: gaps in the map, faults without effect, and conventions that were mistaken."""
    from sim.harness.diagnosis.usual_mistakes import usual_mistakes
    from sim.report.findings import coverage_gap, idle_faults

    gaps = coverage_gap(result.data(), finished.unseen_rooms), idle_faults(result.data())
    for text in (*gaps, *usual_mistakes(finished)):
        if text is not None:
            print(f"warning: {text}")


def print_result(finished: "Run", result: "RunResult", nulls: bool = True, keys: bool = False) -> None:
    """Print the table of figures; on a wide terminal, the table also explains each figure.

    Without `nulls`, figures that are None are left out. With `keys`, the table has the names of the figures in result.json.
    """
    from sim.report import result_table, result_title

    console, figures = standard_output(), result.data()
    print(result_title(figures, finished.house.spec.name))
    console.print(result_table(figures, meanings=console.width >= _WIDE, nulls=nulls, keys=keys))
