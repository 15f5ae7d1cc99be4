"""`figure_table`: the medians of the most important figures in each part of a suite, as text."""

from collections.abc import Sequence

import numpy as np

from sim.harness.results import RunResult
from sim.suites.report import SuiteReport

COLUMNS = (
    *("labels.accuracy", "rooms.pq", "floors.accuracy", "loops.recall", "loops.precision"),
    *("trajectory.ate_m", "trajectory.ate_odometry_m"),
)
"""The figures that have a column in the table."""


def figure_table(report: SuiteReport) -> str:
    """Return one line for each part with the medians of `COLUMNS` over its completed runs.

    A figure that no run of the part has, such as one about labels that the SLAM does not estimate, is shown as "-".
    """
    parts = {part.name: [each.result for each in report.examined if each.part == part.name] for part in report.suite.parts}
    completed = {name: [result for result in results if result is not None] for name, results in parts.items()}
    width = max(map(len, ["medians of", *parts]))
    head = f"{'medians of':{width}}  runs  " + "  ".join(COLUMNS)
    rows = (
        f"{name:{width}}  {len(results):4}  " + "  ".join(f"{_median(results, f):>{len(f)}}" for f in COLUMNS)
        for name, results in completed.items()
    )
    return "\n".join([head, *rows])


def _median(results: Sequence[RunResult], figure: str) -> str:
    values = [value for result in results if (value := result[figure]) is not None]
    return f"{np.median(values):.3f}" if values else "-"
