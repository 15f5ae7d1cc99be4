"""`lexis-sim demo` and `run`: one run, its table and its folder."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from rich.console import Console
from rich.progress import Progress

from lexis.command_line import Commands, add_command, warn_of_replacement
from sim.commands.arguments import (
    DEMO_SEED,
    ENCODER_HELP,
    FEATURE_MODEL_HELP,
    FIDELITY_HELP,
    ORACLE_HELP,
    add_run_seed,
    add_walk,
    folder,
    walk_options,
)
from sim.fidelity import FIDELITIES

if TYPE_CHECKING:
    from sim.harness import Scenario
    from sim.harness.slam_under_test import SlamUnderTest

RIG_HELP = (
    "wide, stereo, front-rear, four or fisheye; LEXIS sees the first pinhole: the front, left or front left one "
    "(default: %(default)s)"
)
_WIDE = 110
"""Least width of the terminal, in columns, at which the printed table also explains every figure."""


def add_to(commands: Commands) -> None:
    """Add the commands."""
    demo = add_command(
        commands, "demo", _demo, "a house, a walk, LEXIS, a report", f"lexis-sim demo --seed {DEMO_SEED} --out lexis-demo"
    )
    add_run_seed(demo)
    _add_out(demo, Path("lexis-demo"))
    run = add_command(
        commands, "run", _run, "one run with a choice of everything", "lexis-sim run --preset ori --seed 3 --no-loops"
    )
    add_walk(run)
    _add_out(run, Path("lexis-run"))
    run.add_argument("--encoder", default="mini", help=f"{ENCODER_HELP}; {ORACLE_HELP}")
    run.add_argument("--fidelity", choices=FIDELITIES, default="render", help=FIDELITY_HELP)
    run.add_argument("--feature-model", type=Path, metavar="FILE", help=FEATURE_MODEL_HELP)
    run.add_argument("--rig", default="wide", metavar="NAME", help=RIG_HELP)
    run.add_argument(
        "--config", type=Path, metavar="FILE", help="settings of LEXIS as JSON; 'lexis config' prints the defaults"
    )
    run.add_argument("--no-loops", action="store_true", help="close no loops")
    run.add_argument("--no-refine", action="store_true", help="keep the labels that single images give")


def _add_out(parser: argparse.ArgumentParser, out: Path) -> None:
    parser.add_argument(
        "--out", type=folder, default=out, metavar="DIR", help="folder for the result (default: %(default)s)"
    )


def _demo(arguments: argparse.Namespace) -> int:
    from sim.harness import Scenario

    return _run_and_report(Scenario(seed=arguments.seed), None, arguments.out)


def _run(arguments: argparse.Namespace) -> int:
    from lexis.config import read_config
    from sim.harness import Scenario
    from sim.harness.adapters import Lexis
    from sim.render.rig import RigConfig

    scenario = Scenario(
        encoder=arguments.encoder,
        fidelity=arguments.fidelity,
        feature_model=arguments.feature_model,
        rig=RigConfig(arguments.rig),
        **walk_options(arguments),
    )
    config = read_config(arguments.config) if arguments.config else None
    slam = Lexis(scenario.encoder, config, loops=not arguments.no_loops, refine=not arguments.no_refine)
    return _run_and_report(scenario, slam, arguments.out)


def _run_and_report(scenario: "Scenario", slam: "SlamUnderTest | None", out: Path) -> int:
    from sim.harness import evaluate, run, try_plans, write_run
    from sim.harness.outputs import MARKER
    from sim.report import result_table, result_title
    from sim.report.findings import coverage_gap

    warn_of_replacement(out, MARKER)
    console = Console()
    with Progress(console=console, transient=True, disable=not console.is_terminal) as bar:
        task = bar.add_task("walking and mapping", total=1.0)
        finished = run(scenario, slam, progress=lambda share: bar.update(task, completed=share))
    trials = try_plans(finished)
    result = evaluate(finished, trials)
    write_run(finished, result, trials, out)
    figures = result.data()
    print(result_title(figures, finished.house.spec.name))
    console.print(result_table(figures, meanings=console.width >= _WIDE))
    if text := coverage_gap(figures, finished.unseen_rooms):
        print(f"warning: {text}")
    if result.planning.success not in (None, 1.0):
        print("Not every plan reached its room: the report lists and draws those that failed.")
    print(f"report: {out / 'report.html'}")
    return 0
