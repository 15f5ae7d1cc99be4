"""`lexis-sim bench`: benchmarks that print tables. To add one, write a function and add an entry to `_BENCHMARKS`."""

import argparse
import os
import sys
from collections.abc import Callable, Iterator
from dataclasses import astuple, fields
from functools import partial
from pathlib import Path
from typing import TypeAlias

from rich.console import Console
from rich.markup import escape
from rich.progress import Progress
from rich.table import Table

from lexis.command_line import Command, Commands, positive
from sim.commands import bench_encoders
from sim.commands.action import Action, add_actions
from sim.commands.arguments import (
    CONFIG_HELP,
    ENCODER_HELP,
    FEATURE_MODEL_HELP,
    FIDELITY_HELP,
    PRESET_HELP,
    SEED,
    argument,
    folder,
    number,
    seeing_encoder,
)
from sim.durations import duration_s
from sim.fidelity import FIDELITIES
from worlds.presets import PRESETS

Tables: TypeAlias = Callable[[argparse.Namespace], Iterator[Table]]

_PRESET = argument("--preset", choices=PRESETS, default="home", metavar="NAME", help=PRESET_HELP)
_PRESETS = argument("--presets", nargs="+", choices=PRESETS, default=["home"], metavar="NAME", help=PRESET_HELP)
_FIDELITY = argument("--fidelity", choices=FIDELITIES, default="features", help=FIDELITY_HELP)
_OPENNESS = argument(
    "--openness",
    type=float,
    metavar="X",
    help="open or close inner walls of every house to X in [0, 1] (default: as sampled)",
)
_HOUSES = argument("--houses", type=positive, default=5, help="number of houses, from --seed upwards (default: %(default)s)")
_ENCODER = argument("--encoder", type=seeing_encoder, default="mini", metavar="MODEL", help=ENCODER_HELP)
_OWN_PYTESTS = 10
"""Approximate number of tests replaying a reduced scenario that pytest also runs in a process of its own."""
_CONFIG = argument("--config", type=Path, metavar="FILE", help=CONFIG_HELP)
_CSV = argument("--csv", type=Path, metavar="FILE", help="write the table to this file")
_PLOT = argument("--plot", type=Path, metavar="FILE", help="draw the figures in this file, .png or .svg")
_FEATURE_MODEL = argument("--feature-model", type=Path, metavar="FILE", help=FEATURE_MODEL_HELP)


def add_to(commands: Commands) -> None:
    """Add the command `bench` with its benchmarks."""
    add_actions(commands, "bench", "benchmarks", _BENCHMARKS, metavar="BENCHMARK")


def _printing(tables: Tables) -> Command:
    """Make a command that prints every table as soon as it is complete."""

    def command(arguments: argparse.Namespace) -> int:
        console = _console()
        for table in tables(arguments):
            console.print(table)
        return 0

    return command


def _console() -> Console:
    """Standard output, 200 columns wide if it is no terminal: rich would assume 80 columns then, and cut figures off."""
    return Console(width=None if sys.stdout.isatty() else 200)


def _houses(arguments: argparse.Namespace) -> str:
    """Describe the family of houses and its openness, for a table's title."""
    return arguments.preset if arguments.openness is None else f"{arguments.preset} at openness {arguments.openness:g}"


def _segmentation(arguments: argparse.Namespace) -> Iterator[Table]:
    from lexis.config import read_config
    from sim.bench.segmentation import SegmentationRow, mean_and_spread, run_houses
    from sim.harness import Scenario
    from sim.report.figures import shown

    title = escape(f"{_houses(arguments)}, encoder {arguments.encoder}, {arguments.fidelity}")
    table = Table("seed", *(field.name.replace("_", " ") for field in fields(SegmentationRow)), title=title)
    last = arguments.seed + arguments.houses - 1
    rows = []
    config = Scenario(
        preset=arguments.preset,
        encoder=arguments.encoder,
        fidelity=arguments.fidelity,
        feature_model=arguments.feature_model,
    )
    settings = read_config(arguments.config) if arguments.config else None
    for house, row in run_houses(config, range(arguments.seed, last + 1), arguments.openness, settings):
        rows.append(row)
        table.add_row(str(house), *(shown(value, "{:.3g}") for value in astuple(row)), end_section=house == last)
    for name, values in zip(("mean", "std"), mean_and_spread(rows), strict=True):
        table.add_row(name, *(shown(value, "{:.3g}") for value in values))
    yield table


