"""`lexis-sim bench encoders`: tables of label accuracy, computing times, retrieval and answers to questions."""

import argparse
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import astuple, fields
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from rich.markup import escape
from rich.table import Table

from lexis.command_line import positive, seed
from sim.commands.arguments import EachOnce, argument, folder, seeing_encoder
from sim.commands.benchmarks.bench_options import mean_std_text
from sim.report.figures import MISSING, shown
from worlds.presets import PRESETS

if TYPE_CHECKING:
    from sim.bench.encoders.measure import EncoderFigures
    from sim.bench.encoders.table import Accuracy, TableRow

_WAYS = ("cpu", "cpu bf16", "gpu", "gpu fp16")
_COMPILED = ("cpu compiled", "gpu fp16 compiled")


ARGUMENTS = (
    argument(
        "--presets",
        nargs="+",
        action=EachOnce,
        choices=PRESETS,
        default=["home"],
        metavar="NAME",
        help=f"families of houses: {', '.join(PRESETS)} (default: home)",
    ),
    argument("--houses", type=positive, default=5, help="test houses of every family (default: %(default)s)"),
    argument(
        "--encoders",
        nargs="+",
        action=EachOnce,
        type=seeing_encoder,
        default=["mini"],
        metavar="MODEL",
        help="mini, MODEL[:PRETRAINED] or MODEL:PATH of open_clip (default: mini)",
    ),
    argument(
        "--work",
        type=folder,
        metavar="DIR",
        help="work folder of train-encoder: its frames train the ceiling classifier, and test frames are cached in it",
    ),
    argument(
        "--architectures",
        nargs="+",
        default=[],
        metavar="NAME",
        help="architectures of open_clip to time with random weights",
    ),
    argument("--compiled", action="store_true", help="also time compiled networks, which takes a minute or more for each"),
    argument("--csv", type=Path, metavar="FILE", help="write the table of accuracy and times to this file"),
    argument("--plot", type=Path, metavar="FILE", help="draw accuracy against time in this file, .png or .svg"),
    argument(
        "--worst",
        type=positive,
        metavar="N",
        help="list the N questions that fail most often, and the N held-out names that lower accuracy most",
    ),
    argument("--seed", type=seed, default=0, help="number of the first test house (default: %(default)s)"),
)


def tables(arguments: argparse.Namespace) -> Iterator[Table]:
    """Yield tables for every preset and encoder, then one of accuracy and times like Table I of the LEXIS paper."""
    from lexis.encoder.open_clip_encoder import load_encoder
    from sim.bench.encoders.ceiling import ceiling_of
    from sim.bench.encoders.measure import References, measure
    from sim.bench.encoders.runs import encoder_runs
    from sim.bench.encoders.table import Accuracy, draw_plot, write_csv
    from sim.bench.peers.place_methods import ORB_LEVELS, word_tree
    from sim.training.houses import TEST_SEEDS

    _check(arguments)
    work: Path | None = arguments.work
    models: list[str] = arguments.encoders
    encoders = [load_encoder(model) for model in models]
    references = References(ceiling_of(work) if work and (work / "frames").is_dir() else None, word_tree(ORB_LEVELS))
    seeds = TEST_SEEDS[arguments.seed : arguments.seed + arguments.houses]
    accuracy: dict[str, dict[str, Accuracy]] = {model: {} for model in models}
    details: list[Table] = []
    for preset in arguments.presets:
        runs = list(measure(encoders, encoder_runs(preset, seeds, work and work / "test-frames"), references))
        for model, houses in zip(models, zip(*runs, strict=True), strict=True):
            accuracy[model][preset] = Accuracy(tuple(house.row.accuracy for house in houses))
            details += _of_preset(f"{preset}, encoder {model}", houses, arguments.worst)
    rows = list(_timed_rows(accuracy, arguments))
    if arguments.csv:
        write_csv(rows, arguments.csv)
    if arguments.plot:
        draw_plot(rows, arguments.plot)
    yield from (*details, _table_one(rows))


def _check(arguments: argparse.Namespace) -> None:
    """Check the arguments that are used only after minutes of work. Raises `SimError` or `EncoderError`."""
    from sim.bench.encoders.times import check_architecture
    from sim.bench.row_files import PICTURES, check_files
    from sim.errors import SimError
    from sim.output_files import make_output_folder
    from sim.training.houses import TEST_SEEDS

    if arguments.seed + arguments.houses > len(TEST_SEEDS):
        valid = f"at most {len(TEST_SEEDS)}, the number of test houses"
        raise SimError(f"--seed {arguments.seed} with --houses {arguments.houses}: their sum is too large; valid: {valid}")
    if arguments.work is not None:
        make_output_folder(arguments.work)
    for architecture in arguments.architectures:
        check_architecture(architecture)
    check_files(arguments.csv, valid=(".csv",))
    check_files(arguments.plot, valid=PICTURES)


def _of_preset(title: str, houses: Sequence["EncoderFigures"], worst: int | None) -> Iterator[Table]:
    yield _houses(title, houses)
    yield _questions(houses)
    yield _bands(houses)
    if worst:
        yield _worst(houses, worst)
        yield _worst_names(houses, worst)


