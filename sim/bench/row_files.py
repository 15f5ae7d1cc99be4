"""Writes the rows of a benchmark as a CSV file, and curves with error bars as a picture."""

import csv
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from lexis.files.replace import replaced_file
from sim.bench.encoders.table import import_matplotlib
from sim.errors import SimError

FORMATS = (".png", ".svg")
"""Allowed endings of the names of pictures."""
Curve = Sequence[tuple[float, float, float]]
"""Points of a curve: x, y, and the standard deviation of y."""


def write_rows(rows: Sequence[Any], path: Path) -> None:
    """Write dataclasses of one type to a CSV file: a line with the names of the fields, then a line for each dataclass."""
    records = [asdict(row) for row in rows]
    with replaced_file(path) as beside, beside.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, list(records[0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows(records)


def check_picture(path: Path) -> None:
    """Raise `SimError` unless `draw_panels` can write to this path. Call this before a measurement that takes minutes."""
    if path.suffix not in FORMATS:
        raise SimError(f"{path}: not a picture; valid: a name that ends in {' or '.join(FORMATS)}")
    check_folder(path)
    import_matplotlib()


def check_folder(path: Path) -> None:
    """Raise `SimError` unless the folder of a file exists."""
    if not path.parent.is_dir():
        raise SimError(f"{path}: no folder {path.parent}; valid: a file in a folder that exists")


def draw_panels(
    panels: Sequence[Sequence[tuple[str, Mapping[str, Curve]]]], axes_names: tuple[str, Sequence[str]], path: Path
) -> None:
    """Draw a grid of panels as PNG or SVG; the ending of the path decides which.

    Args:
        panels: for every row and column, the title of the panel and its curves by name.
        axes_names: the name of the x axis, and the name of the y axis for every row.
        path: the picture.

    Raises `SimError` if matplotlib is not installed.
    """
    rows, columns = len(panels), len(panels[0])
    size = (3.6 * columns, 2.9 * rows)
    figure = import_matplotlib().figure.Figure(figsize=size, layout="constrained")
    grid = figure.subplots(rows, columns, squeeze=False, sharex=True, sharey="row")
    for row, y_name, panel_row in zip(grid, axes_names[1], panels, strict=True):
        row[0].set_ylabel(y_name)
        for axes, (title, curves) in zip(row, panel_row, strict=True):
            for name, curve in curves.items():
                x, y, spread = zip(*curve, strict=True)
                axes.errorbar(x, y, spread, marker="o", markersize=3, capsize=2, label=name)
            axes.set_title(title)
            axes.grid(alpha=0.25)
    for axes in grid[-1]:
        axes.set_xlabel(axes_names[0])
    grid[0][0].legend()
    with replaced_file(path) as beside:
        figure.savefig(beside, format=path.suffix[1:], dpi=150)
