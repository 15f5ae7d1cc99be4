"""The runs on which encoders are measured: keyframes, image variants, questions with exactly one answer, and files."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.painted_runs import painted_run

from lexis.config import KeyframeConfig
from sim.bench.encoders import runs as module
from sim.bench.encoders.questions import (
    ACTIVITY,
    HELD_OUT_FRAMES,
    HELD_OUT_WORDS,
    THING,
    TRAINED,
    AnsweredQuestion,
    RoomQuestion,
    failures,
    questions_of,
    share_right,
    standing_in_one,
)
from sim.bench.encoders.runs import TRAINED_LOOKS, encoder_runs, keyframes_along
from sim.errors import SimError
from sim.training.frames import THINGS
from sim.training.houses import HELD_OUT_LOOKS
from sim.training.phrases import HOLDS_HELD_OUT
from worlds.truth import objects

SEED = 900_004


def test_keyframes_are_spaced_as_lexis_spaces_them_and_wider_on_long_walks():
    line = np.column_stack([np.arange(0.0, 100.0, 0.07), np.zeros((1429, 2))])
    spacing = KeyframeConfig().spacing_m
    assert np.diff(line[keyframes_along(line), 0]).mean() == pytest.approx(spacing, rel=0.01)
    assert 399 <= len(keyframes_along(10 * line)) <= 401


def test_trained_looks_are_the_values_of_the_held_out_ones_in_pairs_that_are_not_held_out():
    assert not set(TRAINED_LOOKS) & set(HELD_OUT_LOOKS)
    for held_out, trained in zip(zip(*HELD_OUT_LOOKS, strict=True), zip(*TRAINED_LOOKS, strict=True), strict=True):
        assert sorted(held_out) == sorted(trained)


def test_runs_are_cached_in_a_folder_and_damaged_ones_are_reported(tmp_path, monkeypatch):
    monkeypatch.setattr(module, "_rendered", lambda draw: painted_run(draw.seed))
    (first,) = encoder_runs("uh2-apt", [SEED], tmp_path)
    monkeypatch.delattr(module, "_rendered")
    (again,) = encoder_runs("uh2-apt", [SEED], tmp_path)
    for name in ("stamps", "T_W_B", "room", "held_out_looks"):
        np.testing.assert_array_equal(getattr(again, name), getattr(first, name))
    np.testing.assert_array_equal(again.frames.things, first.frames.things)
    (path,) = tmp_path.iterdir()
    with monkeypatch.context() as other:
        other.setattr(module, "LEXIS_VIEWS", replace(module.LEXIS_VIEWS, size=(240, 180)))
        with pytest.raises(SimError, match="delete its folder"):
            list(encoder_runs("uh2-apt", [SEED], tmp_path))
    path.write_bytes(path.read_bytes()[:1000])
    with pytest.raises(SimError, match="delete it"):
        list(encoder_runs("uh2-apt", [SEED], tmp_path))


def test_things_asked_for_stand_in_rooms_of_one_label_and_are_seen():
    run = painted_run(SEED)
    house = run.house
    found = standing_in_one(run)
    assert found
    for kind, label in found.items():
        assert {house.room_by_id[thing.room].label for thing in objects(house) if thing.kind == kind} == {label}
        assert (run.frames.shares[:, THINGS.index(kind)] > 0.01).sum() >= 3


def test_wordings_are_what_they_are_called():
    questions = list(questions_of(painted_run(SEED)))
    assert {question.topic for question in questions} >= {THING, ACTIVITY}
    assert not any(HOLDS_HELD_OUT.search(q.text) for q in questions if q.wording != HELD_OUT_WORDS)
    assert all(HOLDS_HELD_OUT.search(q.text) for q in questions if q.wording == HELD_OUT_WORDS)
    trained, framed = ({q.text for q in questions if q.wording == w} for w in (TRAINED, HELD_OUT_FRAMES))
    assert not trained & framed


def test_failures_are_counted_with_what_was_said_instead():
    def asked(about, said, wording=TRAINED):
        return AnsweredQuestion(RoomQuestion(THING, wording, about, f"a {about}", "kitchen"), said)

    answers = [asked("stove", "kitchen"), asked("stove", "garden"), *[asked("sink", "office")] * 2, asked("oven", "kitchen")]
    assert share_right(answers, THING, TRAINED) == (pytest.approx(0.4), 5)
    assert share_right(answers, THING, HELD_OUT_WORDS) == (None, 0)
    worst, other = failures(answers)
    assert (worst.about, worst.asked, worst.right, worst.instead) == ("sink", 2, 0, "office")
    assert (other.about, other.asked, other.right, other.instead) == ("stove", 2, 1, "garden")
