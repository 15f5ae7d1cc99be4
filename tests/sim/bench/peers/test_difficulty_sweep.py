"""A sweep changes one property of the runs, writes a row for each method, house and value, and averages over houses."""

import csv
from dataclasses import replace

import pytest

from sim.bench.peers import difficulty_sweep as module
from sim.bench.peers.difficulty_sweep import DIFFICULTIES, METHODS, SweepMean, SweepRow, means, sweep, write_sweep
from sim.harness import Scenario
from sim.harness.adapters import GeometricRooms, Lexis, OdometryOnly
from sim.harness.run_settings import house_spec, tour_config


def test_every_method_finds_rooms_in_the_same_house(monkeypatch):
    monkeypatch.setattr(module, "METHODS", {name: METHODS[name] for name in ("positions alone", "Voronoi")})
    closed = replace(DIFFICULTIES["openness"], values=(0.0,), methods=("positions alone", "Voronoi"))
    rows = list(sweep("home", (901,), closed))
    assert [row.method for row in rows] == ["positions alone", "Voronoi"]
    assert rows[1].pq > rows[0].pq and [row.labels for row in rows] == [None, None]


@pytest.mark.parametrize(("name", "asked", "rate_hz"), [("light", None, 10.0), ("light", 5.0, 5.0), ("clutter", None, 2.0)])
def test_a_sweep_has_the_frame_rate_that_is_asked_for_or_the_usual_one(name, asked, rate_hz, monkeypatch):
    scenarios = []
    monkeypatch.setattr(module, "run_side_by_side", lambda scenario, slams: scenarios.append(scenario) or {})
    assert not list(sweep("home", (901, 902), DIFFICULTIES[name], rate_hz=asked))
    assert len(scenarios) == 2 * len(DIFFICULTIES[name].values)
    assert {scenario.frame_rate_hz for scenario in scenarios} == {rate_hz}


@pytest.mark.parametrize("name", sorted(set(DIFFICULTIES) - {"spacing"}))
def test_a_difficulty_changes_the_run_and_nothing_else(name):
    difficulty, usual = DIFFICULTIES[name], Scenario(preset="home", seed=901)
    runs = [difficulty.changed(usual, value) for value in difficulty.values]
    assert len(set(map(repr, runs))) == len(runs) and len(difficulty.values) >= 3
    length_m = tour_config(usual).length_m
    assert {tour_config(run).length_m for run in runs} == {length_m}
    assert all(replace(run, house=usual.house, odometry=usual.odometry, length_m=usual.length_m) == usual for run in runs)
    assert name == "odometry" or {run.odometry for run in runs} == {usual.odometry}
    assert set(difficulty.methods) <= set(METHODS)
    plans = {tuple(room.polygon_m for storey in house_spec(run).storeys for room in storey.rooms) for run in runs}
    assert len(plans) == 1


def test_the_spacing_of_keyframes_is_a_setting_of_lexis_and_nothing_else_changes():
    spacing, usual = DIFFICULTIES["spacing"], Scenario(preset="home", seed=901)
    for value in spacing.values:
        assert spacing.changed(usual, value) == usual
        for name in spacing.methods:
            made = METHODS[name](usual)
            adjusted = spacing.adjusted(made, value)
            assert isinstance(made, Lexis) and isinstance(adjusted, Lexis)
            assert adjusted.config.keyframes.spacing_m == value and len(spacing.values) >= 3
            assert replace(adjusted.config, keyframes=made.config.keyframes) == made.config
    assert spacing.adjusted(other := GeometricRooms(), 1.0) is other


def test_means_are_over_the_houses_of_a_method_at_one_value():
    rows = [
        SweepRow("home", "features", "a", 0.0, 1, 0.9, 0.4, 2, 0),
        SweepRow("home", "features", "a", 0.0, 2, 0.7, 0.6, 0, 1),
        SweepRow("home", "features", "b", 0.0, 1, None, 1.0, 0, 0),
    ]
    found = means(rows)["a"][0.0]
    assert (found.pq, found.splits, found.merges) == (0.5, 1.0, 0.5) and found.pq_std == pytest.approx(0.1)
    assert found.labels == pytest.approx(0.8) and means(rows)["b"][0.0].labels is None


def test_figures_of_rooms_that_a_run_does_not_have_are_left_out_of_the_means():
    rows = [
        SweepRow("home", "features", "a", 0.0, 1, None, 0.4, 2, 0),
        SweepRow("home", "features", "a", 0.0, 2, None, None, None, None),
        SweepRow("home", "features", "b", 0.0, 1, None, None, None, None),
    ]
    assert means(rows) == {
        "a": {0.0: SweepMean(None, 0.4, None, 2.0, 0.0)},
        "b": {0.0: SweepMean(None, None, None, None, None)},
    }


def test_a_method_that_estimates_no_rooms_has_no_figures_of_rooms(monkeypatch):
    monkeypatch.setattr(module, "METHODS", {"silent": lambda scenario: OdometryOnly()})
    closed = replace(DIFFICULTIES["openness"], values=(0.0,), methods=("silent",))
    assert list(sweep("home", (901,), closed)) == [SweepRow("home", "features", "silent", 0.0, 901, None, None, None, None)]


@pytest.mark.parametrize("values", [(0.0, 0.3), ("day", "dim")])
def test_files_hold_the_rows_and_drawings(values, tmp_path):
    here = "home", "features"
    rows = [SweepRow(*here, "a", value, 1, None, 0.5, 2, 0) for value in values]
    rows.append(SweepRow(*here, "a", values[0], 2, None, None, None, None))
    for value, figures in zip(values, ((0.5, 2, 0), (None,) * 3), strict=True):
        rows.append(SweepRow(*here, "b", value, 1, None, *figures))
    title = "home, seeds 1 to 2, features"
    for name in ("rows.csv", "plot.png", "plot.svg"):
        write_sweep(rows, "light", title, tmp_path / name)
    with (tmp_path / "rows.csv").open() as file:
        assert [(row["preset"], row["fidelity"], row["value"], row["pq"]) for row in csv.DictReader(file)] == [
            ("home", "features", str(row.value), "" if row.pq is None else str(row.pq)) for row in rows
        ]
    assert (tmp_path / "plot.png").read_bytes().startswith(b"\x89PNG")
    drawn = (tmp_path / "plot.svg").read_text()
    assert "<svg" in drawn and f"<!-- {title} -->" in drawn
