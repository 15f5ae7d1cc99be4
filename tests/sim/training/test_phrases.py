"""Captions: they name what they describe, and never a held-out phrase."""

import numpy as np
import pytest

from sim.training.frames import THINGS as KINDS
from sim.training.lexicon import ACTIVITIES, ROOMS, SYNONYMS, THINGS
from sim.training.phrases import (
    HELD_OUT_ACTIVITIES,
    HELD_OUT_NAMES,
    HELD_OUT_OBJECTS,
    HELD_OUT_PHRASES,
    HELD_OUT_THINGS,
    HOLDS_HELD_OUT,
    OBJECT_NAMES,
    ROOM_ACTIVITIES,
    ROOM_NAMES,
    ROOM_THINGS,
    object_caption,
    room_caption,
)
from worlds.labels import ROOM_LABELS

SPLITS = {
    "names": (ROOMS, ROOM_NAMES, HELD_OUT_NAMES),
    "activities": (ACTIVITIES, ROOM_ACTIVITIES, HELD_OUT_ACTIVITIES),
    "things": (THINGS, ROOM_THINGS, HELD_OUT_THINGS),
    "objects": (SYNONYMS, OBJECT_NAMES, HELD_OUT_OBJECTS),
}


@pytest.mark.parametrize("table", ["names", "activities", "things"])
def test_every_room_has_words_to_train_on_and_words_to_test_with(table):
    whole, trained, held_out = SPLITS[table]
    assert set(whole) == set(ROOM_LABELS)
    assert min(map(len, trained.values())) >= 4 and min(map(len, held_out.values())) >= 1
    assert table != "names" or min(map(len, held_out.values())) == 6


@pytest.mark.parametrize("table", ["names", "objects"])
def test_labels_and_kinds_are_trained_by_their_own_name(table):
    whole, trained, _ = SPLITS[table]
    assert all(trained[key][0] == key == row[0] for key, row in whole.items())


def test_no_entry_is_both_trained_and_held_out():
    trained = {entry for _, table, _ in SPLITS.values() for row in table.values() for entry in row}
    held_out = {entry for _, _, table in SPLITS.values() for row in table.values() for entry in row}
    assert held_out == set(HELD_OUT_PHRASES) and not trained & held_out


def test_no_caption_holds_a_held_out_phrase():
    rng = np.random.default_rng(0)
    rooms = [room_caption(label, rng) for label in ROOM_LABELS for _ in range(60)]
    objects = [object_caption(kind, rng) for kind in KINDS for _ in range(10)]
    assert len(set(rooms)) > 600
    assert [text for text in rooms + objects if HOLDS_HELD_OUT.search(text)] == []


def test_captions_tell_their_room_and_follow_the_generator():
    for label in ROOM_LABELS:
        texts = [room_caption(label, np.random.default_rng([7, k])) for k in range(20)]
        entries = ROOM_NAMES[label] + ROOM_ACTIVITIES[label] + ROOM_THINGS[label]
        assert all(any(entry in text for entry in entries) for text in texts)
        assert texts == [room_caption(label, np.random.default_rng([7, k])) for k in range(20)]


def test_a_kind_without_synonyms_goes_by_its_own_name():
    assert "spirit level" in object_caption("spirit level", np.random.default_rng(0))
