"""Answers to questions: the best match comes first, probabilities are ordered as similarities; there may be no match."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.map_builder import ENCODER, corridor_with_offices
from helpers.reading_encoder import ReadingEncoder

from lexis.encoder.open_clip_encoder import load_encoder
from lexis.errors import LexisError, MapError
from lexis.questions.answers import FITS, ask, best_views_mean
from lexis.questions.calibration import Calibration, find_calibration
from sim.bench.answers import Answered, QueriesRow, answering_rooms, ask_one, row_of, true_rooms
from sim.bench.everyday_questions import TUNING
from sim.harness import Scenario, run
from worlds.house import build_house
from worlds.presets import sample_house

EVERYDAY = ("I need the toilet", "a quiet place to work", "where do I cook dinner", "not a kitchen")


@pytest.fixture
def lexis_map(rng):
    return corridor_with_offices(rng)


def encoder_for(lexis_map, keyframe):
    """An encoder that gives every text the embedding of the keyframe, and "office" an unrelated one."""
    vectors = {"what it shows": lexis_map.keyframes[keyframe].embedding, "office": np.eye(16, dtype=np.float32)[0]}
    return ReadingEncoder(vectors, ENCODER)


def calibration(base, slope=0.0, temperature=0.1):
    return Calibration(ENCODER.fingerprint, ("office",), base, slope, temperature)


def test_the_room_and_the_keyframe_that_saw_what_is_asked_for_come_first(lexis_map):
    answer = ask(lexis_map, "what it shows", encoder_for(lexis_map, 34))
    assert answer.rooms[0].room.id == 2 and answer.rooms[0].keyframe == 34
    assert sorted(fit.room.id for fit in answer.rooms) == [0, 1, 2]
    assert answer.keyframes[0].keyframe == 34 and answer.keyframes[0].similarity == pytest.approx(1.0, abs=1e-5)
    assert sorted(fit.keyframe for fit in answer.keyframes) == list(range(40))
    for fits in (answer.rooms, answer.keyframes):
        assert [fit.similarity for fit in fits] == sorted((fit.similarity for fit in fits), reverse=True)


def test_the_room_names_of_the_map_play_no_part(lexis_map):
    renamed = replace(lexis_map, room_names=("a", "b", "c"), labels=np.zeros(40, int))
    one, other = (ask(m, "what it shows", encoder_for(lexis_map, 3), calibration(0.4)) for m in (lexis_map, renamed))
    assert [fit._replace(room=None) for fit in one.rooms] == [fit._replace(room=None) for fit in other.rooms]
    assert one.keyframes == other.keyframes


def test_probabilities_order_rooms_as_similarities_do_and_say_when_nothing_fits(lexis_map):
    encoder = encoder_for(lexis_map, 34)
    likely, unlikely = (ask(lexis_map, "what it shows", encoder, calibration(base)) for base in (0.2, 1.2))
    for answer in (likely, unlikely):
        said = [fit.probability for fit in answer.rooms]
        assert said == sorted(said, reverse=True) and all(0 < p < 1 for p in said)
    assert likely.rooms[0].probability > FITS and not likely.unknown
    assert unlikely.rooms[0].probability < FITS and unlikely.unknown
    assert not ask(lexis_map, "what it shows", encoder).unknown


class OneVector(ReadingEncoder):
    """Encodes every text as the same vector."""

    def __init__(self, vector):
        super().__init__({}, ENCODER)
        self.vector = vector

    def encode_texts(self, texts):
        return np.tile(self.vector, (len(texts), 1))


def test_a_negated_query_ranks_in_reverse_with_complementary_probabilities(lexis_map):
    encoder = OneVector(lexis_map.keyframes[34].embedding)
    wanted, unwanted = (ask(lexis_map, text, encoder, calibration(0.2)) for text in ("a kitchen", "not a kitchen"))
    assert [fit.room.id for fit in unwanted.rooms] == [fit.room.id for fit in wanted.rooms][::-1]
    for fit, contrary in zip(wanted.rooms, unwanted.rooms[::-1], strict=True):
        assert fit.similarity == pytest.approx(contrary.similarity, abs=1e-6)
        assert fit.probability == pytest.approx(1.0 - contrary.probability, abs=1e-6)
        assert contrary.negated and not fit.negated
    assert [fit.keyframe for fit in unwanted.keyframes] == [fit.keyframe for fit in wanted.keyframes][::-1]


def test_the_better_of_two_readings_counts(lexis_map, rng):
    class Bathroom(OneVector):
        def encode_texts(self, texts):
            seen = lexis_map.keyframes[34].embedding
            return np.array([seen if "bathroom" in text else self.vector for text in texts])

    elsewhere = -np.mean([keyframe.embedding for keyframe in lexis_map.keyframes], axis=0, dtype=np.float32)
    encoder = Bathroom(elsewhere / np.linalg.norm(elsewhere))
    for given in (None, calibration(0.4)):
        answer = ask(lexis_map, "I need the toilet", encoder, given)
        assert answer.rooms[0].room.id == 2 and answer.rooms[0].keyframe == 34 and not answer.unknown
    assert ask(lexis_map, "take me to the fridge", encoder, calibration(0.4)).unknown


def test_a_room_is_as_good_as_its_best_views():
    similarities = np.linspace(0.0, 1.0, 11)[:, None] * [1.0, 0.5]
    np.testing.assert_allclose(best_views_mean(similarities), [0.8, 0.4])
    np.testing.assert_allclose(best_views_mean(similarities[::-1]), [0.8, 0.4])
    np.testing.assert_allclose(best_views_mean(similarities[:1]), similarities[0])


def test_another_encoder_and_a_blank_question_are_refused(lexis_map):
    encoder = encoder_for(lexis_map, 3)
    other = ReadingEncoder(encoder.vectors, replace(ENCODER, fingerprint="1" * 64))
    with pytest.raises(MapError, match="weights 00000000, but the given 'test' has weights 11111111"):
        ask(lexis_map, "what it shows", other)
    with pytest.raises(LexisError, match="blank"):
        ask(lexis_map, " ", encoder)
    with pytest.raises(LexisError, match="no rooms"):
        ask(replace(lexis_map, rooms=()), "what it shows", encoder)


@pytest.mark.slow
def test_everyday_questions_to_a_rendered_home_are_answered():
    """Questions about books are left out: the shipped encoder does not recognise books, as its model card says."""
    finished = run(Scenario(preset="home", seed=601))
    encoder = load_encoder("mini")
    rooms = true_rooms(finished, finished.slam.map)
    asked = [question for question in TUNING if question.text in EVERYDAY]
    assert len(asked) == len(EVERYDAY)
    for question in asked:
        answered = ask_one(question, finished.house, finished.slam.map, rooms, encoder, find_calibration(encoder))
        assert answered.has_answer and answered.succeeded, question.text


def test_a_question_is_answered_by_rooms_with_the_label_or_the_thing_and_a_negated_one_by_all_others():
    house = build_house(sample_house("home", 601))
    labels = np.array([room.label for room in house.rooms])
    by_text = {question.text: answering_rooms(question, house) for question in TUNING}
    assert list(labels[by_text["I need the toilet"]]) == ["bathroom"]
    assert list(labels[by_text["a quiet place to work"]]) == ["office"]
    assert list(labels[~by_text["not a kitchen"]]) == ["kitchen"]
    assert not by_text["take me to the laboratory"].any()


def test_figures_of_questions_count_those_with_and_without_an_answer_apart():
    def one(has_answer, right, unknown):
        return Answered(TUNING[0], has_answer, "kitchen", right, unknown)

    answered = [one(True, True, False), one(True, True, True), one(True, False, False), one(True, False, True)]
    row = row_of([*answered, one(False, False, True), one(False, False, False)])
    assert row == QueriesRow(questions=4, ranked_first=0.5, answered=0.25, vain=2, refused=0.5)
    assert row_of(answered).refused is None


def test_an_imported_map_with_embeddings_of_another_length_is_refused(lexis_map):
    longer = ReadingEncoder({"office": np.eye(17, dtype=np.float32)[0]}, ENCODER)
    with pytest.raises(
        MapError, match="the map's embeddings have 16 numbers, and those of its encoder 'test' have 17; valid: "
    ):
        ask(lexis_map, "office", longer)
