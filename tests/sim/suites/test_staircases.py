"""Laws about stairs see wrong labels on a climb, and a staircase that is torn into several rooms."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.open_flat import OPEN_FLAT

from sim.harness import Estimate, Lexis, run
from sim.suites.staircases import staircases_are_rooms, stairs_are_climbed
from worlds.presets import sample_house
from worlds.validation import built_and_checked


@pytest.fixture(scope="module")
def lexis():
    return run(replace(OPEN_FLAT, length_m=50.0), Lexis("oracle"))


UP_AND_ON = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 0.5, 1.0, 1.5, 2.0, 2.5, 2.5, 2.5, 2.5, 2.5, 2.5])
"""Heights of frames on a path that is level, climbs a flight of stairs, and is level again [m]."""


def on_a_flight(lexis, stairs, rooms=None):
    """A run along `UP_AND_ON`, in steps of 0.85 m to the front; the frames in `stairs` are labelled as stairs."""
    frames = lexis.estimate.frames[: len(UP_AND_ON)]
    T = np.tile(np.eye(4), (len(frames), 1, 1))
    T[:, 0, 3], T[:, 2, 3] = 0.85 * np.arange(len(frames)), UP_AND_ON
    given = {frame: lexis.given[frame]._replace(T_O_B=pose) for frame, pose in zip(frames.tolist(), T, strict=True)}
    house = built_and_checked(sample_house("home", 3, rooms=6, storeys=2))
    labels = np.full(len(frames), house.spec.room_labels.index("kitchen"))
    labels[stairs] = house.spec.room_labels.index("stairs")
    return replace(lexis, house=house, estimate=Estimate(frames, T_W_B=T, labels=labels, rooms=rooms), given=given)


@pytest.mark.parametrize(
    ("stairs", "holds"),
    [(slice(4, 10), True), (slice(5, 9), True), (slice(4, 7), False), (slice(4, 13), False), (slice(0, 0), False)],
    ids=["all", "middle", "half", "and beyond", "none"],
)
def test_stairs_are_labelled_where_the_path_climbs_and_not_where_it_is_level(lexis, stairs, holds):
    assert stairs_are_climbed(on_a_flight(lexis, stairs)).holds is holds


def test_a_half_landing_may_be_labelled_as_stairs_and_the_floor_at_the_top_may_not(lexis, monkeypatch):
    rising = np.array([0.0, 0.5, 1.0, 1.5, 1.5, 1.5, 1.5, 1.5, 2.0, 2.5, 3.0, 3.0, 3.0, 3.0, 3.0])
    monkeypatch.setattr(f"{__name__}.UP_AND_ON", rising)
    assert stairs_are_climbed(on_a_flight(lexis, slice(1, 10))).holds
    assert stairs_are_climbed(on_a_flight(lexis, slice(1, 14))).holds is False


def up_and_down(lexis, rooms):
    """A run up a flight of stairs and down again, whose frames all have the label of stairs."""
    finished = on_a_flight(lexis, slice(0, None), rooms)
    T = finished.estimate.T_W_B.copy()
    T[:, 0, 3] = 0.5 * np.minimum(np.arange(len(T)), np.arange(len(T))[::-1])
    return replace(finished, estimate=replace(finished.estimate, T_W_B=T))


def test_the_way_up_and_the_way_down_are_one_room(lexis):
    one, two = np.zeros(len(UP_AND_ON), int), np.repeat([0, 1], [7, 8])
    assert staircases_are_rooms(up_and_down(lexis, one)).holds
    assert staircases_are_rooms(up_and_down(lexis, two)).holds is False
    assert staircases_are_rooms(up_and_down(lexis, None)).holds is None
    assert staircases_are_rooms(up_and_down(lexis, one - 1)).measured == "no frame on stairs belongs to a room"


def test_stairs_that_are_far_from_each_other_may_be_two_rooms(lexis):
    rooms = np.repeat([0, 1], [5, 10])
    assert staircases_are_rooms(on_a_flight(lexis, np.r_[0:4, 6:15], rooms)).holds
