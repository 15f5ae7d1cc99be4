"""Draws a run over time: strips of labels, wrong labels and rooms, then position errors and loop edges."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from html import escape

import numpy as np
from jaxtyping import Float, Float64, Int

from sim.report.data import KeyframeTable, ReportData
from sim.report.palette import estimated_room_colours, true_room_colours
from sim.report.room_errors import numbered_rooms

WIDTH = 1000.0
LEFT = 108.0
_STRIP, _GAP, _CHART = 20.0, 4.0, 110.0
_LOOPS_TOP = _CHART + 12
_BELOW = _LOOPS_TOP + 52
"""Height of the part below the strips, which begins with the chart of position errors."""


def timeline_svg(data: ReportData, colours: Mapping[str, str]) -> str:
    """Draw the timeline as an `<svg>` element. Its styles are in the report's page. `colours` maps labels to colours."""
    strips = [*_label_strips(data, colours), *_room_strips(data.keyframes)]
    top = len(strips) * (_STRIP + _GAP) + 14
    body = [_moved(i * (_STRIP + _GAP), strip) for i, strip in enumerate(strips)]
    body.append(_moved(top, [*_error_chart(data), *_loop_ticks(data), *_time_axis(data)]))
    body.append(f'<line id="cursor" y1="0" y2="{top + _BELOW - 18}" x1="-9" x2="-9"/>')
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" id="timeline" role="img" aria-label="labels, rooms and errors over time" '
        f'viewBox="0 0 {WIDTH:.0f} {top + _BELOW:.0f}">' + "\n".join(body) + "</svg>"
    )


def _label_strips(data: ReportData, colours: Mapping[str, str]) -> Iterator[Iterator[str]]:
    """Yield the elements of each strip about labels: true labels, estimated ones, and which of them are wrong."""
    table, edges = data.keyframes, _edges(data.keyframes.stamps)
    rows = {"true label": table.true_labels}
    if table.is_labelled_before:
        rows["image alone"] = table.baseline_labels
    if table.is_labelled:
        rows["refined" if table.is_labelled_before else "estimated label"] = table.predicted_labels
    for name, labels in rows.items():
        yield _strip(name, labels, data.shown_labels, edges, colours)
    if table.is_labelled:
        yield _wrong(edges, data)


def _room_strips(table: KeyframeTable) -> Iterator[Iterator[str]]:
    """Yield the elements of the strips of true and estimated rooms, which have the same colour where they match."""
    if not table.has_rooms:
        return
    for name, rooms, colours in (
        ("true room", table.true_rooms, true_room_colours(table)),
        ("estimated room", table.predicted_rooms, estimated_room_colours(table)),
    ):
        names, indices = numbered_rooms(rooms)
        yield _strip(name, indices, names, _edges(table.stamps), colours)


def _moved(y: float, elements: Iterable[str]) -> str:
    """Return elements that are drawn from y = 0 as a group that begins at `y`."""
    return f'<g transform="translate(0 {y:g})">' + "\n".join(elements) + "</g>"


def positions(stamps: Float64[np.ndarray, "n"]) -> Float64[np.ndarray, "n"]:
    """Return the x coordinates of keyframes with the time stamps `stamps` [s], in the units of the timeline's SVG."""
    span = max(float(stamps[-1] - stamps[0]), 1e-9)
    return np.asarray(LEFT + (stamps - stamps[0]) / span * (WIDTH - LEFT - 6))


def _edges(stamps: Float64[np.ndarray, "n"]) -> Float64[np.ndarray, "n_plus_1"]:
    x = positions(stamps)
    return np.concatenate([x[:1], (x[1:] + x[:-1]) / 2, [WIDTH - 6]])


def _strip(
    name: str, labels: Int[np.ndarray, "n"], label_names: Sequence[str],
    edges: Float64[np.ndarray, "m"], colours: Mapping[str, str],
) -> Iterator[str]:  # fmt: skip
    yield _row_name(name, _STRIP / 2)
    starts = np.concatenate([[0], np.flatnonzero(np.diff(labels)) + 1])
    for start, stop in zip(starts, [*starts[1:], len(labels)], strict=True):
        label = label_names[labels[start]]
        yield (
            f'<rect x="{edges[start]:.1f}" width="{edges[stop] - edges[start]:.1f}" height="{_STRIP}" '
            f'fill="{colours[label]}"><title>{name}: {escape(label or "none")}</title></rect>'
        )


def _wrong(edges: Float64[np.ndarray, "m"], data: ReportData) -> Iterator[str]:
    yield _row_name("wrong", _STRIP / 2)
    for k in np.flatnonzero(data.keyframes.wrong):
        width = edges[k + 1] - edges[k]
        yield f'<rect class="bad" x="{edges[k]:.1f}" y="{_STRIP / 4}" width="{width:.1f}" height="{_STRIP / 2}"/>'


def _error_chart(data: ReportData) -> Iterator[str]:
    table = data.keyframes
    x, top = positions(table.stamps), _nice_ceiling(max(table.odometry_errors.max(), table.estimated_errors.max(), 0.1))
    for fraction in (0.0, 0.5, 1.0):
        y = _CHART * (1 - fraction)
        yield f'<line class="grid" x1="{LEFT}" x2="{WIDTH - 6}" y1="{y:.1f}" y2="{y:.1f}"/>'
        yield f'<text class="tick" x="{LEFT - 8}" y="{y + 4:.1f}" text-anchor="end">{fraction * top:g} m</text>'
    curves = {"odometry": table.odometry_errors, "estimated": table.estimated_errors}
    for name, errors in curves.items():
        if name == "estimated" and not data.estimates_poses:
            continue
        points = _points(x, _CHART * (1 - errors / top))
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
        yield f'<text class="tick" x="{at:.1f}" y="{_BELOW - 4:.0f}" text-anchor="middle">{seconds:g} s</text>'


def _row_name(name: str, y: float) -> str:
    return f'<text class="tick" x="{LEFT - 8}" y="{y + 4:.1f}" text-anchor="end">{name}</text>'


def _points(x: Float[np.ndarray, "n"], y: Float[np.ndarray, "n"]) -> str:
    return " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(x, y, strict=True))


def _nice_ceiling(value: float) -> float:
    """Return the smallest round number that is at least `value`."""
    power = 10.0 ** np.floor(np.log10(value))
    return float(next(power * step for step in (1, 1.5, 2, 3, 4, 5, 6, 8, 10) if power * step >= value - 1e-12))
