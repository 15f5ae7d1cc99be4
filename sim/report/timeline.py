"""Draws a run over time: strips of true, baseline and refined labels, then wrong labels, position errors and loop edges."""

from collections.abc import Iterator, Mapping, Sequence
from html import escape

import numpy as np
from jaxtyping import Float, Float64, Int

from sim.report.data import ReportData
from sim.report.palette import estimated_room_colours
from sim.report.room_errors import numbered_rooms

WIDTH = 1000.0
LEFT = 84.0
_STRIP, _GAP, _CHART = 20.0, 4.0, 110.0
_CHART_TOP = 4 * (_STRIP + _GAP) + 14
_LOOPS_TOP = _CHART_TOP + _CHART + 12
_HEIGHT = _LOOPS_TOP + 52


def timeline_svg(data: ReportData, colours: Mapping[str, str]) -> str:
    """Draw the timeline as an `<svg>` element. Its styles are in the report's page. `colours` maps labels to colours."""
    table = data.keyframes
    edges = _edges(table.stamps)
    rows = {"true room": table.true_labels}
    if table.is_labelled_before:
        rows["image alone"] = table.baseline_labels
    if table.is_labelled:
        rows["refined" if table.is_labelled_before else "estimated"] = table.predicted_labels
    body: list[str] = []
    for i, (name, labels) in enumerate(rows.items()):
        body += _strip(i * (_STRIP + _GAP), name, labels, data.shown_labels, edges, colours)
    if rooms := estimated_room_colours(table):
        names, indices = numbered_rooms(table.predicted_rooms)
        body += _strip(len(rows) * (_STRIP + _GAP), "estimated", indices, names, edges, rooms)
    if table.is_labelled:
        body += _wrong(3 * (_STRIP + _GAP), edges, data)
    body += _error_chart(data)
    body += _loop_ticks(data)
    body += _time_axis(data)
    body.append(f'<line id="cursor" y1="0" y2="{_HEIGHT - 18}" x1="-9" x2="-9"/>')
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" id="timeline" role="img" aria-label="labels and errors over time" '
        f'viewBox="0 0 {WIDTH:.0f} {_HEIGHT:.0f}">' + "\n".join(body) + "</svg>"
    )


def positions(stamps: Float64[np.ndarray, "n"]) -> Float64[np.ndarray, "n"]:
    """Return the x coordinates of keyframes with the time stamps `stamps` [s], in the units of the timeline's SVG."""
    span = max(float(stamps[-1] - stamps[0]), 1e-9)
    return np.asarray(LEFT + (stamps - stamps[0]) / span * (WIDTH - LEFT - 6))


def _edges(stamps: Float64[np.ndarray, "n"]) -> Float64[np.ndarray, "n_plus_1"]:
    x = positions(stamps)
    return np.concatenate([x[:1], (x[1:] + x[:-1]) / 2, [WIDTH - 6]])


def _strip(
    y: float, name: str, labels: Int[np.ndarray, "n"], label_names: Sequence[str],
    edges: Float64[np.ndarray, "m"], colours: Mapping[str, str],
) -> Iterator[str]:  # fmt: skip
    yield _row_name(name, y + _STRIP / 2)
    starts = np.concatenate([[0], np.flatnonzero(np.diff(labels)) + 1])
    for start, stop in zip(starts, [*starts[1:], len(labels)], strict=True):
        label = label_names[labels[start]]
        yield (
            f'<rect x="{edges[start]:.1f}" y="{y:.1f}" width="{edges[stop] - edges[start]:.1f}" height="{_STRIP}" '
            f'fill="{colours[label]}"><title>{name}: {escape(label or "none")}</title></rect>'
        )


def _wrong(y: float, edges: Float64[np.ndarray, "m"], data: ReportData) -> Iterator[str]:
    yield _row_name("wrong", y + _STRIP / 2)
    for k in np.flatnonzero(data.keyframes.wrong):
        width = edges[k + 1] - edges[k]
        yield f'<rect class="bad" x="{edges[k]:.1f}" y="{y:.1f}" width="{width:.1f}" height="{_STRIP / 2}"/>'


def _error_chart(data: ReportData) -> Iterator[str]:
    table = data.keyframes
    x, top = positions(table.stamps), _nice_ceiling(max(table.odometry_errors.max(), table.estimated_errors.max(), 0.1))
    for fraction in (0.0, 0.5, 1.0):
        y = _CHART_TOP + _CHART * (1 - fraction)
        yield f'<line class="grid" x1="{LEFT}" x2="{WIDTH - 6}" y1="{y:.1f}" y2="{y:.1f}"/>'
        yield f'<text class="tick" x="{LEFT - 8}" y="{y + 4:.1f}" text-anchor="end">{fraction * top:g} m</text>'
    curves = {"odometry": table.odometry_errors, "estimated": table.estimated_errors}
    for name, errors in curves.items():
        if name == "estimated" and not data.estimates_poses:
            continue
        points = _points(x, _CHART_TOP + _CHART * (1 - errors / top))
        yield f'<polyline class="error-{name}" points="{points}"><title>position error, {name}</title></polyline>'


def _loop_ticks(data: ReportData) -> Iterator[str]:
    """Yield a tick at the later keyframe of each loop edge: true edges in the upper row, false edges in the lower row."""
    if not data.estimates_loops:
        return
    yield _row_name("loops", _LOOPS_TOP + 10)
    x = positions(data.keyframes.stamps)
    for loop in data.loops:
        style, y = ("tick-true", _LOOPS_TOP) if loop.true else ("tick-false", _LOOPS_TOP + 11)
        title = f"<title>keyframe {loop.query} to {loop.match}, weight {loop.weight:.2f}</title>"
        yield f'<rect class="{style}" x="{x[loop.query] - 1:.1f}" y="{y}" width="2" height="10">{title}</rect>'


def _time_axis(data: ReportData) -> Iterator[str]:
    """Yield tick labels with the time since the first keyframe."""
    stamps, x = data.keyframes.stamps, positions(data.keyframes.stamps)
    step = _nice_ceiling((stamps[-1] - stamps[0]) / 8 + 1e-9)
    for seconds in np.arange(0, stamps[-1] - stamps[0], step):
        at = np.interp(stamps[0] + seconds, stamps, x)
        yield f'<text class="tick" x="{at:.1f}" y="{_HEIGHT - 4:.0f}" text-anchor="middle">{seconds:g} s</text>'


def _row_name(name: str, y: float) -> str:
    return f'<text class="tick" x="{LEFT - 8}" y="{y + 4:.1f}" text-anchor="end">{name}</text>'


def _points(x: Float[np.ndarray, "n"], y: Float[np.ndarray, "n"]) -> str:
    return " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(x, y, strict=True))


def _nice_ceiling(value: float) -> float:
    """Return the smallest round number that is at least `value`."""
    power = 10.0 ** np.floor(np.log10(value))
    return float(next(power * step for step in (1, 1.5, 2, 3, 4, 5, 6, 8, 10) if power * step >= value - 1e-12))
