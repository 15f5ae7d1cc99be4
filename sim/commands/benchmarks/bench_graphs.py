"""Benchmarks of pose graphs, odometry, long walks, several sessions and rigs of several cameras."""

import argparse
import sys
from collections.abc import Iterator
from dataclasses import astuple, fields, replace
from pathlib import Path

from rich.markup import escape
from rich.table import Table

from lexis.command_line import positive
from sim.commands.action import Action
from sim.commands.arguments import PINHOLE_RIGS, SEED, TOUR_HELP, TOURS, EachOnce, argument, number
from sim.commands.benchmarks.bench_options import (
    CONFIG,
    CSV,
    FIDELITY,
    HOUSES,
    PLOT,
    PRESET,
    known,
    mean_std_text,
    printing,
    seeds_of,
)
from sim.commands.progress import tracked
from sim.wording import counted, seeds_text

RIG_HELP = f"cameras of each run, of {', '.join(PINHOLE_RIGS)} (default: wide front-rear)"


def _pose_graph(arguments: argparse.Namespace) -> Iterator[Table]:
    from sim.bench.pose_graphs.g2o_files import PoseGraphRow, optimise_files
    from sim.report.figures import shown

    title = "cost: half of the sum of squared residuals; excess: share above the least known cost"
    table = Table(*(field.name.replace("_", " ") for field in fields(PoseGraphRow)), title=title)
    for row in optimise_files(arguments.files):
        table.add_row(
            *(row.file, str(row.poses), str(row.edges), row.start, f"{row.start_cost:,.4g}", f"{row.cost:.6g}"),
            *(shown(row.excess, "{:.4%}"), shown(row.iterations, "{}"), f"{row.seconds:.2f}"),
        )
    yield table


def _kernels(arguments: argparse.Namespace) -> Iterator[Table]:
    from lexis.config import Config, read_config
    from sim.bench.pose_graphs.kernels import draw_kernels, kernel_runs, mapped_houses, summarised
    from sim.bench.row_files import PICTURES, check_files, write_rows
    from sim.report.figures import shown

    check_files(arguments.csv, valid=(".csv",))
    check_files(arguments.plot, valid=PICTURES)
    seeds = seeds_of(arguments)
    settings = read_config(arguments.config) if arguments.config else Config()
    graph = settings.pose_graph
    if arguments.threshold is not None:
        graph = replace(graph, outlier_threshold=arguments.threshold)
    houses = mapped_houses(arguments.preset, seeds, settings)
    rows = list(summarised([each for house in houses for each in kernel_runs(house, graph)]))
    title = f"{arguments.preset}, {seeds_text(seeds)}, features: mean ± std over houses"
    headers = ("houses", "ATE, m", "growth of the ATE", "true loops rejected", "houses without rejected true loops")
    table = Table("false loops", "share", "kernel", *headers, "false loops trusted", title=title)
    for row in rows:
        table.add_row(
            *(row.kind, f"{row.share:.0%}", row.kernel, str(row.houses), mean_std_text(row.ate_m, row.ate_std_m, "{:.3f}")),
            *(shown(row.growth, "{:.1%}"), mean_std_text(row.true_rejected, row.true_rejected_std, "{:.1%}")),
            *(shown(row.houses_without_rejected_true_loops, "{:.0%}"), shown(row.false_trusted, "{:.1%}")),
            end_section=row.kernel == rows[-1].kernel,
        )
    if arguments.csv:
        write_rows(rows, arguments.csv)
    if arguments.plot:
        draw_kernels(rows, arguments.plot)
    yield table


