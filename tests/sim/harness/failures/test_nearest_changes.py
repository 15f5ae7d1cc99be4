"""The changes that make a failure go away are listed without those that contain another one."""

from dataclasses import replace

import pytest

from sim.harness import Scenario
from sim.harness.failures.nearest_changes import nearest
from sim.harness.run_settings import with_listed_house
from sim.harness.shrinking.house_edits import keep_furniture, keep_rooms
from sim.harness.shrinking.house_reductions import fewer_openings, fewer_windows, simpler_openings
from sim.harness.shrinking.wall_reductions import narrower
from worlds.presets import sample_from_rooms

SMALLEST = with_listed_house(
    Scenario(
        house=sample_from_rooms(("kitchen", "bedroom", "office"), seed=21, openness=0.5),
        length_m=27.0,
        odometry="multicam",
        overconfidence=2.0,
        fidelity="features",
    )
)
ROOMS = {room.id for room in SMALLEST.house.storeys[0].rooms}


def without_rooms(*gone):
    return replace(SMALLEST, house=keep_rooms(SMALLEST.house, ROOMS - set(gone)))


def with_furniture(count):
    ids = [piece.id for piece in SMALLEST.house.storeys[0].furniture]
    return replace(SMALLEST, house=keep_furniture(SMALLEST.house, set(ids[:count])))


def test_of_nested_sets_of_rooms_the_smallest_are_kept():
    passing = [without_rooms("kitchen 0.1", "office 0.1"), without_rooms("office 0.1"), without_rooms("bedroom 0.1")]
    assert nearest(SMALLEST, passing) == passing[1:]


def test_of_lengths_the_nearest_is_kept_also_beside_other_changes():
    lengths = [replace(SMALLEST, length_m=length_m) for length_m in (4.0, 6.0, 24.0, 20.0)]
    both = replace(without_rooms("office 0.1"), length_m=13.0)
    assert nearest(SMALLEST, [*lengths, both]) == [lengths[2]]
    assert nearest(SMALLEST, [both]) == [both]


def test_of_nested_sets_of_furniture_the_smallest_is_kept():
    count = len(SMALLEST.house.storeys[0].furniture)
    passing = [with_furniture(0), with_furniture(count - 1)]
    assert nearest(SMALLEST, passing) == passing[1:]


def test_changes_of_different_things_are_all_kept():
    perfect, modest = replace(SMALLEST, odometry="perfect"), replace(SMALLEST, overconfidence=1.0)
    both = replace(perfect, overconfidence=1.0)
    closed = list(fewer_openings(SMALLEST.house))[-1]
    passing = [both, perfect, replace(SMALLEST, house=closed), modest]
    assert nearest(SMALLEST, passing) == passing[1:]


@pytest.mark.parametrize("step", [fewer_windows, fewer_openings, narrower, simpler_openings])
def test_of_equal_changes_one_is_kept(step):
    changed = [replace(SMALLEST, house=house) for house in step(SMALLEST.house)][:1]
    assert nearest(SMALLEST, changed * 2) == changed
