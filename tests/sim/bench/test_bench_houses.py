"""The houses of a benchmark are those of the preset; with an openness, only the openings in inner walls differ."""

import pytest

from sim.bench.houses import for_seeds
from sim.harness import Scenario
from sim.harness.run_settings import house_spec
from worlds.errors import WorldsError
from worlds.house import build_house
from worlds.truth import openness

SEEDS = (500, 501)
SCENARIO = Scenario(preset="home")


def test_without_an_openness_the_houses_are_those_of_the_preset():
    assert [(own.preset, own.house, own.seed) for own in for_seeds(SCENARIO, SEEDS)] == [
        ("home", None, 500),
        ("home", None, 501),
    ]


def test_an_openness_changes_inner_walls_and_no_room():
    for own, closed, opened in zip(*(for_seeds(SCENARIO, SEEDS, x) for x in (None, 0.0, 0.9)), strict=True):
        rooms = [
            [room.polygon_m for storey in house_spec(c).storeys for room in storey.rooms] for c in (own, closed, opened)
        ]
        assert rooms[0] == rooms[1] == rooms[2]
        assert openness(build_house(house_spec(closed))) < 0.1 < 0.6 < openness(build_house(house_spec(opened)))


def test_an_openness_that_cannot_be_is_refused():
    with pytest.raises(WorldsError, match="valid"):
        list(for_seeds(SCENARIO, SEEDS, 1.5))
