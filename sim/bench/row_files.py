"""Groups and averages the rows of a benchmark, and writes them as a CSV file and curves with error bars as a picture."""

import csv
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from lexis.files.replace import replaced_file
from sim.errors import SimError
from sim.output_files import check_ending, check_output_file

_Row = TypeVar("_Row")
PICTURES = (".png", ".svg")
"""Endings of the names of pictures."""
Curve = Sequence[tuple[float, float, float]]
"""Points of a curve: x, y, and half the length of the error bar of y."""


def grouped(rows: Iterable[_Row], *names: str) -> dict[tuple[Any, ...], list[_Row]]:
    """Return the rows by their values of the named fields, in the order in which the values first occur."""
    found: dict[tuple[Any, ...], list[_Row]] = {}
    for row in rows:
        found.setdefault(tuple(getattr(row, name) for name in names), []).append(row)
    return found


def mean_and_std(figures: Iterable[float | None]) -> tuple[float | None, float | None]:
    """Return the mean and the standard deviation of one figure over several runs.

    A figure that a run does not have (None) is left out. If no run has the figure, the mean is None; if fewer than two have
    it, the standard deviation is None, because a single figure has no spread.
    """
    known = [figure for figure in figures if figure is not None]
    return float(np.mean(known)) if known else None, float(np.std(known)) if len(known) > 1 else None


def write_rows(rows: Sequence[Any], path: Path) -> None:
    """Write dataclasses of one type to a CSV file: a line with the names of the fields, then a line for each dataclass.

    Raises `SimError` without a row, because the names are then unknown.
    """
    if not rows:
        raise SimError(f"{path}: there are no rows to write; valid: a benchmark of one house or more")
    write_records([asdict(row) for row in rows], path)


def write_records(records: Sequence[Mapping[str, object]], path: Path) -> None:
    """Write records to a CSV file: a line with all names, in the order of first occurrence, then a line for each record.

    A record without one of the names has an empty cell.
    """
    names = dict.fromkeys(name for record in records for name in record)
    with replaced_file(path) as beside, beside.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, list(names), lineterminator="\n")
        writer.writeheader()
        writer.writerows(records)


def check_files(*paths: Path | None, valid: Sequence[str] = (".csv", *PICTURES)) -> None:
    """Check the files that a benchmark will write, before minutes of work; None stands for no file.

    Raises `SimError` for a file in a folder that does not exist, for a folder in place of a file, and for an ending that is
    not in `valid`; also for a picture if matplotlib is not installed.
    """
    for path in paths:
        if path is None:
            continue
        check_output_file(path)
        check_ending(path, valid)
        if is_picture(path):
            import_matplotlib()


def is_picture(path: Path) -> bool:
    """Return whether the ending of a file's name is that of a picture, and not that of a CSV file."""
    return path.suffix.lower() in PICTURES


@contextmanager
def picture(path: Path, size: tuple[float, float]) -> Iterator[Any]:
    """Yield a matplotlib figure of the given width and height [inches]; it is written to `path` when the block ends.

    The ending of the path chooses PNG or SVG. Equal drawings give equal files. Raises `SimError` if matplotlib is not
    installed.
    """
    matplotlib = import_matplotlib()
    with matplotlib.rc_context({"svg.hashsalt": "lexis"}):
        figure = matplotlib.figure.Figure(figsize=size, layout="constrained")
        yield figure
        metadata = {"Date": None} if path.suffix.lower() == ".svg" else None
        with replaced_file(path) as beside:
            figure.savefig(beside, format=path.suffix[1:].lower(), dpi=110, metadata=metadata)


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
    with picture(path, (3.6 * columns, 2.9 * rows)) as figure:
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
        for axes, (_, curves) in zip(grid[0], panels[0], strict=True):
            if axes is grid[0][0] or curves.keys() != panels[0][0][1].keys():
                axes.legend(fontsize="small")


def import_matplotlib() -> Any:
    """Import matplotlib. Raises `SimError` if it is not installed."""
    try:
        import matplotlib.figure
    except ImportError:
        raise SimError("plots need matplotlib; valid: an environment with the group 'tests', or a CSV instead") from None
    return matplotlib
