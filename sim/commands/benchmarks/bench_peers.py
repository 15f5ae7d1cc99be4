"""Benchmarks that compare LEXIS with other methods in the same runs."""

import argparse
import statistics
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from rich.table import Table

from sim.commands.action import Action
from sim.commands.arguments import SEED, EachOnce, argument, number
from sim.commands.benchmarks.bench_options import (
    CSV,
    FIDELITY,
    FILES,
    HOUSES,
    PRESET,
    RATE,
    SEVERAL_PRESETS,
    gain_texts,
    mean_std_text,
    printing,
    seeds_of,
)
from sim.commands.benchmarks.own_methods import PLACE_METHOD, SEGMENTATION, own_places, own_segmentations
from sim.commands.progress import tracked
from sim.errors import SimError
from sim.wording import seeds_text

if TYPE_CHECKING:
    from lexis.evaluation.place_recognition import MatchCounts
    from sim.bench.peers.difficulty_sweep import Difficulty
    from sim.bench.peers.place_methods import Contestant, PlaceTotal
    from sim.bench.peers.place_walks import PlaceWalk
    from sim.bench.places import Answers

_SWEPT = ("clutter", "odometry", "spacing", "light", "texture")
_AT_N = ("N = 1", "N = 3", "N = 5")
_RIGHT_M = 0.5
"""Largest absolute trajectory error of a map that counts as right [m]."""
_ERRORS = (f"maps within {_RIGHT_M:g} m", "median", "largest", "median of the odometry", "largest of the odometry")


def _openness(arguments: argparse.Namespace) -> Iterator[Table]:
    from sim.bench.peers.difficulty_sweep import DIFFICULTIES

    openness = DIFFICULTIES["openness"]
    values = tuple(arguments.values) or openness.values
    return _sweep(arguments, "openness", replace(openness, fidelity=arguments.fidelity, values=values))


def _sweep_over(arguments: argparse.Namespace) -> Iterator[Table]:
    from sim.bench.peers.difficulty_sweep import DIFFICULTIES

    return _sweep(arguments, arguments.over, DIFFICULTIES[arguments.over], arguments.length, arguments.rate)


def _sweep(
    arguments: argparse.Namespace,
    over: str,
    difficulty: "Difficulty",
    length_m: float | None = None,
    rate_hz: float | None = None,
) -> Iterator[Table]:
    from sim.bench.peers.difficulty_sweep import means, sweep, write_sweep
    from sim.bench.row_files import check_files
    from sim.report.figures import shown

    check_files(*arguments.out)
    seeds, own = seeds_of(arguments), own_segmentations(arguments.segmentation)
    total = (len(difficulty.methods) + len(own)) * len(difficulty.values) * len(seeds)
    rows = list(tracked(sweep(arguments.preset, seeds, difficulty, length_m, rate_hz, own), total, "runs"))
    houses = f"{arguments.preset}, {seeds_text(seeds)}, {difficulty.fidelity}"
    for path in arguments.out:
        write_sweep(rows, over, houses, path)
    title = f"{houses}: room PQ (splits / merges per house), labels"
    table = Table("rooms by", *(f"{over} {each}" for each in difficulty.values), title=title)
    for name, found in means(rows).items():
        cells = (
            f"{mean_std_text(each.pq, each.pq_std, '{:.3f}')} "
            f"({shown(each.splits, '{:.1f}')} / {shown(each.merges, '{:.1f}')}) {shown(each.labels, '{:.3f}')}"
            for each in found.values()
        )
        table.add_row(name, *cells)
    yield table


