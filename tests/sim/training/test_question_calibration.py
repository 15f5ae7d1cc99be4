"""The fit of answer probabilities: questions have known answers, known parameters are recovered, figures are correct."""

import zlib

import numpy as np
import pytest
from helpers.map_builder import ENCODER
from scipy.special import expit
from sklearn.metrics import roc_auc_score

from lexis.encoder.open_clip_encoder import load_encoder
from lexis.questions.calibration import Calibration, familiarity, find_calibration, load_calibration
from sim.cli import main
from sim.errors import GraphicsError, SimError
from sim.training import question_calibration, random_questions
from sim.training.frames import THINGS
from sim.training.houses import TUNING_SEEDS, HouseDraw
from sim.training.phrases import HOLDS_HELD_OUT
from sim.training.question_calibration import asked_in, fit_calibration, measure, tuning_houses, write_calibration
from sim.training.random_questions import (
    ACTIVITY,
    DOUBTFUL,
    NAME,
    NO,
    THING,
    TOPICS,
    YES,
    QuestionBatch,
    RoomViews,
    ask,
    room_views,
)
from worlds.labels import ROOM_LABELS


def raising(error):
    def fails(*arguments):
        raise error

    return fails


class HashingEncoder:
    """Encodes every text as a vector of its own."""

    name, fingerprint = ENCODER.name, ENCODER.fingerprint

    def encode_image(self, image):
        return np.eye(8, dtype=np.float32)[0]

    def encode_rooms(self, names):
        return self.encode_texts(names)

    def encode_texts(self, texts):
        vectors = [np.random.default_rng(zlib.crc32(text.encode())).normal(size=8) for text in texts]
        return np.array([vector / np.linalg.norm(vector) for vector in vectors], np.float32)


@pytest.fixture
def views():
    """Two kitchens and a bedroom with five frames each; a bed is seen well in the bedroom and from afar in a kitchen."""
    shares = np.zeros((15, len(THINGS)), np.float32)
    shares[12, THINGS.index("double bed")], shares[2, THINGS.index("double bed")] = 0.3, 0.002
    labels = np.repeat([ROOM_LABELS.index(name) for name in ("kitchen", "kitchen", "bedroom")], 5)
    return RoomViews(np.zeros((15, 2, 2, 3), np.uint8), np.repeat([0, 1, 2], 5), labels, shares)


def asked_of(views, rng, held_out=False):
    return ask(views, rng.normal(size=(15, 8)).astype(np.float32), HashingEncoder(), rng, held_out)


def test_half_of_the_questions_of_every_topic_have_an_answer(views, rng):
    asked = asked_of(views, rng)
    has = (asked.truth == YES).any(axis=0)
    for topic in TOPICS:
        own = np.array(asked.topics) == topic
        assert own.any() and has[own].mean() == 0.5 and (asked.truth[:, own & ~has] == NO).all()


def test_answers_are_where_the_label_is_or_the_thing_is_seen(views, rng):
    asked = asked_of(views, rng)
    columns = {topic: {tuple(asked.truth[:, i]) for i, own in enumerate(asked.topics) if own == topic} for topic in TOPICS}
    assert columns[NAME] == columns[ACTIVITY] == {(YES, YES, NO), (NO, NO, YES), (NO, NO, NO)}
    assert columns[THING] == {(DOUBTFUL, NO, YES), (NO, NO, NO)}


def test_nothing_is_fitted_in_words_that_are_held_out(views, rng):
    assert not [text for text in asked_of(views, rng).texts if HOLDS_HELD_OUT.search(text)]
    assert all(HOLDS_HELD_OUT.search(text) for text in asked_of(views, rng, held_out=True).texts)


def drawn(rng, calibration, questions=6_000):
    """Questions about houses of one room, with the truth drawn from the probabilities of the calibration."""
    texts = tuple(f"text {i % 50}" for i in range(questions))
    embeddings = HashingEncoder().encode_texts(texts)
    similarities = rng.normal(0.3, 0.2, (1, questions))
    p = expit(
        (similarities - calibration.base - calibration.slope * familiarity(embeddings, ROOM_LABELS, HashingEncoder()))
        / calibration.temperature
    )
    return QuestionBatch(texts, (NAME,) * questions, embeddings, similarities, np.where(rng.random(p.shape) < p, YES, NO))


