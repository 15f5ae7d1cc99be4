"""Drives along the same plans by several pose estimates: one row for each driver, and pictures of LEXIS's failures alone."""

from dataclasses import replace

import pytest

from sim.bench import planning as module
from sim.bench.planning import DRIVERS, drive_houses
from sim.cli import main
from sim.errors import SimError
from sim.harness import Scenario
from worlds.presets import sample_from_rooms

FLAT = Scenario(
    house=sample_from_rooms(("kitchen", "bedroom"), seed=21),
    length_m=30.0,
    fidelity="features",
    encoder="oracle",
    frame_rate_hz=2.0,
)


def test_every_driver_gets_the_same_plans_and_the_truth_touches_nothing(tmp_path):
    rows = list(drive_houses(FLAT, (5, 6), tmp_path / "pictures"))
    assert [(row.seed, row.driver) for row in rows] == [(seed, driver) for seed in (5, 6) for driver in DRIVERS]
    assert {row.queries for row in rows} == {6}  # between three rooms
    assert all((row.success, row.touched) == (1.0, 0) and row.spl > 0.5 for row in rows if row.driver == "truth")
    assert list((tmp_path / "pictures").iterdir()) == []


def test_failed_drives_of_lexis_alone_are_drawn(tmp_path, monkeypatch):
    def failing(finished, steering, blind):
        first, *others = original(finished, steering, blind)
        return [replace(first, success=False, touched=("a wall",)), *others]

    original = module.try_plans
    monkeypatch.setattr(module, "try_plans", failing)
    odometry, lexis = drive_houses(FLAT, (5,), tmp_path, drivers=("odometry", "LEXIS"))
    assert odometry.success == lexis.success == pytest.approx(5 / 6) and odometry.touched == lexis.touched == 1
    assert lexis.spl <= lexis.success
    (picture,) = tmp_path.iterdir()
    assert picture.name == "5-bedroom-to-corridor.png" and picture.read_bytes().startswith(b"\x89PNG")


def test_an_unknown_driver_is_refused_before_the_work(tmp_path):
    with pytest.raises(SimError, match="no driver 'nobody'; valid: 'truth', 'LEXIS'"):
        next(drive_houses(FLAT, (5,), tmp_path / "none", drivers=("nobody",)))
    assert not (tmp_path / "none").exists()


def test_without_drift_the_odometry_drives_as_the_truth_does():
    """The paths differ a little, because the local grids of the robot lie differently in the two frames."""
    truth, odometry = drive_houses(replace(FLAT, odometry="perfect"), (5,), drivers=("truth", "odometry"))
    assert (truth.success, truth.touched) == (odometry.success, odometry.touched) == (1.0, 0)
    assert truth.spl == pytest.approx(odometry.spl, abs=0.01)


def test_the_command_drives_with_the_odometry_that_it_is_given(monkeypatch):
    scenarios = []
    monkeypatch.setattr(module, "drive_houses", lambda scenario, *_: scenarios.append(scenario) or iter(()))
    assert main(["bench", "planning", "--odometry", "mono"]) == 0
    assert [scenario.odometry for scenario in scenarios] == ["mono"]
