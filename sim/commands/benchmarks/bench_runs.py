"""Benchmarks of runs: times, labels, rooms, plans, questions, and what each stage of LEXIS costs."""

import argparse
from collections.abc import Iterator
from dataclasses import astuple, fields

from rich.markup import escape
from rich.table import Table

from sim.commands.action import Action
from sim.commands.arguments import FIDELITY_HELP, SEED, EachOnce, argument, folder
from sim.commands.benchmarks.bench_options import (
    CONFIG,
    CSV,
    ENCODER,
    FEATURE_MODEL,
    FIDELITY,
    HOUSES,
    OPENNESS,
    PRESET,
    RATE,
    SEVERAL_PRESETS,
    gain_texts,
    mean_std_text,
    printing,
    seeds_of,
)
from sim.commands.progress import tracked
from sim.fidelity import FIDELITIES
from sim.odometry.config import ODOMETRY_PRESETS
from sim.wording import seeds_text

_CERTAINTIES = (0.0, 0.5, 0.7, 0.8, 0.9, 0.95, 0.98, 1.0)
"""`bench certainty` compares stated probabilities with the truth in the intervals between these."""


def _speed(arguments: argparse.Namespace) -> Iterator[Table]:
    from sim.bench.speed import measure_speed

    for section in measure_speed(arguments.preset, arguments.houses, arguments.seed):
        # The text is escaped, because rich would read a unit in brackets as a style and leave it out.
        headers = [f"median [{section.unit}]", f"worst [{section.unit}]", f"limit [{section.unit}]", "runs [count]"]
        table = Table("step", *map(escape, headers), title=section.title, title_justify="left")
        for figure in section.figures:
            table.add_row(
                figure.name, *(f"{value:.4g}" for value in (figure.median, figure.worst)), figure.limit, str(figure.runs)
            )
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


def _houses(arguments: argparse.Namespace) -> str:
    """Describe the family of houses and its openness, for a table's title."""
    return arguments.preset if arguments.openness is None else f"{arguments.preset} at openness {arguments.openness:g}"


def _segmentation(arguments: argparse.Namespace) -> Iterator[Table]:
    from lexis.config import read_config
    from sim.bench.segmentation import SegmentationRow, means_and_stds, run_houses
    from sim.harness import Scenario
    from sim.report.figures import shown

    title = escape(f"{_houses(arguments)}, encoder {arguments.encoder}, {arguments.fidelity}")
    table = Table("seed", *(field.name.replace("_", " ") for field in fields(SegmentationRow)), title=title)
    seeds = seeds_of(arguments)
    rows = []
    scenario = Scenario(
        preset=arguments.preset,
        encoder=arguments.encoder,
        fidelity=arguments.fidelity,
        feature_model=arguments.feature_model,
    )
    settings = read_config(arguments.config) if arguments.config else None
    for house, row in run_houses(scenario, seeds, arguments.openness, settings):
        rows.append(row)
        table.add_row(str(house), *(shown(value, "{:.3g}") for value in astuple(row)), end_section=house == seeds[-1])
    for name, values in zip(("mean", "std"), means_and_stds(rows), strict=True):
        table.add_row(name, *(shown(value, "{:.3g}") for value in values))
    yield table


def _rooms(arguments: argparse.Namespace) -> Iterator[Table]:
    from sim.bench.peers.room_methods import compare_methods
    from sim.report.figures import shown

    table = Table("labels, rooms by", "labels", "room PQ", "splits and merges", title=f"{_houses(arguments)}, features")
    seeds = seeds_of(arguments)
    for row in compare_methods(arguments.preset, seeds, arguments.openness):
        spreads = (mean_std_text(*each, "{:.3f}") for each in ((row.labels, row.labels_std), (row.rooms, row.rooms_std)))
        table.add_row(row.method, *spreads, shown(row.splits_and_merges, "{:.1f}"))
    yield table


