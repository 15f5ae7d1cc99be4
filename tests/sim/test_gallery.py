"""Pages of houses show every house and every label; the view into a room shows that room."""

import numpy as np
import pytest

from sim.errors import SimError
from sim.gallery import COLUMNS, best_view, plans_page, room_views, rooms_page, sampled_specs
from worlds.house import build_house
from worlds.labels import ROOM_LABELS
from worlds.presets import sample_from_rooms


def test_a_page_has_a_tile_for_every_house():
    specs = sampled_specs(["uh2-apt", "home"], 4, 7)
    assert [spec.name for spec in specs] == [f"{p}-{4 + i // 2}" for i, p in enumerate(["uh2-apt", "home"] * 4)][:7]
    five, seven = plans_page(specs[:5]), plans_page(specs)
    height, width = seven.shape[0] // 3, seven.shape[1] // 3
    assert five.shape == (2 * height, 3 * width, 3) and np.array_equal(five[:height], seven[:height])
    tiles = [seven[i * height : (i + 1) * height, j * width : (j + 1) * width] for i in range(3) for j in range(3)]
    assert [tile.std() > 10 for tile in tiles] == 7 * [True] + 2 * [False]
    assert (np.stack(tiles[7:]) == 255).all()


def test_fewer_plans_are_drawn_larger_and_the_page_never_gets_wider():
    specs = sampled_specs(["uh2-apt"], 4, 5)
    one, four, five = (plans_page(specs[:count]) for count in (1, 4, 5))
    assert 2 * one.shape[1] == four.shape[1] <= five.shape[1] <= COLUMNS * 650
    assert one.shape[1] > five.shape[1] / 3


def test_every_label_has_a_room_even_where_no_house_does():
    (balcony,) = room_views([], ["balcony"])
    assert balcony.label == "balcony" and balcony.house == "balcony"
    views = list(room_views(sampled_specs(["uh2-apt"], 1, 1), ["bathroom", "garage"]))
    assert [(view.label, view.house) for view in views] == [("bathroom", "uh2-apt-1"), ("garage", "garage")]
    assert np.mean(rooms_page(views) != rooms_page(views, labelled=False)) < 0.05


@pytest.mark.parametrize("label", [ROOM_LABELS[0], ROOM_LABELS[-1]])
def test_a_view_is_a_picture_and_always_the_same(label):
    house = build_house(sample_from_rooms((label, "corridor"), seed=2))
    room = next(room for room in house.rooms if room.label == label)
    image = best_view(house, room, (120, 90))
    assert image.shape == (90, 120, 3) and image.std() > 15
    assert np.array_equal(image, best_view(house, room, (120, 90)))


def test_empty_pages_are_refused():
    with pytest.raises(SimError, match="at least 1"):
        sampled_specs([], 0)
