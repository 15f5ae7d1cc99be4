"""Writes the rows of `lexis-sim bench fig5` as CSV, or draws counts of matches like the paper's Fig. 5, and precision."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from sim.bench.peers.place_figures import REQUIRED, PlaceFigures
from sim.bench.peers.place_methods import PlaceTotal, totals
from sim.bench.row_files import is_picture, picture, write_rows

_COLOURS = 10
"""Number of different colours of matplotlib. The curves of further methods repeat the colours in dashed lines."""


def write_places(found: Sequence[PlaceFigures], path: Path) -> None:
    """Write one row per walk and method as CSV, or draw them, as the ending of the path says.

    Raises `SimError` without matplotlib.
    """
    if is_picture(path):
        draw_places(totals(found), path)
    else:
        write_rows([each.row for each in found], path)


def draw_places(found: Mapping[str, Mapping[str, PlaceTotal]], path: Path) -> None:
    """Draw a row of panels for each preset: true and false matches at N = 1, 3 and 5, and precision against recall."""
    with picture(path, (13.0, 4.2 * len(found))) as figure:
        grid = figure.subplots(len(found), 2, squeeze=False)
        for (bars, lines), (preset, methods) in zip(grid, found.items(), strict=True):
            colours = {name: f"C{number}" for number, name in enumerate(methods)}
            _draw_matches(bars, methods, colours)
            bars.set(title=f"{preset}: true matches (above) and false matches (below)", ylabel="queries")
            for number, (name, total) in enumerate(methods.items()):
                style = {"color": colours[name], "linestyle": "-" if number < _COLOURS else "--"}
                lines.plot(total.curve.recall, total.curve.precision, label=name, **style)
            lines.set(title=f"{preset}: best matches", xlabel="recall", ylabel="precision", xlim=(0, 1), ylim=(0, 1.02))
            lines.grid(alpha=0.25)
        figure.legend(*grid[0][1].get_legend_handles_labels(), loc="outside right center")


def _draw_matches(axes: Any, methods: Mapping[str, PlaceTotal], colours: Mapping[str, str]) -> None:
    """Draw a group of bars for each N: true matches upwards, false matches downwards."""
    width = 0.8 / len(methods)
    for number, (name, total) in enumerate(methods.items()):
        places = np.arange(len(REQUIRED)) + (number - (len(methods) - 1) / 2) * width
        axes.bar(places, [each.tp for each in total.counts], width, color=colours[name])
        axes.bar(places, [-each.fp for each in total.counts], width, color=colours[name], alpha=0.45)
    for group, each in enumerate(next(iter(methods.values())).counts):
        axes.hlines(each.possible, group - 0.45, group + 0.45, color="black", linewidth=1.0)
    axes.axhline(0.0, color="black", linewidth=0.8)
    axes.set_xticks(range(len(REQUIRED)), [f"N = {n}" for n in REQUIRED])
    axes.grid(axis="y", alpha=0.25)