def _speed(arguments: argparse.Namespace) -> Iterator[Table]:
    from sim.bench.speed import measure_speed

    for section in measure_speed(arguments.preset, arguments.houses, arguments.seed):
        # Escaped, since rich would take a unit in brackets for a style and leave it out.
        headers = [f"median [{section.unit}]", f"worst [{section.unit}]", f"limit [{section.unit}]", "runs [count]"]
        table = Table("step", *map(escape, headers), title=section.title, title_justify="left")
        for figure in section.figures:
            table.add_row(
                figure.name, *(f"{value:.4g}" for value in (figure.median, figure.worst)), figure.limit, str(figure.runs)
            )
        yield table


def _rooms(arguments: argparse.Namespace) -> Iterator[Table]:
    from sim.bench.peers.room_methods import compare_methods

    table = Table("labels, rooms by", "labels", "room PQ", "splits and merges", title=f"{_houses(arguments)}, features")
    seeds = range(arguments.seed, arguments.seed + arguments.houses)
    for row in compare_methods(arguments.preset, seeds, arguments.openness):
        spreads = f"{row.labels:.3f} ± {row.labels_std:.3f}", f"{row.rooms:.3f} ± {row.rooms_std:.3f}"
        table.add_row(row.method, *spreads, f"{row.splits_and_merges:.1f}")
    yield table


def _openness(arguments: argparse.Namespace) -> Iterator[Table]:
    from sim.bench.peers.openness_sweep import METHODS, OPENNESS, check_files, means, sweep, write_sweep

    check_files(arguments.out)
    seeds = range(arguments.seed, arguments.seed + arguments.houses)
    with Progress(console=Console(stderr=True), transient=True) as bar:
        total = len(METHODS) * len(OPENNESS) * len(seeds)
        rows = list(bar.track(sweep(arguments.preset, seeds), total=total, description="runs"))
    for path in arguments.out:
        write_sweep(rows, path)
    title = f"{arguments.preset}, seeds {seeds[0]} to {seeds[-1]}, features: room PQ (splits / merges per house)"
    table = Table("rooms by", *(f"openness {each:g}" for each in OPENNESS), title=title)
    for name, found in means(rows).items():
        cells = (f"{each.pq:.3f} ± {each.pq_std:.3f} ({each.splits:.1f} / {each.merges:.1f})" for each in found.values())
        table.add_row(name, *cells)
    yield table


def _table3(arguments: argparse.Namespace) -> Iterator[Table]:
    from sim.bench.peers.trajectories import PAPER_ATE_M, compare_trajectories, means
    from sim.bench.row_files import check_folder, write_rows

    if arguments.csv:
        check_folder(arguments.csv)
    seeds, presets = range(arguments.seed, arguments.seed + arguments.houses), arguments.presets
    rows = list(compare_trajectories(presets, seeds, arguments.fidelity))
    title = f"seeds {seeds[0]} to {seeds[-1]}, {arguments.fidelity}: ATE in m (share of the odometry's)"
    table = Table("method", *presets, title=title)
    for method, found in means(rows).items():
        table.add_row(method, *(f"{each.ate_m:.3f} ± {each.std_m:.3f} ({each.odometry:.2f})" for each in found.values()))
    table.add_section()
    for method, paper in PAPER_ATE_M.items():
        table.add_row(f"paper: {method}", *(f"{paper[each]:.2f}" if each in paper else "" for each in presets))
    yield table
    if arguments.csv:
        write_rows(rows, arguments.csv)


