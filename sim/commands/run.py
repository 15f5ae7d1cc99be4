"""`lexis-sim demo` and `run`: one run, its table and its folder."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from rich.console import Console
from rich.progress import Progress

from lexis.command_line import Commands, add_command, seed
from sim.commands.arguments import ENCODER_HELP, PRESET_HELP, folder
from sim.faults.catalogue import parse_fault, usage
from sim.odometry_config import PRESETS as ODOMETRY_PRESETS
from worlds.spec import HouseSpec

if TYPE_CHECKING:
    from sim.harness import RunConfig

DEMO_SEED = 7
_WIDE = 110
"""Columns from which there is room for the meaning of every figure."""


def add_to(commands: Commands) -> None:
    """Add the commands."""
    demo = add_command(
        commands, "demo", _demo, "a house, a walk, LEXIS, a report", "lexis-sim demo --seed 7 --out lexis-demo"
    )
    _add_seed_and_out(demo, Path("lexis-demo"))
    run = add_command(
        commands, "run", _run, "one run with a choice of everything", "lexis-sim run --preset ori --seed 3 --no-loops"
    )
    house = run.add_mutually_exclusive_group()
    house.add_argument("--preset", default="home", help=PRESET_HELP)
    house.add_argument("--house", type=Path, metavar="FILE.json", help="a house of your own")
    _add_seed_and_out(run, Path("lexis-run"))
    run.add_argument("--odometry", default="multicam", help=f"{', '.join(ODOMETRY_PRESETS)} (default: %(default)s)")
    run.add_argument(
        "--overconfidence",
        type=float,
        default=1.0,
        metavar="FACTOR",
        help="how much too small the odometry's covariances are (default: 1, honest)",
    )
    run.add_argument("--encoder", default="mini", help=ENCODER_HELP)
    run.add_argument("--fidelity", choices=["render"], default="render")
    run.add_argument(
        "--fault", action="append", default=[], metavar="NAME[:VALUE,FIELD=VALUE...]", help="what breaks; may be repeated"
    )
    run.epilog = f"{run.epilog}\n\nfaults, with their fields and defaults:\n{usage()}"
    run.add_argument("--no-loops", action="store_true", help="close no loops")
    run.add_argument("--no-refine", action="store_true", help="keep the labels that single images give")


def _add_seed_and_out(parser: argparse.ArgumentParser, out: Path) -> None:
    parser.add_argument("--seed", type=seed, default=DEMO_SEED, help="of house, tour and odometry (default: %(default)s)")
    parser.add_argument(
        "--out", type=folder, default=out, metavar="DIR", help="folder for the result (default: %(default)s)"
    )


def _demo(arguments: argparse.Namespace) -> int:
    from sim.harness import RunConfig

    return _run_and_report(RunConfig(seed=arguments.seed), arguments.out)


def _run(arguments: argparse.Namespace) -> int:
    from sim.harness import RunConfig

    config = RunConfig(
        preset=arguments.preset,
        seed=arguments.seed,
        house=HouseSpec.load(arguments.house) if arguments.house else None,
        odometry=arguments.odometry,
        overconfidence=arguments.overconfidence,
        encoder=arguments.encoder,
        loops=not arguments.no_loops,
        refine=not arguments.no_refine,
        faults=tuple(map(parse_fault, arguments.fault)),
    )
    return _run_and_report(config, arguments.out)


def _run_and_report(config: "RunConfig", out: Path) -> int:
    from sim.harness import evaluate, run, try_plans, write_run
    from sim.harness.outputs import check_writable
    from sim.report import result_table

    check_writable(out)
    console = Console()
    with Progress(console=console, transient=True, disable=not console.is_terminal) as bar:
        task = bar.add_task("walking and mapping", total=1.0)
        finished = run(config, progress=lambda share: bar.update(task, completed=share))
    trials = try_plans(finished)
    result = evaluate(finished, trials)
    write_run(finished, result, trials, out)
    console.print(result_table(result, finished.house.spec.name, meanings=console.width >= _WIDE))
    print(f"report: {out / 'report.html'}")
    return 0
