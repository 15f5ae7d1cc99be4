"""`lexis-sim bench all`: runs the benchmarks in parallel and keeps their tables, curves and pictures in a folder."""

import argparse
import sys
from pathlib import Path

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

from lexis.command_line import positive
from sim.commands.arguments import argument, folder
from sim.processes import usable_cores

ARGUMENTS = (
    argument("-o", "--out", type=folder, required=True, metavar="DIR", help="folder for the tables, curves and pictures"),
    argument("--quick", action="store_true", help="few houses, and images only where a benchmark needs them"),
    argument("--only", default="", metavar="TEXT", help="benchmarks whose name contains this text (default: all)"),
    argument("--pose-graphs", nargs="+", type=Path, default=[], metavar="FILE", help="g2o files, for pose-graph"),
    argument(
        "--workers", type=positive, default=usable_cores(), metavar="N", help="processes (default: one for each usable core)"
    ),
)


def run_all(arguments: argparse.Namespace) -> int:
    """Print a line for each benchmark as soon as it ends, and return 1 if one of them failed, else 0."""
    from sim.bench.benchmark_list import FULL, POSE_GRAPH, QUICK, benchmarks
    from sim.bench.collection import collect, why_again
    from sim.errors import SimError
    from sim.output_files import make_output_folder

    listed = benchmarks(QUICK if arguments.quick else FULL, arguments.pose_graphs)
    chosen = [each for each in listed if arguments.only in each.name]
    if not chosen and arguments.only in POSE_GRAPH:
        raise SimError(f"--only {arguments.only}: {POSE_GRAPH} needs --pose-graphs FILE...; valid: one g2o file or more")
    if not chosen:
        raise SimError(f"--only {arguments.only}: no benchmark; valid: part of {', '.join(each.name for each in listed)}")
    for file in arguments.pose_graphs:
        if not file.is_file():
            raise SimError(f"--pose-graphs: no file {file}; valid: g2o files")
    make_output_folder(arguments.out)
    for each in chosen:
        if why := why_again(each, arguments.out):
            print(f"{each.name}: run again, because {why}", flush=True)
    failed = 0
    columns = TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn(), TextColumn("left:"), TimeRemainingColumn()
    console = Console(file=sys.stderr)
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as bar:
        task = bar.add_task(f"{len(chosen)} benchmarks", total=sum(each.quick_s for each in chosen))
        for ended in collect(chosen, arguments.out, arguments.workers):
            bar.advance(task, ended.benchmark.quick_s)
            failed += bool(ended.error)
            took = "kept" if ended.seconds is None else f"{ended.seconds:.0f} s, {ended.processor_s:.0f} s of processor time"
            print(f"{ended.benchmark.name}: {'FAILED: ' + ended.error if ended.error else took}", flush=True)
    print(f"{len(chosen) - failed} of {len(chosen)} benchmarks are in {arguments.out}")
    return int(failed > 0)
