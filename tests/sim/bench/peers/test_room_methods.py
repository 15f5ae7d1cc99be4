"""The methods for labels and rooms are compared on the same walks."""

from lexis.config import PAPER, Config
from sim.bench.peers.room_methods import METHODS, compare_methods


def test_the_first_method_is_that_of_the_paper_and_sight_finds_better_rooms():
    first, *_, last = rows = list(compare_methods("uh2-apt", (302, 303)))
    assert [row.method for row in rows] == list(METHODS)
    assert METHODS[first.method].labels == PAPER.labels and METHODS[last.method] == Config()
    assert last.labels > first.labels and last.rooms > first.rooms
