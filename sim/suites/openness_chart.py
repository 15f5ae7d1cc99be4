"""`openness_chart`: draws room quality against the openness of the house, for a SLAM and for the baselines of the harness.

Every point is the mean over houses of similar openness. Its bar is the confidence interval of Student's t, which assumes
that the mean over the houses is nearly normal; a mean over few houses has no bar, because its interval says nothing.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from html import escape

import numpy as np
from scipy.stats import sem
from scipy.stats import t as student

from sim.harness.adapters import GeometricRooms, OdometryOnly
from sim.harness.results import RunResult
from sim.suites.examination import examinations, jobs_of
from sim.suites.report import SuiteReport
from sim.wording import counted

_FIGURES = {"rooms.pq": "panoptic quality of rooms", "labels.accuracy_graded": "graded label accuracy"}
_COLOURS = ("#1f5fa8", "#c2571a", "#2f8a4a")
_CONFIDENCE = 0.95
"""Confidence of the intervals."""
_FEWEST = 4
"""Least number of houses whose mean has a bar."""
_NOTE = f"Points are means over houses of similar openness; bars are 95 % confidence intervals, from {_FEWEST} houses on."
_WIDTH, _HEIGHT, _LEFT, _TOP, _GAP = 360.0, 260.0, 52.0, 48.0, 70.0
_LEGEND = 220.0
"""Width of an entry of the legend, in the unit of the picture."""
_Series = tuple[str, Sequence[RunResult]]
"""The name of a SLAM, and its results."""
_STEP = 0.25
"""Houses are grouped by their openness, rounded to a multiple of this."""


def openness_chart(report: SuiteReport, workers: int) -> str:
    """Return the chart as the text of an SVG file.

    The baselines are run on the scenarios of the report. They see nothing but the odometry, so nothing is rendered.
    """
    examined = {(each.part, each.number) for each in report.examined}
    jobs = [job for job in jobs_of(report.suite, report.seed) if (job.part.name, job.number) in examined]
    bare = [replace(job, is_bare=True) for job in jobs]
    name = report.results[0].slam if report.results else "no run completed"
    runs: list[_Series] = [(name, report.results)]
    for slam in (GeometricRooms, OdometryOnly):
        if slam.__name__ != name:
            found = [each.result for each in examinations(bare, slam, workers)]
            runs.append((slam.__name__, [result for result in found if result is not None]))
    return _drawn(runs)


def _drawn(runs: Sequence[_Series]) -> str:
    width, height = 2 * (_LEFT + _WIDTH) + _GAP, _TOP + _HEIGHT + 72
    body = [f'<rect width="{width:.0f}" height="{height:.0f}" fill="#ffffff"/>']
    for k, (figure, title) in enumerate(_FIGURES.items()):
        body += _panel(_LEFT + k * (_LEFT + _WIDTH + _GAP / 2), figure, title, runs)
    for k, (name, results) in enumerate(runs):
        x = _LEFT + _LEGEND * k
        nothing = "" if any(_grouped(figure, results) for figure in _FIGURES) else " (estimates neither)"
        body.append(f'<circle cx="{x:.0f}" cy="14" r="5" fill="{_COLOURS[k]}"/>')
        body.append(f'<text x="{x + 10:.0f}" y="18">{escape(name)}{nothing}</text>')
    body.append(f'<text x="{_LEFT:.0f}" y="{height - 10:.0f}" fill="#59626c">{_NOTE}</text>')
    head = f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width:.0f} {height:.0f}" role="img" '
    font = 'aria-label="room quality against openness" font-family="sans-serif" font-size="12">'
    return "\n".join([head + font, *body, "</svg>", ""])


def _panel(x0: float, figure: str, title: str, runs: Sequence[_Series]) -> Iterator[str]:
    yield f'<text x="{x0:.0f}" y="{_TOP - 10:.0f}" font-weight="bold">{title}</text>'
    for value in (0.0, 0.25, 0.5, 0.75, 1.0):
        y, x = _TOP + _HEIGHT * (1 - value), x0 + _WIDTH * value
        yield f'<line x1="{x0:.1f}" x2="{x0 + _WIDTH:.1f}" y1="{y:.1f}" y2="{y:.1f}" stroke="#dddddd"/>'
        yield f'<text x="{x0 - 8:.1f}" y="{y + 4:.1f}" text-anchor="end">{value:g}</text>'
        yield f'<text x="{x:.1f}" y="{_TOP + _HEIGHT + 18:.1f}" text-anchor="middle">{value:g}</text>'
    yield f'<text x="{x0 + _WIDTH / 2:.1f}" y="{_TOP + _HEIGHT + 38:.1f}" text-anchor="middle">openness</text>'
    for colour, shift, (_, results) in zip(_COLOURS, (-4, 0, 4), runs, strict=False):
        yield from _curve(x0 + shift, figure, results, colour)


def _curve(x0: float, figure: str, results: Sequence[RunResult], colour: str) -> Iterator[str]:
    points = []
    for openness, values in _grouped(figure, results).items():
        x, y = x0 + _WIDTH * openness, _TOP + _HEIGHT * (1 - float(np.mean(values)))
        points.append(f"{x:.1f},{y:.1f}")
        mean = f"{openness:g}: {np.mean(values):.3f}"
        if len(values) >= _FEWEST:
            low, high = _interval(values)
            top, bottom = _TOP + _HEIGHT * (1 - high), _TOP + _HEIGHT * (1 - low)
            yield f'<line x1="{x:.1f}" x2="{x:.1f}" y1="{top:.1f}" y2="{bottom:.1f}" stroke="{colour}" stroke-width="1.5"/>'
            mean += f" ({low:.3f} to {high:.3f})"
        mean += f", {counted(len(values), 'house')}"
        yield f'<circle cx="{x:.1f}" cy="{y:.1f}" r="4" fill="{colour}"><title>{mean}</title></circle>'
    if points:
        yield f'<polyline points="{" ".join(points)}" fill="none" stroke="{colour}" stroke-width="2"/>'


def _grouped(figure: str, results: Sequence[RunResult]) -> dict[float, list[float]]:
    """Return the values of a figure by openness, in ascending order; results without the figure are left out."""
    groups: dict[float, list[float]] = {}
    for result in sorted(results, key=lambda each: each.house.openness):
        if result[figure] is not None:
            groups.setdefault(_STEP * round(result.house.openness / _STEP), []).append(result[figure])
    return groups


def _interval(values: Sequence[float]) -> tuple[float, float]:
    """Return the confidence interval of the mean of two or more figures in [0, 1], cut off at 0 and 1."""
    if np.ptp(values) == 0.0:
        return float(np.mean(values)), float(np.mean(values))
    low, high = student.interval(_CONFIDENCE, len(values) - 1, np.mean(values), sem(values))
    return max(0.0, float(low)), min(1.0, float(high))