def _certainty(arguments: argparse.Namespace) -> Iterator[Table]:
    from lexis.evaluation import calibration_error, reliability
    from sim.bench.houses import for_seeds
    from sim.bench.peers.certainty import measure_certainty
    from sim.harness import Scenario
    from sim.harness.world_tests import usual_rate_hz
    from sim.report.figures import shown

    seeds, presets, fidelity = seeds_of(arguments), arguments.presets, arguments.fidelity
    usual = (Scenario(preset=name, fidelity=fidelity, frame_rate_hz=usual_rate_hz(fidelity)) for name in presets)
    scenarios = (own for scenario in usual for own in for_seeds(scenario, seeds))
    found = measure_certainty(tracked(scenarios, len(presets) * len(seeds), "houses"))
    houses = f"{', '.join(presets)}, {seeds_text(seeds)}, {fidelity}"
    for name, predictions in (("keyframes", found.keyframes), ("rooms", found.rooms)):
        error, share = calibration_error(predictions.stated, predictions.right), predictions.right.mean()
        title = f"{houses}: labels of {name}, {share:.3f} right, calibration error {error:.3f}"
        table = Table("probability", name, "stated, mean", "right", title=title)
        for row in reliability(predictions.stated, predictions.right, _CERTAINTIES):
            shares = (shown(value, "{:.3f}") for value in (row.stated, row.right))
            table.add_row(f"{row.low:g} to {row.high:g}", str(row.predictions), *shares)
        yield table


def _stages(arguments: argparse.Namespace) -> Iterator[Table]:
    from sim.bench.row_files import check_files, write_rows
    from sim.bench.stage_costs import gains, measure_stages

    check_files(arguments.csv, valid=(".csv",))
    seeds, presets = seeds_of(arguments), arguments.presets
    measured = tracked(measure_stages(presets, seeds), len(presets) * len(seeds), "houses")
    rows = [row for house in measured for row in house]
    rows.sort(key=lambda row: (presets.index(row.preset), row.seed))
    title = f"{', '.join(presets)}, {seeds_text(seeds)}, features: change, mean ± standard error over houses"
    table = Table("replaced", "houses", "labels", "room PQ", "ATE, m", "right plans", title=title)
    for name, found in gains(rows).items():
        table.add_row(name, str(found.houses), *gain_texts(name, found))
    if arguments.csv:
        write_rows(rows, arguments.csv)
    yield table


def _planning(arguments: argparse.Namespace) -> Iterator[Table]:
    from sim.bench.planning import DRIVERS, drive_houses
    from sim.harness import Scenario
    from sim.report.figures import shown

    seeds = seeds_of(arguments)
    drivers = arguments.drivers or list(DRIVERS)
    scenario = Scenario(
        preset=arguments.preset, odometry=arguments.odometry, encoder=arguments.encoder, fidelity=arguments.fidelity
    )
    title = escape(f"{_houses(arguments)}, {arguments.fidelity}, odometry {arguments.odometry}, encoder {arguments.encoder}")
    table = Table("seed", "driven by", "queries", "success", "spl", "touched", "seconds", title=title)
    rows = []
    for row in drive_houses(scenario, seeds, arguments.pictures, arguments.openness, drivers):
        rows.append(row)
        figures = (shown(row.success, "{:.3f}"), shown(row.spl, "{:.3f}"), str(row.touched), f"{row.seconds:.1f}")
        table.add_row(str(row.seed), row.driver, str(row.queries), *figures, end_section=row.driver == drivers[-1])
    for driver in drivers:
        mine = [row for row in rows if row.driver == driver and row.queries]
        queries = sum(row.queries for row in mine)
        totals = (sum(getattr(row, name) * row.queries for row in mine) for name in ("success", "spl"))
        means = (shown(total / queries if queries else None, "{:.3f}") for total in totals)
        sums = str(sum(row.touched for row in mine)), f"{sum(row.seconds for row in mine):.1f}"
        table.add_row("all", driver, str(queries), *means, *sums)
    yield table


def _queries(arguments: argparse.Namespace) -> Iterator[Table]:
    from sim.bench.answers import SETS, Answered, QueriesRow, ask_houses, row_of
    from sim.harness import Scenario
    from sim.harness.world_tests import RENDER_FRAME_RATE_HZ
    from sim.report.figures import shown

    title = escape(f"{arguments.preset}, encoder {arguments.encoder}")
    table = Table("seed", "list", *(field.name.replace("_", " ") for field in fields(QueriesRow)), title=title)
    failures = Table("seed", "list", "failed question", "best room", "said", title_justify="left")
    everything: dict[str, list[Answered]] = {name: [] for name in SETS}
    rate_hz = arguments.rate or RENDER_FRAME_RATE_HZ
    scenario = Scenario(preset=arguments.preset, encoder=arguments.encoder, frame_rate_hz=rate_hz)
    for house, name, answered in ask_houses(scenario, seeds_of(arguments)):
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


