"""The figures of result.json: each has a definition, and a missing one is shown as a dash, never as zero."""

import io
from dataclasses import is_dataclass
from types import UnionType
from typing import get_args, get_type_hints

import pytest
from rich.console import Console

from sim.harness.claims import Claim
from sim.harness.results import RunResult
from sim.report.figures import MISSING, SECTIONS, figures, shown
from sim.report.table import result_table, result_title

CONTRACT = {
    "coverage": ["rooms_visited", "rooms", "path_covered"],
    "labels": ["accuracy", "accuracy_baseline", "accuracy_graded"],
    "rooms": [
        "pq",
        "precision",
        "recall",
        "hydra_precision",
        "hydra_recall",
        "ari",
        "v_measure",
        "splits",
        "merges",
        "count_error",
    ],
    "floors": ["accuracy", "count_error"],
    "loops": ["proposed", "verified", "true", "false", "precision", "recall", "error_m", "error_rad"],
    "place_recognition": [],
    "trajectory": ["ate_odometry_m", "ate_m", "rpe_8m_odometry_m", "rpe_8m_m", "rpe_24m_odometry_m", "rpe_24m_m"],
    "planning": ["queries", "success", "spl", "collisions"],
    "run": ["path_m", "duration_s", "frames", "keyframes"],
    "house": ["rooms", "floors", "area_m2", "openness"],
    "time": ["house_s", "scene_s", "render_s", "start_s", "slam_s", "realtime_factor"],
}


def test_every_figure_of_the_contract_is_defined():
    assert {section: list(known) for section, known in SECTIONS.items()} == CONTRACT


def test_every_number_of_a_result_has_a_name_and_a_meaning():
    for section, kind in get_type_hints(RunResult).items():
        numbers = {
            name: SECTIONS.get(section, {}).get(name)
            for name, hint in (get_type_hints(kind) if is_dataclass(kind) else {}).items()
            if {int, float} & {hint, *(get_args(hint) if isinstance(hint, UnionType) else ())}
        }
        undefined = [name for name, definition in numbers.items() if definition is None]
        assert not undefined, f"{section}: add a Definition to SECTIONS in sim/report/figures.py for {undefined}"


@pytest.mark.parametrize(
    ("value", "form", "text"),
    [
        (0.5, "{:.1%}", "50.0%"),
        (None, "{:.1%}", MISSING),
        (0, "{:+d}", "0"),
        (-2, "{:+d}", "-2"),
        (0.123456, "{}", "0.1235"),
        (99.994, "{:.2f} ×", "99.99 ×"),
        (128039.1, "{:.2f} ×", "128,039 ×"),
    ],
)
def test_figures_are_formatted_as_declared(value, form, text):
    assert shown(value, form) == text


def test_unknown_figures_are_shown_by_their_key_and_groups_are_left_out():
    rows = figures({"trajectory": {"drift_per_m": 0.1, "ate_m": None, "segments": {"a": 1}}}, "trajectory")
    assert [(row.name, row.value) for row in rows] == [("ATE", MISSING), ("drift per m", "0.1")]


@pytest.mark.parametrize(("preset", "name"), [("home", "home"), (None, "my [old] house")])
def test_a_house_of_no_preset_goes_by_its_name(preset, name):
    assert result_title({"preset": preset, "seed": 3}, "my [old] house").startswith(f"house {name}, seed 3: ? encoder, ")


def test_figures_that_are_null_can_be_left_out():
    console = Console(width=140, record=True, file=io.StringIO())
    nothing = {"loops": {"precision": None}, "place_recognition": {"3": {"tp": None, "possible": None}}}
    console.print(result_table(nothing | {"rooms": {"pq": 0.5}}, nulls=False))
    text = console.export_text()
    assert "panoptic quality" in text and MISSING not in text


def test_the_names_of_figures_are_those_of_conditions():
    console = Console(width=80, record=True, file=io.StringIO())
    figures_of_a_run = {section: dict.fromkeys(known, 0) for section, known in CONTRACT.items()}
    figures_of_a_run["place_recognition"] = {"3": {"tp": 17, "fp": 150, "possible": 20}}
    console.print(result_table(figures_of_a_run, meanings=False, keys=True))
    named = [line.split()[0] for line in console.export_text().splitlines() if "." in line]
    assert {"rooms.pq", "trajectory.rpe_24m_odometry_m", "place_recognition.3.tp"} <= set(named)
    assert len(named) == sum(map(len, CONTRACT.values())) + 1
    assert [str(Claim.parse(f"{name} < 1")) for name in named] == [f"{name} < 1" for name in named]


def test_the_table_holds_every_figure():
    console = Console(width=140, record=True, file=io.StringIO())
    places = {"3": {"tp": 17, "fp": 150, "possible": 20}}
    console.print(result_table({"labels": {"accuracy": 0.75}, "loops": {"precision": None}, "place_recognition": places}))
    text = console.export_text()
    assert "found, N = 3" in text and "17 of 20" in text
    assert "75.0%" in text
    assert MISSING in text
