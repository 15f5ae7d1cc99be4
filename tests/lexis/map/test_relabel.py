"""Relabelling with a map's own names gives the same map, also via other names; poses and loops never change."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.map_builder import ENCODER, corridor_with_offices, with_retired
from helpers.reading_encoder import ReadingEncoder
from helpers.same_map import assert_same

from lexis.config import Config, LabelConfig
from lexis.errors import LexisError, MapError
from lexis.map.relabelling import relabel

NAMES = ("corridor", "office", "kitchen")
OTHER = ("canteen", "lobby", "stairs", "office")


@pytest.fixture
def encoder(rng):
    vectors = rng.normal(size=(6, 16)).astype(np.float32)
    vectors /= np.linalg.norm(vectors, axis=1, keepdims=True)
    return ReadingEncoder(dict(zip(dict.fromkeys(NAMES + OTHER), vectors, strict=True)), ENCODER)


@pytest.fixture
def lexis_map(rng, encoder):
    """A map with the labels that follow from its embeddings."""
    return relabel(corridor_with_offices(rng, loops=[(25, 3), (38, 12)], weights=[1.0, 0.25]), NAMES, encoder)


def test_its_own_names_give_the_same_map(lexis_map, encoder):
    assert_same(relabel(lexis_map, NAMES, encoder), lexis_map)


def test_the_anchor_s_image_stands_for_that_of_a_retired_keyframe(lexis_map, encoder):
    thinned = relabel(with_retired(lexis_map, {12: 3, 13: 3}), NAMES, encoder)
    np.testing.assert_array_equal(thinned.similarities[[12, 13]], thinned.similarities[[3, 3]])
    assert_same(relabel(thinned, NAMES, encoder), thinned)


def test_what_the_map_meant_before_plays_no_part(lexis_map, encoder):
    meaningless = replace(
        lexis_map, room_names=("x",), similarities=np.zeros((40, 1)), probabilities=np.ones((40, 1)), rooms=()
    )
    meaningless = replace(meaningless, **{name: np.full(40, 7) for name in ("labels", "baseline_labels", "floors")})
    assert_same(relabel(meaningless, NAMES, encoder), lexis_map)


def test_other_names_and_back_give_the_same_map(lexis_map, encoder):
    other = relabel(lexis_map, OTHER, encoder)
    assert {room.label for room in other.rooms} <= set(OTHER) and not np.array_equal(other.labels, lexis_map.labels)
    assert_same(relabel(other, NAMES, encoder), lexis_map)


def test_what_is_not_meaning_stays(lexis_map, encoder):
    other = relabel(lexis_map, OTHER, encoder)
    for field in ("camera", "encoder", "keyframes", "loops", "candidates", "stage_seconds"):
        assert_same(getattr(other, field), getattr(lexis_map, field))
    np.testing.assert_array_equal(other.T_W_B, lexis_map.T_W_B)
    assert other.similarities.shape == (40, 4)


def test_the_order_of_names_changes_numbers_and_no_names(lexis_map, encoder):
    other = relabel(lexis_map, NAMES[::-1], encoder)
    assert [other.label_of(i) for i in range(40)] == [lexis_map.label_of(i) for i in range(40)]
    assert_same(other.rooms, lexis_map.rooms)


def test_settings_are_heeded(lexis_map, encoder):
    plain = relabel(lexis_map, NAMES, encoder, Config(labels=LabelConfig(method="image")))
    np.testing.assert_array_equal(plain.labels, lexis_map.baseline_labels)


def test_unusable_names_and_another_encoder_are_refused(lexis_map, encoder):
    with pytest.raises(LexisError, match="more than once"):
        relabel(lexis_map, ("office", "Office"), encoder)
    halved = ReadingEncoder({name: v[:8] / np.linalg.norm(v[:8]) for name, v in encoder.vectors.items()}, ENCODER)
    with pytest.raises(MapError, match="embeddings have 16 numbers, and those of its encoder 'test' have 8; valid: "):
        relabel(lexis_map, NAMES, halved)
    with pytest.raises(MapError, match="similarities across weights mean nothing"):
        relabel(lexis_map, NAMES, ReadingEncoder(encoder.vectors, replace(ENCODER, fingerprint="1" * 64)))