def test_the_parameters_that_truth_was_drawn_with_are_recovered(rng):
    true = Calibration(ENCODER.fingerprint, ROOM_LABELS, base=0.2, slope=0.3, temperature=0.08)
    fitted = fit_calibration(HashingEncoder(), [drawn(rng, true)])
    assert (fitted.base, fitted.slope) == pytest.approx((0.2, 0.3), abs=0.05)
    assert fitted.temperature == pytest.approx(0.08, rel=0.1)
    figures = measure(fitted, HashingEncoder(), [drawn(rng, true)])
    assert figures.calibration_error < 0.02 and figures.best_calibration_error < 0.02
    wrong = Calibration(ENCODER.fingerprint, ROOM_LABELS, base=0.0, slope=0.0, temperature=0.08)
    assert measure(wrong, HashingEncoder(), [drawn(rng, true)]).calibration_error > 0.2


def test_figures_of_answers_agree_with_their_definitions(views, rng):
    asked = asked_of(views, rng)
    calibration = Calibration(ENCODER.fingerprint, ROOM_LABELS, base=1.0, slope=0.1, temperature=0.5)
    said = calibration.probabilities(asked.similarities, asked.embeddings, HashingEncoder())
    has, best = (asked.truth == YES).any(axis=0), said.max(axis=0)
    figures = measure(calibration, HashingEncoder(), [asked])
    assert figures.questions == len(has) and figures.unknown_auc == pytest.approx(roc_auc_score(has, best))
    assert figures.found == np.mean(best[has] >= 0.5) and figures.unknown == np.mean(best[~has] < 0.5)


def test_rooms_are_those_of_a_walk(monkeypatch):
    monkeypatch.setattr(random_questions, "_MOST", 12)
    views = room_views(HouseDraw("uh2-apt", TUNING_SEEDS[0]))
    assert 8 <= len(views.room) <= 13 and views.shown.shape == (len(views.labels), len(THINGS))
    np.testing.assert_array_equal(views.labels[views.room], views.label)
    np.testing.assert_array_equal(np.unique(views.room), np.arange(len(views.labels)))


def test_houses_to_fit_to_are_kept_for_tuning_and_the_first_ones_stay():
    draws = tuning_houses(20, 0)
    assert all(draw.seed in TUNING_SEEDS and draw.openness is None for draw in draws)
    assert tuning_houses(5, 0) == draws[:5] != tuning_houses(5, 1)


def test_a_house_without_a_walk_is_left_out_but_a_machine_that_cannot_render_is_an_error(monkeypatch):
    draw = HouseDraw("uh2-apt", TUNING_SEEDS[0])
    with monkeypatch.context() as patch:
        patch.setattr(random_questions, "walk", raising(SimError("no walk")))
        assert asked_in([draw], HashingEncoder(), 0) == []
    monkeypatch.setattr(random_questions, "frames_at", raising(GraphicsError("no OpenGL")))
    with pytest.raises(GraphicsError, match="no OpenGL"):
        asked_in([draw], HashingEncoder(), 0)


def test_a_calibration_is_written_beside_its_weights_only_once(views, tmp_path, monkeypatch):
    walked = []
    monkeypatch.setattr(question_calibration, "room_views", lambda draw: walked.append(draw) or views)
    for _ in range(2):
        write_calibration(HashingEncoder(), tmp_path / "mini.safetensors", 3, 0)
    assert len(walked) == 3
    assert load_calibration(tmp_path / "mini.calibration.json").fingerprint == ENCODER.fingerprint


def test_the_command_writes_a_calibration_with_which_mini_answers_questions(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(random_questions, "_MOST", 12)
    file = tmp_path / "mini.json"
    assert main(["calibrate-queries", "--houses", "1", "--out", str(file)]) == 0
    found = find_calibration(load_encoder("mini"), file)  # raises an error if another encoder was calibrated
    assert f"{file}: threshold {found.base:.3f} + {found.slope:.3f} familiarity" in capsys.readouterr().out


def test_without_houses_there_is_no_fit():
    with pytest.raises(SimError, match="no house"):
        fit_calibration(HashingEncoder(), [])


@pytest.mark.parametrize(
    ("arguments", "says"),
    [(["--encoder", "RN50"], "--out is missing"), (["--out", "/nowhere/c.json"], "folder does not exist")],
)
def test_what_cannot_be_written_is_refused_before_the_work(arguments, says, capsys):
    assert main(["calibrate-queries", *arguments]) == 2
    assert says in capsys.readouterr().err