def _table2(arguments: argparse.Namespace) -> Iterator[Table]:
    from sim.bench.peers.labels import PAPER_ACCURACY, compare_labels, means
    from sim.bench.row_files import check_files, write_rows

    check_files(arguments.csv, valid=(".csv",))
    seeds, presets = seeds_of(arguments), arguments.presets
    walks = compare_labels(presets, seeds, arguments.fidelity)
    rows = [row for walk in tracked(walks, len(presets) * len(seeds), "walks") for row in walk]
    title = f"{seeds_text(seeds)}, {arguments.fidelity}: label accuracy over keyframes (over found rooms) in %"
    table = Table("method", *presets, title=title)
    for method, found in means(rows).items():
        shares = ((_percent(each.accuracy, each.std), each.rooms) for each in found.values())
        table.add_row(method, *(share if rooms is None else f"{share} ({100 * rooms:.0f})" for share, rooms in shares))
    table.add_section()
    for method, paper in PAPER_ACCURACY.items():
        table.add_row(f"paper: {method}", *(_percent(*paper[each]) if each in paper else "" for each in presets))
    if arguments.csv:
        write_rows(rows, arguments.csv)
    yield table


def _percent(mean: float | None, std: float | None) -> str:
    """A share and its standard deviation in per cent."""
    percent, percent_std = (None if share is None else 100 * share for share in (mean, std))
    return mean_std_text(percent, percent_std, "{:.1f}")


def _table3(arguments: argparse.Namespace) -> Iterator[Table]:
    from sim.bench.peers.trajectories import PAPER_ATE_M, compare_trajectories, means
    from sim.bench.row_files import check_files, write_rows
    from sim.report.figures import shown

    check_files(arguments.csv, valid=(".csv",))
    seeds, presets = seeds_of(arguments), arguments.presets
    rows = list(compare_trajectories(presets, seeds, arguments.fidelity))
    title = f"{seeds_text(seeds)}, {arguments.fidelity}: ATE in m (share of the odometry's)"
    table = Table("method", *presets, title=title)
    for method, found in means(rows).items():
        errors = (mean_std_text(each.ate_m, each.std_m, "{:.3f}") for each in found.values())
        shares = (shown(each.ratio_to_odometry, "{:.2f}") for each in found.values())
        table.add_row(method, *(f"{error} ({share})" for error, share in zip(errors, shares, strict=True)))
    table.add_section()
    for method, paper in PAPER_ATE_M.items():
        table.add_row(f"paper: {method}", *(f"{paper[each]:.2f}" if each in paper else "" for each in presets))
    if arguments.csv:
        write_rows(rows, arguments.csv)
    yield table


def _fig5(arguments: argparse.Namespace) -> Iterator[Table]:
    from sim.bench.peers.place_figures import PLACES
    from sim.bench.peers.place_methods import compare_place_methods, equally_often, totals
    from sim.bench.peers.place_picture import write_places
    from sim.bench.peers.place_walks import record_walks
    from sim.bench.row_files import check_files

    check_files(*arguments.out)
    if arguments.tune and arguments.out:
        raise SimError("--tune writes no files; valid: --tune without --out")
    presets, seeds, own = arguments.presets, seeds_of(arguments), own_places(arguments.place_method)
    walks = tracked(record_walks(presets, seeds, arguments.length, arguments.rate), len(presets) * len(seeds), "walks")
    if arguments.tune:
        yield _tuned_places(walks, own)
        return
    found = list(compare_place_methods(walks, own))
    for path in arguments.out:
        write_places(found, path)
    as_often = equally_often(found)
    for preset, methods in totals(found).items():
        title = f"{preset}, {seeds_text(seeds)}, walks of {arguments.length:g} m"
        yield _matches(methods, title)
        yield _matches_as_often(methods, as_often[preset], f"{preset}: true / false matches with as many answers")
        false = Table("method", *PLACES, title=f"{preset}: false matches at N = 1")
        for name, total in methods.items():
            false.add_row(name, *map(str, total.false_places))
        yield false


def _matches(methods: "Mapping[str, PlaceTotal]", title: str) -> Table:
    from sim.report.figures import shown

    headers = (*_AT_N, "recall among 1 / 3 / 5", "recall without error", "average precision")
    table = Table("method", *headers, title=f"{title}: true / false matches")
    for name, total in methods.items():
        cells = (f"{each.tp} / {each.fp} of {each.possible}" for each in total.counts)
        recalls = " / ".join(shown(each, "{:.2f}") for each in total.recalls)
        figures = (total.curve.at_full_precision, total.curve.average_precision)
        precision = (shown(each if total.counts[0].possible else None, "{:.2f}") for each in figures)
        table.add_row(name, *cells, recalls, *precision)
    return table


