"""Writes the report of a run as one HTML file that can be read offline (`write_report`)."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from string import Formatter
from typing import Any

import jinja2

from lexis.files.replace import replaced_file
from sim.report.confusion import confusion
from sim.report.data import NO_LABEL, UNKNOWN, ReportData, SampleFrame
from sim.report.drawing import Drawing
from sim.report.figures import PLACES, SECTIONS, figure, figures, shown
from sim.report.findings import findings
from sim.report.inline_image import data_uri
from sim.report.loop_candidates import candidate_lists, reason_counts
from sim.report.overlay import describe, run_marks
from sim.report.palette import estimated_room_colours, label_colours, true_room_colours
from sim.report.plan import LETTER_M, plan_drawing
from sim.report.svg import styles_css, to_svg
from sim.report.timeline import LEFT, WIDTH, positions, timeline_svg
from sim.wording import joined

_ENVIRONMENT = jinja2.Environment(
    loader=jinja2.PackageLoader("sim.report"),
    autoescape=True,
    trim_blocks=True,
    lstrip_blocks=True,
    undefined=jinja2.StrictUndefined,
)

_LEAST_PAGE_M, _MOST_PAGE_M = 17.0, 28.0
"""The width of the page shows at least the first length of a house [m], since larger plans would look coarse. Plans stand
side by side only if their total width is at most the second length [m], since the letters on smaller plans could not be
read. The letters on a single plan that is wider are larger."""

_ABOUT = ("slam", "encoder", "odometry", "fidelity")
_HEADLINES = (
    ("walk covered", "coverage", "path_covered", "{rooms_visited} of {rooms} rooms"),
    ("label accuracy", "labels", "accuracy", "{accuracy_baseline} before refinement"),
    ("room quality (PQ)", "rooms", "pq", "splits: {splits}, merges: {merges}"),
    ("floor accuracy", "floors", "accuracy", "error in their number: {count_error}"),
    ("true loop edges", "loops", "true", "{false} false, recall {recall}"),
    ("trajectory (ATE)", "trajectory", "ate_m", "odometry {ate_odometry_m}"),
    ("plans that arrive", "planning", "success", "of {queries}, SPL {spl}"),
)


@dataclass(frozen=True)
class Headline:
    """A figure (measured number) in the header of the page, with its name and a note."""

    name: str
    value: str
    note: str


def write_report(path: Path, data: ReportData) -> None:
    """Write the report to one file, whole or not at all. Raises `LexisError` if the file cannot be written."""
    page = render_report(data)
    with replaced_file(path) as beside:
        beside.write_text(page, encoding="utf-8")


def render_report(data: ReportData) -> str:
    """Render the report as the text of an HTML page."""
    result, estimated = data.result, _without_nulls(data.result)
    colours = label_colours([*data.shown_labels, *(room.label for plan in data.plans for room in plan.rooms)])
    drawings = _drawings(data, colours)
    right, wrong = _samples(data)
    is_labelled = data.keyframes.is_labelled
    return _ENVIRONMENT.get_template("report.html").render(
        result=result,
        name=result.get("preset") or next((plan.house for plan in data.plans if plan.house), "house"),
        about=_about(result),
        headlines=_headlines(result),
        failure=data.failure,
        findings=findings(data),
        plans=[(drawing.title, share, to_svg(drawing)) for drawing, share in zip(drawings, _widths(drawings), strict=True)],
        plan_css=styles_css("figure svg"),
        failed=data.failed,
        colours={name: colours[name] for name in _present(data)},
        estimated_rooms={name or "no room": colour for name, colour in estimated_room_colours(data.keyframes).items()},
        layers=_layers(data),
        estimates_poses=data.estimates_poses,
        timeline=timeline_svg(data, colours),
        is_labelled=is_labelled,
        estimates_loops=data.estimates_loops,
        confusion=confusion(data.keyframes, data.shown_labels) if is_labelled else None,
        right=right,
        wrong=wrong,
        faults_of_images=joined(data.faults_of_images, "and"),
        sections=[(name, figures(estimated, name)) for name in SECTIONS if figures(estimated, name)],
        place_recognition=estimated.get(PLACES) or {},
        reasons=reason_counts(data),
        candidate_lists=candidate_lists(data),
        per_room=(result.get("labels") or {}).get("per_room") or {},
        stages=_stages(result),
        shown=shown,
        script_data=_script_data(data),
    )


def _drawings(data: ReportData, colours: Mapping[str, str]) -> list[Drawing]:
    """Draw every storey and the run on it. A page can show the colours of estimated rooms if there are also labels."""
    room_colours = true_room_colours(data.keyframes) if data.keyframes.is_labelled else {}
    marks = [run_marks(data, plan.level, colours) for plan in data.plans]

    def drawn(letter_m: float) -> list[Drawing]:
        plans = (plan_drawing(plan, colours, room_colours=room_colours, letter_m=letter_m) for plan in data.plans)
        return [plan.with_marks(more) for plan, more in zip(plans, marks, strict=True)]

    drawings = drawn(LETTER_M)
    enlarged = _shown_m(drawings) / _MOST_PAGE_M
    return drawings if enlarged <= 1.0 else drawn(enlarged * LETTER_M)


def _about(result: Mapping[str, Any]) -> list[str]:
    """Return what the first line of the page says about a run: the SLAM, its inputs, and the faults."""
    parts = [f"{key if key != 'slam' else 'SLAM'} {result[key]}" for key in _ABOUT if result.get(key)]
    faults = (result.get("faults") or {}).get("given") or ()
    return [*parts, f"faults {', '.join(faults)}"] if faults else parts


def _without_nulls(result: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
    """Return the sections of result.json without the figures that the run does not have.

    A section about plans is empty if no plan was requested.
    """
    sections = {name: value for name, value in result.items() if isinstance(value, Mapping)}
    if not (sections.get("planning") or {}).get("queries"):
        sections.pop("planning", None)
    return {name: {key: value for key, value in values.items() if not _is_null(value)} for name, values in sections.items()}


def _is_null(value: object) -> bool:
    """Return whether a figure is null. A group of figures is null if it has figures and all of them are null."""
    return value is None or (isinstance(value, Mapping) and bool(value) and all(map(_is_null, value.values())))


def _layers(data: ReportData) -> list[tuple[str, str, bool]]:
    """Return id, name and initial state of each switch that shows or hides a part of the plans.

    There are no switches for what the SLAM does not estimate.
    """
    loops, plans = data.estimates_loops, bool(data.paths)
    every = (
        ("keyframes", "keyframes", True, True),
        ("only-wrong", "only those with a wrong label", False, data.keyframes.is_labelled),
        ("true", "true path", True, True),
        ("odometry", "odometry", True, True),
        ("estimated", "estimated path", True, data.estimates_poses),
        ("loop-true", "true loop edges", True, loops),
        ("loop-false", "false loop edges", True, loops),
        ("plan", "plans that arrived", False, plans),
        ("plan-failed", "plans that failed", True, plans),
        ("furniture", "furniture", True, True),
        ("name", "names", True, True),
    )
    return [(key, name, on) for key, name, on, is_estimated in every if is_estimated]


def _headlines(result: Mapping[str, Any]) -> list[Headline]:
    """Return the headlines, without those of figures that the run does not have."""
    return [
        Headline(name, figure(result, section, key), _note(result, section, note))
        for name, section, key, note in _HEADLINES
        if (result.get(section) or {}).get(key) is not None
    ]


def _note(result: Mapping[str, Any], section: str, form: str) -> str:
    """Return the note of a headline; "" if the run has none of the figures in it."""
    named = [name for _, name, _, _ in Formatter().parse(form) if name]
    known = any((result.get(section) or {}).get(name) is not None for name in named)
    return form.format_map({name: figure(result, section, name) for name in named}) if known else ""


def _widths(drawings: Sequence[Drawing]) -> list[float]:
    """Return the width of each plan as a share of the page's width [%]. All plans have the same scale."""
    metres = _shown_m(drawings)
    return [97 * float(drawing.high[0] - drawing.low[0]) / metres for drawing in drawings]


