"""Families of houses: every seed gives a house, the same one each time, of the kind that its name promises."""

import pytest

from worlds.errors import WorldsError
from worlds.house import build_house
from worlds.labels import STAIRS
from worlds.presets import PRESETS, sample_from_rooms, sample_house
from worlds.truth import openness


@pytest.mark.parametrize("preset", PRESETS)
def test_many_seeds_all_lay_out_and_differ(preset):
    specs = [sample_house(preset, seed) for seed in range(200)]
    assert len({spec.to_json() for spec in specs}) == 200
    assert sample_house(preset, 17).to_json() == specs[17].to_json()


def test_a_home_has_two_storeys_stairs_and_open_living():
    for seed in range(20):
        spec = sample_house("home", seed)
        assert len(spec.storeys) == 2 and all(any(room.label == STAIRS for room in storey.rooms) for storey in spec.storeys)
        kinds = {frozenset(i.split(" ")[0] for i in opening.rooms): opening.kind for opening in spec.storeys[0].openings}
        assert kinds[frozenset({"kitchen", "dining"})] == kinds[frozenset({"dining", "living"})] == "open"
        assert openness(build_house(spec)) > 0.15


def test_rooms_asked_for_are_there():
    asked = ("kitchen", "office", "office", "bathroom")
    labels = [room.label for room in sample_from_rooms(asked, 3).storeys[0].rooms]
    assert sorted(labels) == sorted([*asked, "corridor"])


@pytest.mark.parametrize(
    ("labels", "message"), [(("kitchn",), "valid: kitchen"), ((), "0 rooms"), (("office",) * 41, "41 rooms")]
)
def test_impossible_room_lists_are_refused(labels, message):
    with pytest.raises(WorldsError, match=message):
        sample_from_rooms(labels, 0)


def test_an_unknown_preset_lists_the_known_ones():
    with pytest.raises(WorldsError, match="valid: home, ori"):
        sample_house("castle", 0)