def _fidelity(arguments: argparse.Namespace) -> Iterator[Table]:
    from lexis.encoder.open_clip_encoder import load_encoder
    from sim.bench.fidelity import HOUSE_FIGURES, compare_fidelities, mixed_houses, percepts_per_second, summarised
    from sim.report.figures import shown

    table = Table("houses", "house", *(f"{name}, {side}" for name in HOUSE_FIGURES for side in ("render", "features")))
    pairs = []
    for pair in compare_fidelities(
        mixed_houses(arguments.houses, arguments.seed), load_encoder(arguments.encoder), arguments.feature_model
    ):
        pairs.append(pair)
        figures = (value for name in HOUSE_FIGURES for value in getattr(pair, name))
        table.add_row(pair.group, pair.name, *(shown(value, "{:.2f}") for value in figures))
    yield table
    headers = (
        "houses",
        "how many",
        "figure",
        "mean, render",
        "mean, features",
        "mean absolute difference",
        "Spearman's rho",
    )
    rate = percepts_per_second(arguments.seed, arguments.feature_model)
    title = f"how well features predict renders, at {rate:,.0f} keyframes/s on one core"
    summary = Table(*headers, title=title, title_justify="left")
    for group, name, found in summarised(pairs):
        means = (found.rendered, found.features, found.mean_absolute_difference)
        texts = (shown(mean, "{:.3f}") for mean in means)
        summary.add_row(group, str(found.houses), name, *texts, shown(found.rho, "{:.2f}"))
    yield summary


BENCHMARKS = (
    Action(
        "speed",
        printing(_speed),
        "time for houses, scenes, images and mapping, each with its limit",
        "lexis-sim bench speed --preset home --houses 5",
        (PRESET, HOUSES, SEED),
    ),
    Action(
        "throughput",
        printing(_throughput),
        "houses per second without rendering: checked layouts, and runs on the feature sensor",
        "lexis-sim bench throughput --houses 40",
        (HOUSES, SEED),
    ),
    Action(
        "segmentation",
        printing(_segmentation),
        "labels, rooms, places, loops and plans of whole runs, one row per house",
        "lexis-sim bench segmentation --preset home --houses 5 --fidelity features",
        (
            PRESET,
            HOUSES,
            OPENNESS,
            ENCODER,
            argument("--fidelity", choices=FIDELITIES, default="render", help=FIDELITY_HELP),
            FEATURE_MODEL,
            CONFIG,
            SEED,
        ),
    ),
    Action(
        "rooms",
        printing(_rooms),
        "labels and rooms by the methods of the paper and by sight, on the same walks",
        "lexis-sim bench rooms --preset uh2-apt --houses 5 --seed 900",
        (PRESET, HOUSES, OPENNESS, SEED),
    ),
    Action(
        "certainty",
        printing(_certainty),
        "the probabilities that LEXIS states for its labels, against how often the labels are right",
        "lexis-sim bench certainty --presets home ori --houses 5 --seed 500",
        (SEVERAL_PRESETS, HOUSES, FIDELITY, SEED),
    ),
    Action(
        "stages",
        printing(_stages),
        "what each stage of LEXIS costs in labels, rooms, trajectories and plans: the blame table over many houses",
        "lexis-sim bench stages --presets home ori --houses 50 --seed 500 --csv stages.csv",
        (SEVERAL_PRESETS, HOUSES, CSV, SEED),
    ),
    Action(
        "planning",
        printing(_planning),
        "plans driven with LEXIS's pose estimate, with the true pose and with odometry alone",
        "lexis-sim bench planning --preset home --houses 5 --pictures failed-drives",
        (
            PRESET,
            HOUSES,
            OPENNESS,
            ENCODER,
            argument("--fidelity", choices=FIDELITIES, default="render", help=FIDELITY_HELP),
            argument("--odometry", choices=ODOMETRY_PRESETS, default="multicam", help="odometry of walks and drives"),
            argument(
                "--drivers",
                nargs="+",
                action=EachOnce,
                metavar="NAME",
                help="only these drivers, such as LEXIS (default: all)",
            ),
            argument("--pictures", type=folder, metavar="DIR", help="draw failed drives of LEXIS here"),
            SEED,
        ),
    ),
    Action(
        "queries",
        printing(_queries),
        "everyday questions to the maps of generated homes, with a list of those that fail",
        "lexis-sim bench queries --preset home --houses 3 --seed 600",
        (PRESET, HOUSES, RATE, ENCODER, SEED),
    ),
    Action(
        "fidelity",
        printing(_fidelity),
        "how well runs without pixels predict runs with them",
        "lexis-sim bench fidelity --houses 5",
        (HOUSES, ENCODER, FEATURE_MODEL, SEED),
    ),
)