def _houses(title: str, houses: Sequence["EncoderFigures"]) -> Table:
    from sim.bench.encoders.measure import EncoderRow, overall_calibration_error
    from sim.bench.encoders.retrieval import share
    from sim.bench.segmentation import means_and_stds

    table = Table("seed", *(field.name.replace("_", " ") for field in fields(EncoderRow)), title=escape(title))
    for house in houses:
        table.add_row(str(house.seed), *_shares(astuple(house.row)), end_section=house is houses[-1])
    for name, figures in zip(("mean", "std"), means_and_stds([house.row for house in houses]), strict=True):
        table.add_row(name, *_shares(figures))
    found = {name: np.concatenate([house.found[name] for house in houses]) for name in houses[0].found}
    recalls = ", ".join(f"{name.replace('_', ' ')} {shown(share(answers), '{:.3f}')}" for name, answers in found.items())
    table.caption = (
        f"calibration error over all frames: {overall_calibration_error(houses):.3f}; "
        f"over all {len(found['recall'])} revisits: {recalls}"
    )
    return table


def _questions(houses: Sequence["EncoderFigures"]) -> Table:
    from sim.bench.encoders.questions import TOPICS, WORDINGS, share_right
    from sim.bench.row_files import mean_and_std

    title = "questions that rank the right room first: mean over houses (questions in all)"
    table = Table("about", *WORDINGS, title=title, title_justify="left")
    for topic in TOPICS:
        cells = []
        for wording in WORDINGS:
            found = [share_right(house.asked, topic, wording) for house in houses]
            mean, _ = mean_and_std(share for share, _ in found)
            cells.append(f"{shown(mean, '{:.3f}')} ({sum(count for _, count in found)})")
        table.add_row(topic, *cells)
    return table


def _bands(houses: Sequence["EncoderFigures"]) -> Table:
    from sim.bench.encoders.ceiling import by_own_room

    columns = {"accuracy": "right", "ceiling": "ceiling_right", "room that fills most": "prevails"}
    answers = {name: [getattr(house, field) for house in houses] for name, field in columns.items()}
    known = {name: np.concatenate(each) for name, each in answers.items() if each[0] is not None}
    title = "accuracy by the share of the image that shows the room containing the camera"
    table = Table("share of image", "share of frames", *known, title=title, title_justify="left")
    for band in by_own_room(np.concatenate([house.own_room for house in houses]), known):
        share = "all" if (band.low, band.high) == (0.0, 1.0) else f"{band.low:.0%} ... {band.high:.0%}"
        table.add_row(share, *_shares((band.share, *band.right.values())))
    return table


def _worst(houses: Sequence["EncoderFigures"], count: int) -> Table:
    from sim.bench.encoders.questions import failures

    title = "questions that fail most often"
    table = Table(
        "about", "right answer", "topic", "wording", "asked", "right", "most said instead", title=title, title_justify="left"
    )
    for failure in failures([asked for house in houses for asked in house.asked])[:count]:
        counts = str(failure.asked), str(failure.right)
        table.add_row(failure.about, failure.answer, failure.topic, failure.wording, *counts, failure.instead)
    return table


def _worst_names(houses: Sequence["EncoderFigures"], count: int) -> Table:
    from sim.bench.encoders.measure import worst_names

    title = "held-out names that lower accuracy most, if all other rooms keep their labels as names"
    table = Table("rooms", "called", "loss of accuracy", title=title, title_justify="left")
    for label, name, loss in worst_names(houses)[:count]:
        table.add_row(label, name, f"{loss:.3f}")
    return table


def _timed_rows(accuracy: Mapping[str, Mapping[str, "Accuracy"]], arguments: argparse.Namespace) -> Iterator["TableRow"]:
    from sim.bench.encoders.table import RANDOM, TRAINED, TableRow
    from sim.bench.encoders.times import example_image, timed, timed_with_random_weights

    image = example_image()
    ways = [*_WAYS, *(_COMPILED if arguments.compiled else ())]
    for model, found in accuracy.items():
        yield TableRow(model, TRAINED, found, {way: timed(model, way, image) for way in ways})
    for architecture in arguments.architectures:
        yield TableRow(architecture, RANDOM, {}, timed_with_random_weights(architecture, ways, image))


def _table_one(rows: Sequence["TableRow"]) -> Table:
    from sim.bench.encoders.times import Timing

    presets = list(dict.fromkeys(preset for row in rows for preset in row.accuracy))
    ways = list(rows[0].times)
    title = "accuracy before refinement, mean ± std over runs; median time of an image + the five prompts of a room's name"
    table = Table(
        "encoder",
        "weights",
        *presets,
        *(escape(f"{way} [ms]") for way in ways),
        escape("loading [s]"),
        title=title,
        title_justify="left",
    )
    for row in rows:
        found = [row.accuracy.get(preset) for preset in presets]
        cells = [MISSING if a is None else mean_std_text(a.mean, a.std, "{:.3f}") for a in found]
        times = [f"{t.image_ms:.1f} + {t.text_ms:.1f}" if isinstance(t, Timing) else t for t in row.times.values()]
        loading = shown(row.cpu and row.cpu.loading_s, "{:.2f}")
        table.add_row(escape(row.encoder), row.weights, *cells, *map(escape, times), loading)
    return table


def _shares(values: Iterable[float | None]) -> list[str]:
    return [shown(value, "{:.3f}") for value in values]
