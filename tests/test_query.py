import numpy as np
import pytest
from map_builder import corridor_with_offices

from lexis.errors import MapError
from lexis.query import rank_rooms


def test_the_room_that_saw_what_is_asked_for_comes_first(rng):
    lexis_map = corridor_with_offices(rng)
    answers = rank_rooms(lexis_map, lexis_map.keyframes[34].embedding)
    assert answers[0].room.id == 2 and answers[0].keyframe == 34
    assert sorted(answer.room.id for answer in answers) == [0, 1, 2]
    assert [a.similarity for a in answers] == sorted((a.similarity for a in answers), reverse=True)


def test_another_encoder_is_noticed(rng):
    with pytest.raises(MapError, match="16 dimensions, the encoder's 8"):
        rank_rooms(corridor_with_offices(rng), np.ones(8, np.float32))
