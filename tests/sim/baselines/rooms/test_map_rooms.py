"""The adapter of segmentations estimates the rooms and floors of LEXIS's keyframes, and variants of LEXIS use no words."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.small_inputs import observations

from lexis.errors import ObservationError
from sim.baselines.rooms import MapRooms, Voronoi, WordlessLexis
from sim.errors import SimError
from sim.harness import Scenario, evaluate, run
from sim.harness.adapters import Lexis
from sim.harness.run_settings import house_spec
from worlds.variant import variant

USUAL = Scenario(preset="home", seed=901, fidelity="features", frame_rate_hz=2.0)
CLOSED = replace(USUAL, house=variant(house_spec(USUAL), openness=0.0))


def test_rooms_behind_doors_are_found_on_every_floor_at_the_keyframes_of_lexis():
    finished = run(CLOSED, MapRooms.of(CLOSED, Voronoi()))
    result = evaluate(finished)
    assert result.rooms.pq > 0.9 and result.floors.accuracy == 1.0
    assert result.labels.accuracy is None and result.trajectory.ate_m is None
    assert (finished.estimate.frames == run(CLOSED, Lexis()).estimate.frames).all()


def test_stairs_are_a_room_of_their_own_and_storeys_share_no_room():
    finished = run(CLOSED, MapRooms.of(CLOSED, Voronoi()))
    rooms, storeys, stairs = finished.estimate.rooms, finished.true_storeys, finished.on_stairs
    assert stairs.any() and len(np.unique(storeys)) == 2
    groups = [set(rooms[stairs]), *(set(rooms[~stairs & (storeys == level)]) for level in (0, 1))]
    assert len(set.union(*groups)) == sum(map(len, groups))


def test_a_run_without_observations_is_refused():
    with pytest.raises(SimError, match="no observation"):
        MapRooms.of(CLOSED, Voronoi()).finish()


def test_an_observation_that_comes_before_an_earlier_one_is_refused():
    """The earlier one here is no keyframe, because the body stands still."""
    slam = MapRooms.of(CLOSED, Voronoi())
    first = next(iter(observations()))
    for index in (0, 5):
        slam.process(replace(first, index=index))
    with pytest.raises(ObservationError, match="observation 3 comes after 5; valid: ascending numbers"):
        slam.process(replace(first, index=3))


def test_wordless_lexis_estimates_rooms_but_no_labels():
    result = evaluate(run(CLOSED, WordlessLexis()))
    assert result.labels.accuracy is None and result.labels.accuracy_baseline is None
    assert result.rooms.pq is not None and result.floors.accuracy > 0.9