def _places(arguments: argparse.Namespace) -> Iterator[Table]:
    from sim.bench.places import FITTED, ask_everywhere, compare_places, fit_revisits, walks

    seeds = range(arguments.seed, arguments.seed + arguments.houses)
    answers = []
    for condition, scenarios in walks(arguments.presets, seeds, arguments.fidelity).items():
        found = [ask_everywhere(scenario) for scenario in scenarios]
        answers += found
        title = f"{', '.join(arguments.presets)}, seeds {seeds[0]} to {seeds[-1]}, {arguments.fidelity}: {condition}"
        headers = (f"{figure}, N = {n}" for n in (1, 3, 5) for figure in ("found", "false"))
        table = Table("candidates by", *headers, title=title)
        for row in compare_places(found):
            cells = ((f"{each.tp} of {each.possible}", str(each.fp)) for each in row.counts)
            table.add_row(row.method, *(cell for pair in cells for cell in pair))
        yield table
    if arguments.fit:
        fitted = fit_revisits(answers)
        table = Table("place_recognition", "fitted value", title="probability of a revisit, fitted to all of these walks")
        for name in FITTED:
            table.add_row(name, f"{getattr(fitted, name):.3g}")
        yield table


def _pose_graph(arguments: argparse.Namespace) -> Iterator[Table]:
    from sim.bench.public_pose_graphs import PoseGraphRow, optimise_files
    from sim.report.figures import shown

    title = "cost: half of the sum of squared residuals; excess: share above the least known cost"
    table = Table(*(field.name.replace("_", " ") for field in fields(PoseGraphRow)), title=title)
    for row in optimise_files(arguments.files):
        table.add_row(
            *(row.file, str(row.poses), str(row.edges), row.start, f"{row.start_cost:,.4g}", f"{row.cost:.6g}"),
            *(shown(row.excess, "{:.4%}"), shown(row.iterations, "{}"), f"{row.seconds:.2f}"),
        )
    yield table


def _sessions(arguments: argparse.Namespace) -> Iterator[Table]:
    from sim.bench.sessions import NEAR_M, measure_sessions, summary
    from sim.report.figures import shown

    title = f"{arguments.preset}, features: a session that starts somewhere on another day, {arguments.length:g} m of walk"
    headers = ("starts", "joined", f"joined within {NEAR_M:g} m", "median walk [m]", "largest error [m]")
    table = Table("house", *map(escape, headers), title=title)
    seeds = range(arguments.seed, arguments.seed + arguments.houses)
    for name, row in summary(measure_sessions(arguments.preset, seeds, arguments.every, arguments.length)).items():
        table.add_row(name, *(shown(value, "{:.3g}") for value in row))
    yield table


def _kernels(arguments: argparse.Namespace) -> Iterator[Table]:
    from sim.bench.kernels import draw_kernels, kernel_runs, mapped_houses, summarised
    from sim.bench.row_files import check_folder, check_picture, write_rows

    if arguments.csv:
        check_folder(arguments.csv)
    if arguments.plot:
        check_picture(arguments.plot)
    seeds = range(arguments.seed, arguments.seed + arguments.houses)
    rows = list(
        summarised(
            [each for house in mapped_houses(arguments.preset, seeds) for each in kernel_runs(house, arguments.threshold)]
        )
    )
    title = f"{arguments.preset}, seeds {seeds[0]} to {seeds[-1]}, features: mean ± std over houses"
    headers = ("ATE, m", "growth of the ATE", "true loops rejected", "houses without", "false loops trusted")
    table = Table("false loops", "share", "kernel", *headers, title=title)
    for row in rows:
        table.add_row(
            *(row.kind, f"{row.share:.0%}", row.kernel, f"{row.ate_m:.3f} ± {row.ate_std_m:.3f}", f"{row.growth:.1%}"),
            *(f"{row.true_rejected:.1%} ± {row.true_rejected_std:.1%}", f"{row.untouched:.0%}", f"{row.false_trusted:.1%}"),
            end_section=row.kernel == rows[-1].kernel,
        )
    yield table
    if arguments.csv:
        write_rows(rows, arguments.csv)
    if arguments.plot:
        draw_kernels(rows, arguments.plot)


