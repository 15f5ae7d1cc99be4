"""Held-out variants of furniture never occur in training and always do where tests ask for them; nothing else changes."""

from dataclasses import replace

import pytest

from sim.training.variants import repainted, shows_held_out
from worlds.furniture.catalogue import CATALOGUE
from worlds.house import build_house
from worlds.presets import sample_house


@pytest.fixture(scope="module")
def house():
    return build_house(sample_house("home", 3))


def place(piece):
    return piece.id, piece.kind, piece.position, piece.yaw, piece.size


def test_training_never_shows_a_held_out_variant_and_loses_hardly_a_piece(house):
    assert any(map(shows_held_out, house.furniture))
    trained = repainted(house, held_out=False)
    assert not any(map(shows_held_out, trained.furniture))
    assert len(trained.furniture) >= 0.97 * len(house.furniture)
    assert {place(piece) for piece in trained.furniture} <= {place(piece) for piece in house.furniture}


def test_held_out_variants_are_wherever_a_kind_has_any(house):
    tested = repainted(house, held_out=True)
    assert [place(piece) for piece in tested.furniture] == [place(piece) for piece in house.furniture]
    can = {piece.kind for piece in house.furniture if shows_held_out(piece)}
    assert all(shows_held_out(piece) for piece in tested.furniture if piece.kind in can)


def test_every_kind_of_furniture_is_trained_in_some_colour(house):
    one = house.furniture[0]
    sizes = {name: tuple(sum(r) / 2 for r in (kind.width, kind.depth, kind.height)) for name, kind in CATALOGUE.items()}
    often = [replace(one, kind=name, size=size, seed=seed) for name, size in sizes.items() for seed in range(5)]
    kept = {piece.kind for piece in repainted(replace(house, furniture=tuple(often)), held_out=False).furniture}
    assert set(CATALOGUE) - kept == set()