def _matches_as_often(
    methods: "Mapping[str, PlaceTotal]", as_often: "Mapping[str, tuple[MatchCounts, ...]]", title: str
) -> Table:
    table = Table("method", *(f"{n}, {whose}" for n in _AT_N for whose in ("LEXIS", "method")), title=title)
    for name, counts in as_often.items():
        pairs = zip(counts, methods[name].counts, strict=True)
        table.add_row(name, *(f"{each.tp} / {each.fp}" for pair in pairs for each in pair))
    return table


def _tuned_places(walks: "Iterable[PlaceWalk]", own: "Mapping[str, Contestant]") -> Table:
    """Tune the methods of the user's own, or without any all methods that have something to tune."""
    from sim.bench.peers.place_tuning import SettingsSearch, tune

    table = Table("method", "settings", "least score", "mean F1", title="best settings on these walks")
    for tuned in tune(list(walks), {name: SettingsSearch(each.make) for name, each in own.items()}):
        settings = ", ".join(f"{name} {value}" for name, value in tuned.settings.items())
        table.add_row(tuned.method, settings, f"{tuned.least:.3f}", f"{tuned.f1:.3f}")
    return table


def _places(arguments: argparse.Namespace) -> Iterator[Table]:
    from sim.bench.places import FITTED, ask_everywhere, compare_places, fit_revisits, walks

    seeds = seeds_of(arguments)
    answers = []
    houses = f"{', '.join(arguments.presets)}, {seeds_text(seeds)}, {arguments.fidelity}"
    errors = Table("condition", *_ERRORS, title=f"{houses}: errors of the maps, ATE, m")
    for condition, scenarios in walks(arguments.presets, seeds, arguments.fidelity).items():
        found = [ask_everywhere(scenario) for scenario in scenarios]
        answers += found
        errors.add_row(condition, *_map_errors(found))
        title = f"{houses}: {condition}"
        headers = (f"{figure}, N = {n}" for n in (1, 3, 5) for figure in ("found", "false"))
        table = Table("candidates by", *headers, title=title)
        for row in compare_places(found):
            cells = ((f"{each.tp} of {each.possible}", str(each.fp)) for each in row.counts)
            table.add_row(row.method, *(cell for pair in cells for cell in pair))
        yield table
    yield errors
    if arguments.fit:
        fitted = fit_revisits(answers)
        table = Table("place_recognition", "fitted value", title="probability of a revisit, fitted to all of these walks")
        for name in FITTED:
            table.add_row(name, f"{getattr(fitted, name):.3g}")
        yield table


def _map_errors(walks: "Sequence[Answers]") -> tuple[str, ...]:
    """Return the cells below `_ERRORS` for walks in one condition."""
    maps = [walk.ate_m for walk in walks if walk.ate_m is not None]
    odometry = [walk.ate_odometry_m for walk in walks if walk.ate_odometry_m is not None]
    if not maps:
        return ("0 of 0", *["-"] * 4)
    right = sum(error <= _RIGHT_M for error in maps)
    figures = (f"{figure:.2f}" for errors in (maps, odometry) for figure in (statistics.median(errors), max(errors)))
    return f"{right} of {len(maps)}", *figures


def _settings(arguments: argparse.Namespace) -> Iterator[Table]:
    from sim.bench.peers.responses import SECTIONS, check_sections, measure_responses, write_responses
    from sim.bench.row_files import check_files
    from sim.bench.stage_costs import UNCHANGED, gains

    check_files(*arguments.out)
    check_sections(arguments.sections)
    seeds, presets, sections = seeds_of(arguments), arguments.presets, arguments.sections or SECTIONS
    measured = measure_responses(presets, seeds, sections, arguments.fidelity)
    rows = [row for house in tracked(measured, len(presets) * len(seeds), "houses") for row in house]
    rows.sort(key=lambda row: (presets.index(row.preset), row.seed))
    for path in arguments.out:
        write_responses(rows, sections, path)
    title = f"{', '.join(presets)}, {seeds_text(seeds)}, {arguments.fidelity}: change, mean ± standard error"
    table = Table("setting", "labels", "room PQ", "ATE, m", "right plans", title=title)
    for name, found in gains(rows).items():
        table.add_row("default" if name == UNCHANGED else name, *gain_texts(name, found))
    yield table