def _scale(arguments: argparse.Namespace) -> Iterator[Table]:
    from sim.bench.scale import bytes_per_keyframe, measure_scale

    portions, finished = measure_scale(arguments.rooms, arguments.length, arguments.seed)
    kilobytes = bytes_per_keyframe(finished) / 1e3
    title = (
        f"{arguments.length:g} m through {arguments.rooms} rooms: {len(finished.loops)} loops, {kilobytes:.1f} kB a keyframe"
    )
    table = Table("keyframes", "ms per keyframe", title=title)
    for portion in portions:
        table.add_row(f"{portion.first} to {portion.last}", f"{portion.keyframe_ms:.2f}")
    yield table


def _throughput(arguments: argparse.Namespace) -> Iterator[Table]:
    from statistics import median

    from sim.bench.throughput import measure_throughput

    headers = ("tier", "houses/s", "wanted", "houses", "median s", "worst s", "processor s", "rooms", "keyframes")
    table = Table(*headers, title="homes of about ten rooms, one process for each core")
    for tier in measure_throughput(arguments.houses, arguments.seed):
        seconds = [each.seconds for each in tier.handled]
        names = ("processor_s", "rooms", "frames")
        processor_s, rooms, keyframes = (median(getattr(each, name) for each in tier.handled) for name in names)
        table.add_row(
            *(tier.tier, f"{tier.per_second:.3g}", f">= {tier.wanted:g}", str(len(seconds))),
            *(f"{median(seconds):.3g}", f"{max(seconds):.3g}", f"{processor_s:.3g}", f"{rooms:g}", f"{keyframes:g}"),
        )
    yield table


def _fidelity(arguments: argparse.Namespace) -> Iterator[Table]:
    from lexis.encoder.open_clip_encoder import load_encoder
    from sim.bench.fidelity import FIGURES, compare_fidelities, mixed_houses, percepts_per_second, summarised
    from sim.report.figures import shown

    table = Table("houses", "house", *(f"{name}, {side}" for name in FIGURES for side in ("render", "features")))
    pairs = []
    for pair in compare_fidelities(
        mixed_houses(arguments.houses, arguments.seed), load_encoder(arguments.encoder), arguments.feature_model
    ):
        pairs.append(pair)
        table.add_row(pair.group, pair.name, *(f"{value:.2f}" for name in FIGURES for value in getattr(pair, name)))
    yield table
    headers = ("houses", "how many", "figure", "mean, render", "mean, features", "mean difference", "Spearman's rho")
    rate = percepts_per_second(arguments.seed, arguments.feature_model)
    title = f"how well features predict renders, at {rate:,.0f} keyframes/s on one core"
    summary = Table(*headers, title=title, title_justify="left")
    for group, name, found in summarised(pairs):
        means = (f"{value:.3f}" for value in (found.rendered, found.features, found.mean_difference))
        summary.add_row(group, str(found.houses), name, *means, shown(found.rho, "{:.2f}"))
    yield summary


def _planning(arguments: argparse.Namespace) -> Iterator[Table]:
    from sim.bench.planning import DRIVERS, drive_houses
    from sim.harness import Scenario
    from sim.report.figures import shown

    seeds = range(arguments.seed, arguments.seed + arguments.houses)
    config = Scenario(preset=arguments.preset, encoder=arguments.encoder)
    title = escape(f"{_houses(arguments)}, encoder {arguments.encoder}")
    table = Table("seed", "driven by", "queries", "success", "spl", "touched", "seconds", title=title)
    rows = []
    for row in drive_houses(config, seeds, arguments.pictures, arguments.openness):
        rows.append(row)
        figures = (shown(row.success, "{:.3f}"), shown(row.spl, "{:.3f}"), str(row.touched), f"{row.seconds:.1f}")
        table.add_row(str(row.seed), row.driver, str(row.queries), *figures, end_section=row.driver == list(DRIVERS)[-1])
    for driver in DRIVERS:
        mine = [row for row in rows if row.driver == driver and row.queries]
        queries = sum(row.queries for row in mine)
        means = (sum(getattr(row, name) * row.queries for row in mine) / max(queries, 1) for name in ("success", "spl"))
        sums = str(sum(row.touched for row in mine)), f"{sum(row.seconds for row in mine):.1f}"
        table.add_row("all", driver, str(queries), *(f"{mean:.3f}" for mean in means), *sums)
    yield table


