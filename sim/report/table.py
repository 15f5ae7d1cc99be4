"""The result of a run as a terminal table."""

from collections.abc import Mapping
from typing import Any

from rich.box import SIMPLE_HEAD
from rich.markup import escape
from rich.table import Table

from sim.report.figures import SECTIONS, figures


def result_table(result: Mapping[str, Any], house: str | None = None, meanings: bool = True) -> Table:
    """A rich table with every figure of a result.json, and its meaning beside it, for `rich.console.Console.print`.

    `house` is the name of a house that is of no preset.
    """
    title = "house {house}, seed {seed}: {encoder} encoder, {odometry} odometry, {fidelity}".format_map(
        _Absent({**result, "house": result.get("preset") or house or "?"})
    )
    table = Table("", "figure", title=escape(title), box=SIMPLE_HEAD, title_justify="left", title_style="bold")
    table.add_column("value", justify="right", no_wrap=True, style="bold")
    if meanings:
        table.add_column("meaning", style="dim")
    for section in SECTIONS:
        rows = figures(result, section)
        for i, row in enumerate(rows):
            cells = (section if i == 0 else "", row.name, row.value, row.meaning)
            table.add_row(*cells[: len(table.columns)], end_section=i == len(rows) - 1)
    return table


class _Absent(dict[str, Any]):
    """Formats keys that are not there as a question mark."""

    def __missing__(self, key: str) -> str:
        return "?"
