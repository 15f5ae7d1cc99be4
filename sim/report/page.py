"""`write_report`: one HTML file that shows a run and needs no network."""

import json
import os
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import jinja2

from sim.errors import SimError
from sim.report.confusion import confusion
from sim.report.data import ReportData, SampleFrame
from sim.report.figures import SECTIONS, figure, figures, shown
from sim.report.findings import findings
from sim.report.overlay import describe, run_marks
from sim.report.palette import label_colours
from sim.report.plan import plan_drawing
from sim.report.samples import data_uri
from sim.report.svg import styles_css, to_svg
from sim.report.timeline import LEFT, WIDTH, positions, timeline_svg

_ENVIRONMENT = jinja2.Environment(
    loader=jinja2.PackageLoader("sim.report"),
    autoescape=True,
    trim_blocks=True,
    lstrip_blocks=True,
    undefined=jinja2.StrictUndefined,
)

_HEADLINES = (
    ("label accuracy", "labels", "accuracy", "{accuracy_baseline} before refinement"),
    ("room quality (PQ)", "rooms", "pq", "{splits} splits, {merges} merges"),
    ("floor accuracy", "floors", "accuracy", "count error {count_error}"),
    ("true loop edges", "loops", "true", "{false} false, recall {recall}"),
    ("trajectory (ATE)", "trajectory", "ate_m", "odometry {ate_odometry_m}"),
    ("plans that arrive", "planning", "success", "SPL {spl}"),
)


@dataclass(frozen=True)
class Headline:
    """A figure at the top of the page."""

    name: str
    value: str
    note: str


def write_report(path: Path, data: ReportData) -> None:
    """Write the report beside `path` and rename it into place. Raises `SimError` where that is not possible."""
    page = render_report(data)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.NamedTemporaryFile("w", encoding="utf-8", dir=path.parent, suffix=".html", delete=False) as file:
            file.write(page)
        os.chmod(file.name, 0o644)
        os.replace(file.name, path)
    except OSError as error:
        raise SimError(f"{path}: the report cannot be written there: {error.strerror}") from None


def render_report(data: ReportData) -> str:
    """The page as text."""
    result = data.result
    colours = label_colours([*data.label_names, *(room.label for plan in data.plans for room in plan.rooms)])
    drawings = [plan_drawing(plan, colours).with_marks(run_marks(data, plan.level, colours)) for plan in data.plans]
    right, wrong = _samples(data)
    return _ENVIRONMENT.get_template("report.html").render(
        result=result,
        headlines=_headlines(result),
        findings=findings(data),
        plans=[(drawing.title, to_svg(drawing)) for drawing in drawings],
        plan_css=styles_css("figure svg"),
        colours={name: colours[name] for name in _present(data)},
        timeline=timeline_svg(data, colours),
        confusion=confusion(data.keyframes, data.label_names),
        right=right,
        wrong=wrong,
        sections=[(name, figures(result, name)) for name in SECTIONS if figures(result, name)],
        place_recognition=result.get("place_recognition") or {},
        per_room=(result.get("labels") or {}).get("per_room") or {},
        stages=_stages(result),
        shown=shown,
        script_data=_script_data(data),
    )


def _headlines(result: Mapping[str, Any]) -> list[Headline]:
    return [
        Headline(
            name, figure(result, section, key), note.format_map({k: figure(result, section, k) for k in SECTIONS[section]})
        )
        for name, section, key, note in _HEADLINES
    ]


def _present(data: ReportData) -> list[str]:
    """The labels that occur in the plan or in the keyframes."""
    table = data.keyframes
    used = {int(i) for rows in (table.true_labels, table.baseline_labels, table.predicted_labels) for i in rows}
    planned = {room.label for plan in data.plans for room in plan.rooms}
    return list(dict.fromkeys([*(data.label_names[i] for i in sorted(used)), *sorted(planned)]))


def _samples(data: ReportData) -> tuple[list[dict[str, Any]], list[dict[str, Any]]]:
    cards = [_sample(data, sample) for sample in data.samples]
    return [card for card in cards if not card["wrong"]], [card for card in cards if card["wrong"]]


def _sample(data: ReportData, sample: SampleFrame) -> dict[str, Any]:
    table, k = data.keyframes, sample.keyframe
    return {
        "keyframe": k,
        "uri": data_uri(sample.image),
        "wrong": bool(table.wrong[k]),
        "true": data.label_names[table.true_labels[k]],
        "said": data.label_names[table.predicted_labels[k]],
        "baseline": data.label_names[table.baseline_labels[k]],
        "scores": sample.scores[:3],
    }


def _stages(result: Mapping[str, Any]) -> list[tuple[str, float, float]]:
    """Name, seconds and share of the slowest, slowest first."""
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