def _queries(arguments: argparse.Namespace) -> Iterator[Table]:
    from sim.bench.queries import SETS, Answered, QueriesRow, ask_houses, row_of
    from sim.harness import Scenario
    from sim.report.figures import shown

    title = escape(f"{arguments.preset}, encoder {arguments.encoder}")
    table = Table("seed", "list", *(field.name.replace("_", " ") for field in fields(QueriesRow)), title=title)
    failures = Table("seed", "list", "failed question", "best room", "said", title_justify="left")
    everything: dict[str, list[Answered]] = {name: [] for name in SETS}
    config = Scenario(preset=arguments.preset, encoder=arguments.encoder)
    for house, name, answered in ask_houses(config, range(arguments.seed, arguments.seed + arguments.houses)):
        everything[name] += answered
        table.add_row(str(house), name, *(shown(value, "{:.3g}") for value in astuple(row_of(answered))))
        for one in answered:
            if not one.succeeded:
                said = "nothing fits" if one.unknown else one.first
                failures.add_row(str(house), name, escape(one.question.text), one.first, said)
    table.add_section()
    for name, answered in everything.items():
        table.add_row("all", name, *(shown(value, "{:.3g}") for value in astuple(row_of(answered))))
    yield table
    yield failures


def _mutation(arguments: argparse.Namespace) -> int:
    """Print a line for each mutant as soon as it is graded, and a table; return 1 if unchanged LEXIS fails a check."""
    from sim.bench.mutation import MUTANTS, grade
    from sim.bench.mutation.grading import markdown_table, read_grades, write_grade

    laws, before = not arguments.no_laws, arguments.against
    graded = partial(grade, suite=arguments.suite, laws=laws, smallest=arguments.smallest, before=before)
    suite = arguments.suite if laws else f"{arguments.suite} without laws"
    kept = [] if arguments.out is None else read_grades(arguments.out)
    grades = [each for each in kept if (each.suite, each.seed) == (suite, arguments.seed) and arguments.only in each.mutant]
    done = {found.mutant for found in grades}
    for mutant in MUTANTS:
        if arguments.only in mutant.name and mutant.name not in done:
            grades.append(found := graded(mutant, arguments.seed))
            verdict = f"caught by {found.caught_by}" if found.is_caught else "not caught"
            print(f"{found.scenarios:4} scenarios {found.seconds:6.0f} s  {mutant.name}: {verdict}", flush=True)
            if arguments.out is not None:
                write_grade(found, arguments.out)
    print(markdown_table(grades))
    alarms = [graded(None, arguments.seed + k) for k in range(arguments.unchanged)]
    for k, found in enumerate(alarms):
        verdict = f"FALSE ALARM by {found.caught_by}: {found.measured}" if found.is_caught else "passes"
        print(f"{found.scenarios:4} scenarios {found.seconds:6.0f} s  unchanged LEXIS, seed {arguments.seed + k}: {verdict}")
    caught = sum(found.is_caught for found in grades)
    print(f"{caught} of {len(grades)} mutants are caught; {sum(found.is_caught for found in alarms)} false alarms")
    return int(any(found.is_caught for found in alarms))