BENCHMARKS = (
    Action(
        "settings",
        printing(_settings),
        "how labels, rooms, trajectories and plans respond to each setting of LEXIS",
        "lexis-sim bench settings --presets home ori --houses 5 --seed 100 --sections sight",
        (
            SEVERAL_PRESETS,
            HOUSES,
            FIDELITY,
            argument(
                "--sections",
                nargs="+",
                action=EachOnce,
                default=[],
                metavar="NAME",
                help="only these sections, such as sight",
            ),
            FILES,
            SEED,
        ),
    ),
    Action(
        "openness",
        printing(_openness),
        "rooms by LEXIS and by segmentations of the true map, in houses with more and more open inner walls",
        "lexis-sim bench openness --houses 5 --seed 500 --out openness.csv openness.png",
        (
            PRESET,
            HOUSES,
            FIDELITY,
            argument(
                "--values",
                nargs="+",
                type=number(0.0, 1.0),
                action=EachOnce,
                default=[],
                metavar="SHARE",
                help="shares of the inner walls that are open (default: 0 0.3 0.6 0.9)",
            ),
            SEGMENTATION,
            FILES,
            SEED,
        ),
    ),
    Action(
        "sweep",
        printing(_sweep_over),
        "the same while another difficulty grows: clutter, odometry errors, distance of keyframes, light or texture",
        "lexis-sim bench sweep odometry --houses 5 --seed 500",
        (
            argument("over", choices=_SWEPT, metavar="DIFFICULTY", help=f"what becomes harder: {', '.join(_SWEPT)}"),
            PRESET,
            HOUSES,
            argument(
                "--length",
                type=number(10.0, 1e4),
                metavar="M",
                help="length of the walks in metres; longer where the rooms of a house demand it (default: the usual)",
            ),
            RATE,
            SEGMENTATION,
            FILES,
            SEED,
        ),
    ),
    Action(
        "table2",
        printing(_table2),
        "label accuracy of LEXIS and of Hydra-like rooms that their objects name, as in the paper's Table II",
        "lexis-sim bench table2 --presets uh2-apt uh2-office ori home --houses 5 --seed 500",
        (SEVERAL_PRESETS, HOUSES, FIDELITY, CSV, SEED),
    ),
    Action(
        "table3",
        printing(_table3),
        "trajectory errors of odometry and of LEXIS with each method of place recognition, as in the paper's Table III",
        "lexis-sim bench table3 --presets ori home --houses 5 --seed 500",
        (SEVERAL_PRESETS, HOUSES, FIDELITY, CSV, SEED),
    ),
    Action(
        "fig5",
        printing(_fig5),
        "true and false matches of LEXIS and of other methods of place recognition, as in the paper's Fig. 5",
        "lexis-sim bench fig5 --presets home ori --houses 5 --seed 500 --out places.csv places.png",
        (
            SEVERAL_PRESETS,
            HOUSES,
            argument(
                "--length",
                type=number(10.0, 1e4),
                default=250.0,
                help="length of the walks in metres; longer where the rooms of a house demand it (default: %(default)s)",
            ),
            RATE,
            PLACE_METHOD,
            FILES,
            argument(
                "--tune",
                action="store_true",
                help="find the best settings and least scores of all methods on these walks instead, or with --place-method "
                "only the least scores of these methods",
            ),
            SEED,
        ),
    ),
    Action(
        "place-recognition",
        printing(_places),
        "loop candidates by the method of the paper, by similarity alone and by the probability of a revisit",
        "lexis-sim bench place-recognition --presets home ori --houses 5 --seed 900",
        (
            SEVERAL_PRESETS,
            HOUSES,
            FIDELITY,
            argument("--fit", action="store_true", help="also fit the probability of a revisit to these walks"),
            SEED,
        ),
    ),
)
