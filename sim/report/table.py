"""Shows the result of a run as a table for the terminal."""

from collections.abc import Mapping
from typing import Any

from rich.box import SIMPLE_HEAD
from rich.table import Table

from sim.report.figures import MISSING, SECTIONS, figures


def result_title(result: Mapping[str, Any], house: str | None = None) -> str:
    """Describe the run in one line. `house` is the name of the house if it was not made from a preset."""
    slam, encoder, seed, odometry, fidelity = (
        result.get(key, "?") for key in ("slam", "encoder", "seed", "odometry", "fidelity")
    )
    by = [] if slam in ("?", "Lexis") else [slam]
    by += [f"{encoder} encoder"] if encoder else []
    about = ", ".join([*by, f"{odometry} odometry", f"{fidelity} fidelity"])
    return f"house {result.get('preset') or house or '?'}, seed {seed}: {about}"


def result_table(result: Mapping[str, Any], meanings: bool = True, nulls: bool = True, keys: bool = False) -> Table:
    """Make a table of the figures of a result.json, for `rich.console.Console.print`.

    `meanings` adds a column that explains the figures. Without `nulls`, figures that are null are left out. With `keys`, the
    first column holds the names of the figures in result.json, such as "rooms.pq"; otherwise, it holds the sections.
    """
    table = Table(box=SIMPLE_HEAD)
    table.add_column("name" if keys else "", no_wrap=keys)
    table.add_column("figure")
    table.add_column("value", justify="right", no_wrap=True, style="bold")
    if meanings:
        table.add_column("meaning", style="dim")
    for section in SECTIONS:
        rows = [row for row in figures(result, section) if nulls or not row.value.startswith(MISSING)]
        for i, row in enumerate(rows):
            first = row.key if keys else section.replace("_", " ") if i == 0 else ""
            cells = (first, row.name, row.value, row.meaning)
            table.add_row(*cells[: len(table.columns)], end_section=i == len(rows) - 1)
    return table