def _shrinking(arguments: argparse.Namespace) -> int:
    """Print a line for each broken law and a table of the families of bugs; return 1 if a law is broken, else 0."""
    from sim.bench.shrinking import ProofPlan, folder_of, prove, summaries

    one_in = arguments.scenarios // _OWN_PYTESTS
    plan = ProofPlan(arguments.seed, arguments.deadline, arguments.rooms, arguments.out, one_in)
    proofs, progress = [], Console(stderr=True)
    with Progress(console=progress, transient=True, disable=not progress.is_terminal) as bar:
        proving = prove(plan, arguments.scenarios, arguments.processes)
        for proof in bar.track(proving, total=arguments.scenarios, description="scenarios"):
            proofs.append(proof)
            for law in proof.broken:
                print(f"{folder_of(proof.number, plan)}.json: {law}")
    headers = ("family", "scenarios", "in time", "broken", "needs", "rooms before", "rooms", "walk before, m", "walk, m")
    title = "reductions: median, 90 % and worst after it; before it, and what the bug needs at least"
    table = Table(*headers, "candidates", "seconds", title=title, title_justify="left")
    for row in summaries(proofs):
        table.add_row(*map(_spread, astuple(row)))
    _console().print(table)
    return int(any(proof.broken for proof in proofs))


def _spread(value: object) -> str:
    """A figure as text, with at most one decimal. The figures of a tuple are joined by slashes; None gives "" (empty)."""
    if isinstance(value, tuple):
        return " / ".join(map(_spread, value))
    if value is None:
        return ""
    return f"{value:.1f}".removesuffix(".0") if isinstance(value, float) else str(value)