def _odometry(arguments: argparse.Namespace) -> Iterator[Table]:
    from sim.bench.odometry import CASES, USUAL, measure_odometry, summary
    from sim.bench.row_files import check_files, write_rows
    from sim.report.figures import shown

    check_files(arguments.csv, valid=(".csv",))
    seeds, cases = seeds_of(arguments), arguments.cases or list(CASES)
    measured = measure_odometry(cases, arguments.preset, seeds, arguments.fidelity, TOURS[arguments.tour])
    rows = list(tracked(measured, len(cases) * arguments.houses, "runs"))
    if left_out := len(cases) * arguments.houses - len(rows):
        left = counted(left_out, "walk")
        print(f"lexis-sim: note: left out {left} that ended before the fault began", file=sys.stderr)
    title = f"{arguments.preset}, {seeds_text(seeds)}, {arguments.fidelity}, tour {arguments.tour}: means over houses"
    errors = ("ATE of odometry, m", "ATE, m", "ATE / odometry's", "largest ATE - odometry's, m")
    maps = (
        "labels",
        f"labels - {USUAL}'s",
        "room PQ",
        "far loops refused",
        "all trusted false loops",
        "all corrected maps",
    )
    table = Table("case", "houses", *errors, *maps, title=title)
    for case, found in summary(rows).items():
        table.add_row(
            *(case, str(found.houses), shown(found.odometry_m, "{:.3f}"), shown(found.ate_m, "{:.3f}")),
            *(shown(found.share_of_odometry, "{:.2f}"), shown(found.largest_excess_m, "{:+.3f}")),
            *(shown(found.labels, "{:.3f}"), shown(found.labels_gained, "{:+.3f}"), shown(found.rooms, "{:.3f}")),
            *(shown(found.refused, "{:.1f}"), str(found.false), str(found.corrected)),
        )
    if arguments.csv:
        write_rows(rows, arguments.csv)
    yield table


def _scale(arguments: argparse.Namespace) -> Iterator[Table]:
    from sim.bench.scale import LAP_M, map_bytes, measure_scale

    walk = arguments.rooms, arguments.length, arguments.seed, arguments.laps
    portions, finished = measure_scale(*walk, arguments.portions)
    way = f"{arguments.laps} laps of {LAP_M:g} m" if arguments.laps else f"{arguments.length:g} m"
    kilobytes = map_bytes(finished) / len(finished.keyframes) / 1e3
    title = f"{way} through {arguments.rooms} rooms: {len(finished.loops)} loops, {kilobytes:.1f} kB a keyframe"
    table = Table("keyframes", "ms per keyframe", "not retired", "map [MB]", title=title)
    for portion in portions:
        sizes = f"{portion.active}", f"{portion.map_bytes / 1e6:.2f}"
        table.add_row(f"{portion.first} to {portion.last}", f"{portion.keyframe_ms:.2f}", *sizes)
    yield table


def _sessions(arguments: argparse.Namespace) -> Iterator[Table]:
    from sim.bench.sessions import NEAR_M, measure_sessions, summary
    from sim.report.figures import shown

    title = f"{arguments.preset}, features: a session that starts somewhere on another day, {arguments.length:g} m of walk"
    headers = ("starts", "joined", f"joined within {NEAR_M:g} m", "at a wrong place", "median walk [m]", "largest error [m]")
    table = Table("house", *map(escape, headers), title=title)
    seeds = seeds_of(arguments)
    for name, row in summary(measure_sessions(arguments.preset, seeds, arguments.every, arguments.length)).items():
        table.add_row(name, *(shown(value, "{:.3g}") for value in astuple(row)))
    yield table


def _rigs(arguments: argparse.Namespace) -> Iterator[Table]:
    from lexis.config import read_config
    from sim.bench.rigs import measure_rigs, summary
    from sim.bench.row_files import check_files, write_rows
    from sim.report.figures import shown

    check_files(arguments.csv, valid=(".csv",))
    seeds, count = seeds_of(arguments), len(arguments.rigs) * arguments.houses
    settings = read_config(arguments.config) if arguments.config else None
    measured = measure_rigs(arguments.rigs, arguments.preset, seeds, arguments.fidelity, settings)
    rows = list(tracked(measured, count, "runs"))
    title = f"{arguments.preset}, {seeds_text(seeds)}, {arguments.fidelity}: all rooms and back along the same path"
    headers = ("opposite revisits", "found", "trusted loops", "false", "labels", "room PQ", "ATE, m", "ms per keyframe")
    table = Table("rig", "seed", *headers, title=title)
    for row in (*rows, *summary(rows)):
        table.add_row(
            *(row.rig, "all" if row.seed < 0 else str(row.seed), str(row.revisits)),
            *(shown(known(row.recall), "{:.2f}"), str(row.trusted)),
            *(str(row.false), *(shown(figure, "{:.3f}") for figure in (row.labels, row.rooms, row.ate_m))),
            f"{row.keyframe_ms:.1f}",
        )
    if arguments.csv:
        write_rows(rows, arguments.csv)
    yield table


