"""Questions in free words: what fits best comes first, probabilities order as similarities do, and nothing may fit."""

from dataclasses import replace

import numpy as np
import pytest
from map_builder import ENCODER, corridor_with_offices
from reading_encoder import ReadingEncoder

from lexis.calibration import Calibration
from lexis.errors import LexisError, MapError
from lexis.query import FITS, ask, best_views


@pytest.fixture
def lexis_map(rng):
    return corridor_with_offices(rng)


def encoder_for(lexis_map, keyframe):
    """Every text reads as the keyframe looks, "office" as nothing in particular."""
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


def test_a_room_is_as_good_as_its_best_views():
    similarities = np.linspace(0.0, 1.0, 11)[:, None] * [1.0, 0.5]
    np.testing.assert_allclose(best_views(similarities), [0.8, 0.4])
    np.testing.assert_allclose(best_views(similarities[::-1]), [0.8, 0.4])
    np.testing.assert_allclose(best_views(similarities[:1]), similarities[0])


def test_another_encoder_and_a_blank_question_are_refused(lexis_map):
    encoder = encoder_for(lexis_map, 3)
    other = ReadingEncoder(encoder.vectors, replace(ENCODER, fingerprint="1" * 64))
    with pytest.raises(MapError, match="weights 00000000, but 'test' at hand has weights 11111111"):
        ask(lexis_map, "what it shows", other)
    with pytest.raises(LexisError, match="blank"):
        ask(lexis_map, " ", encoder)
    with pytest.raises(LexisError, match="no rooms"):
        ask(replace(lexis_map, rooms=()), "what it shows", encoder)