_BENCHMARKS = (
    Action(
        "speed",
        _printing(_speed),
        "time for houses, scenes, images and mapping, each with its limit",
        "lexis-sim bench speed --preset home --houses 5",
        (_PRESET, _HOUSES, SEED),
    ),
    Action(
        "throughput",
        _printing(_throughput),
        "houses per second without rendering: checked layouts, and runs on the feature sensor",
        "lexis-sim bench throughput --houses 40",
        (_HOUSES, SEED),
    ),
    Action(
        "segmentation",
        _printing(_segmentation),
        "labels, rooms, loops and plans of whole runs, one row per house",
        "lexis-sim bench segmentation --preset home --houses 5 --fidelity features",
        (
            _PRESET,
            _HOUSES,
            _OPENNESS,
            _ENCODER,
            argument("--fidelity", choices=FIDELITIES, default="render", help=FIDELITY_HELP),
            _FEATURE_MODEL,
            _CONFIG,
            SEED,
        ),
    ),
    Action(
        "rooms",
        _printing(_rooms),
        "labels and rooms by the methods of the paper and by sight, on the same walks",
        "lexis-sim bench rooms --preset uh2-apt --houses 5 --seed 900",
        (_PRESET, _HOUSES, _OPENNESS, SEED),
    ),
    Action(
        "openness",
        _printing(_openness),
        "rooms by LEXIS and by segmentations of the true map, in houses with more and more open inner walls",
        "lexis-sim bench openness --houses 5 --seed 500 --out openness.csv openness.png",
        (
            _PRESET,
            _HOUSES,
            argument("--out", nargs="+", type=Path, default=[], metavar="FILE", help="write .csv, .png or .svg files"),
            SEED,
        ),
    ),
    Action(
        "table3",
        _printing(_table3),
        "trajectory errors of odometry and of LEXIS with each method of place recognition, as in the paper's Table III",
        "lexis-sim bench table3 --presets ori home --houses 5 --seed 500",
        (_PRESETS, _HOUSES, _FIDELITY, _CSV, SEED),
    ),
    Action(
        "places",
        _printing(_places),
        "loop candidates by the method of the paper, by similarity alone and by the probability of a revisit",
        "lexis-sim bench places --presets home ori --houses 5 --seed 900",
        (
            _PRESETS,
            _HOUSES,
            _FIDELITY,
            argument("--fit", action="store_true", help="also fit the probability of a revisit to these walks"),
            SEED,
        ),
    ),
    Action(
        "pose-graph",
        _printing(_pose_graph),
        "LEXIS's optimiser on pose graphs in g2o files: cost, iterations and time",
        "lexis-sim bench pose-graph sphere2500.g2o parking-garage.g2o",
        (argument("files", type=Path, nargs="+", metavar="FILE", help="pose graphs in three dimensions, as g2o files"),),
    ),
    Action(
        "sessions",
        _printing(_sessions),
        "whether a robot that returns on another day recognises where it is, and never does in a twin house",
        "lexis-sim bench sessions --preset home --houses 5",
        (
            _PRESET,
            _HOUSES,
            argument("--every", type=float, default=10.0, help="metres of walk between starts (default: %(default)s)"),
            argument("--length", type=float, default=15.0, help="length of each session in metres (default: %(default)s)"),
            SEED,
        ),
    ),
    Action(
        "kernels",
        _printing(_kernels),
        "robust kernels against false loops that are added to finished maps",
        "lexis-sim bench kernels --preset home --houses 5 --seed 500",
        (
            _PRESET,
            _HOUSES,
            argument(
                "--threshold",
                type=number(0.001, 1e6),
                default=12.6,
                help="squared whitened residual above which a kernel lowers a weight (default: %(default)s)",
            ),
            _CSV,
            _PLOT,
            SEED,
        ),
    ),
    Action(
        "scale",
        _printing(_scale),
        "time per keyframe and size of the map along one long walk",
        "lexis-sim bench scale --rooms 40 --length 10000",
        (
            argument("--rooms", type=positive, default=10, help="number of rooms of the home (default: %(default)s)"),
            argument("--length", type=float, default=1000.0, help="length of the walk in metres (default: %(default)s)"),
            SEED,
        ),
    ),
    Action(
        "encoders",
        _printing(bench_encoders.tables),
        "accuracy, questions, retrieval and times of encoders, as in the paper's Table I",
        "lexis-sim bench encoders --presets home ori --encoders mini --houses 5",
        bench_encoders.ARGUMENTS,
    ),
    Action(
        "queries",
        _printing(_queries),
        "everyday questions to the maps of generated homes, with a list of those that fail",
        "lexis-sim bench queries --preset home --houses 3 --seed 600",
        (_PRESET, _HOUSES, _ENCODER, SEED),
    ),
    Action(
        "fidelity",
        _printing(_fidelity),
        "how well runs without pixels predict runs with them",
        "lexis-sim bench fidelity --houses 5",
        (_HOUSES, _ENCODER, _FEATURE_MODEL, SEED),
    ),
    Action(
        "planning",
        _printing(_planning),
        "plans driven with LEXIS's pose estimate, with the true pose and with odometry alone",
        "lexis-sim bench planning --preset home --houses 5 --pictures failed-drives",
        (
            _PRESET,
            _HOUSES,
            _OPENNESS,
            _ENCODER,
            argument("--pictures", type=folder, metavar="DIR", help="draw failed drives of LEXIS here"),
            SEED,
        ),
    ),
    Action(
        "mutation",
        _mutation,
        "planted bugs of LEXIS that a suite finds; exit status 1 if unchanged LEXIS fails a check",
        "lexis-sim bench mutation --only loop",
        (
            argument("--only", default="", metavar="TEXT", help="mutants whose name contains this text (default: all)"),
            argument("--suite", default="pr", metavar="NAME", help="the suite (default: %(default)s)"),
            argument("--no-laws", action="store_true", help="let the suite make claims only, without laws"),
            argument("--against", type=Path, metavar="FILE", help="results of unchanged LEXIS, to compare with"),
            argument("--smallest", action="store_true", help="also look for the smallest scenario that shows each mutant"),
            argument("--unchanged", type=positive, default=1, metavar="N", help="seeds for unchanged LEXIS (default: 1)"),
            argument(
                "-o", "--out", type=Path, metavar="FILE", help="file for the grades; mutants in it are not graded again"
            ),
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
            argument(
                "--processes", type=positive, default=os.cpu_count() or 2, help="number of processes (default: one per core)"
            ),
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