BENCHMARKS = (
    Action(
        "pose-graph",
        printing(_pose_graph),
        "LEXIS's optimiser on pose graphs in g2o files: cost, iterations and time",
        "lexis-sim bench pose-graph sphere2500.g2o parking-garage.g2o",
        (argument("files", type=Path, nargs="+", metavar="FILE", help="pose graphs in three dimensions, as g2o files"),),
    ),
    Action(
        "kernels",
        printing(_kernels),
        "robust kernels against false loops that are added to finished maps",
        "lexis-sim bench kernels --preset home --houses 5 --seed 500",
        (
            PRESET,
            HOUSES,
            argument(
                "--threshold",
                type=number(0.001, 1e6),
                help="squared whitened residual above which a kernel lowers a weight (default: that of LEXIS)",
            ),
            CONFIG,
            CSV,
            PLOT,
            SEED,
        ),
    ),
    Action(
        "scale",
        printing(_scale),
        "time per keyframe and size of the map along one long walk",
        "lexis-sim bench scale --rooms 40 --length 10000",
        (
            argument("--rooms", type=positive, default=10, help="number of rooms of the home (default: %(default)s)"),
            argument("--length", type=number(1.0, 1e6), default=1000.0, help="metres of the walk (default: %(default)s)"),
            argument("--laps", type=positive, help="walk one circuit of 40 m this many times, whatever --length says"),
            argument("--portions", type=positive, default=10, help="largest number of rows (default: %(default)s)"),
            SEED,
        ),
    ),
    Action(
        "sessions",
        printing(_sessions),
        "whether a robot that returns on another day recognises where it is, and never does in a twin house",
        "lexis-sim bench sessions --preset home --houses 5",
        (
            PRESET,
            HOUSES,
            argument("--every", type=number(0.1, 1e5), default=10.0, help="metres between starts (default: %(default)s)"),
            argument(
                "--length",
                type=number(0.1, 1e5),
                default=15.0,
                help="metres of each session (default: %(default)s)",
            ),
            SEED,
        ),
    ),
    Action(
        "odometry",
        printing(_odometry),
        "labels, rooms and trajectories with three presets of odometry, and with odometry that fails",
        "lexis-sim bench odometry --preset home --houses 10 --seed 500 --tour loop",
        (
            argument(
                "--cases",
                nargs="+",
                action=EachOnce,
                metavar="CASE",
                help="only some of multicam, mono, degraded (presets), odometry-jump, odometry-freeze and kidnap, which "
                "begin after 40 s (default: all)",
            ),
            PRESET,
            HOUSES,
            FIDELITY,
            argument("--tour", choices=TOURS, default="rooms", help=f"{TOUR_HELP}; loop: three laps"),
            CSV,
            SEED,
        ),
    ),
    Action(
        "rigs",
        printing(_rigs),
        "whether places are recognised from the opposite direction, and the time per keyframe, with rigs of several cameras",
        "lexis-sim bench rigs --rigs wide front-rear four --houses 5 --seed 500",
        (
            argument(
                "--rigs",
                nargs="+",
                action=EachOnce,
                choices=PINHOLE_RIGS,
                default=["wide", "front-rear"],
                metavar="RIG",
                help=RIG_HELP,
            ),
            PRESET,
            HOUSES,
            FIDELITY,
            CONFIG,
            CSV,
            SEED,
        ),
    ),
)
