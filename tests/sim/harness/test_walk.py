"""A walk depends on exactly those settings of a scenario that concern the house, the tour and the odometry."""

from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings

from lexis.maths.se3 import inverse
from sim.faults import parse_fault
from sim.harness.scenario import Scenario
from sim.harness.walk import shortest_walk_m, walk, with_walk_m
from sim.render.rig import RigConfig
from worlds.furniture import registry
from worlds.presets import sample_from_rooms
from worlds.strategies import houses
from worlds.truth import room_at

PLAIN = Scenario(
    house=sample_from_rooms(("kitchen", "bedroom"), seed=21), length_m=20.0, frame_rate_hz=2.0, fidelity="features"
)
SAME = {"fidelity": "render", "encoder": "oracle", "feature_model": Path("model.npz"), "rig": RigConfig("stereo"),
        "faults": (parse_fault("dropped:0.5"),)}  # fmt: skip
OTHER = {"seed": 8, "house": sample_from_rooms(("kitchen", "office"), seed=21), "length_m": 25.0, "tour_kind": "random",
         "reverse": True, "frame_rate_hz": 4.0, "sway": "quadruped", "start_manoeuvre": True, "odometry": "mono",
         "overconfidence": 4.0}  # fmt: skip


def differs(first, second):
    a, b = first.odometry, second.odometry
    return first.house.spec != second.house.spec or not (
        np.array_equal(first.tour.T_W_B, second.tour.T_W_B)
        and np.array_equal(a.T_O_B, b.T_O_B)
        and np.array_equal(a.increment_covariance, b.increment_covariance)
    )


def test_every_setting_is_listed_here():
    assert {*SAME, *OTHER, "preset"} == {field.name for field in fields(Scenario)}


@pytest.mark.parametrize("name", SAME)
def test_what_the_slam_sees_does_not_change_the_walk(name):
    assert not differs(walk(PLAIN), walk(replace(PLAIN, **{name: SAME[name]})))


@pytest.mark.parametrize("name", OTHER)
def test_house_tour_and_odometry_change_the_walk(name):
    assert differs(walk(PLAIN), walk(replace(PLAIN, **{name: OTHER[name]})))


def test_furniture_that_is_declared_between_two_runs_is_in_the_second(monkeypatch):
    monkeypatch.setattr(registry, "KINDS", dict(registry.KINDS))
    sizes = {"width": (0.5, 0.5), "depth": (0.5, 0.5), "height": (1.0, 1.0)}
    for height in (1.0, 1.2):  # as in a cell of a notebook that is run again
        before = walk(PLAIN)
        assert walk(PLAIN) is before
        declare = registry.furniture("grand piano", **sizes | {"height": (height, height)}, rooms={"kitchen": (1, 1)})
        declare(lambda size, rng: [])
        assert walk(PLAIN) is not before


def test_the_preset_changes_the_walk_if_no_house_is_given():
    assert walk(Scenario(preset="home")).house.spec != walk(Scenario(preset="apartment")).house.spec


def test_a_walk_gets_the_length_that_is_asked_for_but_visits_all_rooms():
    least = shortest_walk_m(PLAIN)
    assert with_walk_m(PLAIN, 40.0) == replace(PLAIN, length_m=40.0)
    short = with_walk_m(PLAIN, 0.5 * least)
    assert least <= short.length_m < least + 1.0
    walked = walk(short)
    assert set(room_at(walked.house, walked.tour.T_W_B[:, :3, 3])) >= set(range(len(walked.house.rooms)))


@settings(max_examples=12, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(house=houses(max_rooms=2, max_storeys=1, furnished=True))
def test_the_smallest_furnished_houses_that_are_drawn_admit_a_walk_of_40_m(house):
    assert walk(replace(PLAIN, house=house, length_m=40.0)).tour.length_m == pytest.approx(40.0, abs=3.0)


def test_the_odometry_frame_is_upright_and_reveals_neither_the_plan_nor_the_height_of_the_floor():
    """The odometry started in the frame of the plan once, so that a SLAM could have read floors from heights."""
    transforms = []
    for seed in range(8):
        made = walk(replace(PLAIN, seed=seed, odometry="perfect", length_m=15.0))
        T_O_W = made.odometry.T_O_B @ inverse(made.tour.T_W_B)
        np.testing.assert_allclose(T_O_W, np.broadcast_to(T_O_W[0], T_O_W.shape), atol=1e-9)
        np.testing.assert_allclose(T_O_W[0, 2, :3], [0.0, 0.0, 1.0], atol=1e-12)
        transforms.append(T_O_W[0])
    spread = np.ptp(transforms, axis=0)
    assert np.all(spread[:3, 3] > [5.0, 5.0, 1.5])
    assert spread[0, 0] > 1.0