def _shown_m(drawings: Sequence[Drawing]) -> float:
    """Return the length that the width of the page shows [m].

    Plans stand side by side if they are then large enough to read.
    """
    widths = [float(drawing.high[0] - drawing.low[0]) for drawing in drawings]
    return max(sum(widths) if sum(widths) <= _MOST_PAGE_M else max(widths), _LEAST_PAGE_M)


def _present(data: ReportData) -> list[str]:
    """Return the labels that occur in the floor plans or among the keyframes. The legend shows only these labels."""
    table = data.keyframes
    before = [table.baseline_labels] if table.is_labelled_before else []
    used = {int(i) for rows in (table.true_labels, *before, table.predicted_labels) for i in rows}
    planned = {room.label for plan in data.plans for room in plan.rooms}
    unlabelled = [NO_LABEL] if UNKNOWN in used and table.is_labelled else []
    return list(dict.fromkeys([*(data.label_names[i] for i in sorted(used - {UNKNOWN})), *sorted(planned), *unlabelled]))


def _samples(data: ReportData) -> tuple[list[dict[str, Any]], list[dict[str, Any]]]:
    """Return the template's data on two lists of sample frames: labelled right before refinement, and labelled wrong."""
    cards = [_sample(data, sample) for sample in data.samples]
    return [card for card in cards if card["seen"] == card["true"]], [card for card in cards if card["seen"] != card["true"]]


def _sample(data: ReportData, sample: SampleFrame) -> dict[str, Any]:
    table, names, k = data.keyframes, data.shown_labels, sample.keyframe
    return {
        "keyframe": k,
        "uri": data_uri(sample.image),
        "true": names[table.true_labels[k]],
        "seen": names[table.baseline_labels[k]],
        "refined": names[table.predicted_labels[k]],
        "scores": sample.scores,
    }


def _stages(result: Mapping[str, Any]) -> list[tuple[str, float, float]]:
    """Return name, time [s] and time relative to the slowest stage, for each stage, slowest first."""
    stages: Mapping[str, float] = (result.get("time") or {}).get("stages_s") or {}
    slowest = max([*stages.values(), 1e-9])
    return [(name, seconds, seconds / slowest) for name, seconds in sorted(stages.items(), key=lambda item: -item[1])]


def _script_data(data: ReportData) -> str:
    table = data.keyframes
    content = {
        "x": positions(table.stamps).round(1).tolist(),
        "text": [describe(data, k) for k in range(len(table.stamps))],
        "left": LEFT,
        "width": WIDTH,
    }
    return json.dumps(content, ensure_ascii=False).replace("<", "\\u003c")
