"""The methods for labels and rooms are compared on the same walks."""

from dataclasses import astuple

from lexis.config import PAPER, Config
from sim.bench.peers import room_methods as module
from sim.bench.peers.room_methods import METHODS, compare_methods
from sim.harness import run
from sim.harness.adapters import OdometryOnly


def test_the_first_method_is_that_of_the_paper_and_sight_finds_better_rooms():
    first, *_, last = rows = list(compare_methods("uh2-apt", (302,)))
    assert [row.method for row in rows] == list(METHODS)
    assert METHODS[first.method].labels == PAPER.labels and METHODS[last.method] == Config()
    assert last.labels > first.labels and last.rooms > first.rooms


def test_figures_that_a_run_does_not_have_are_left_out_of_the_means(monkeypatch):
    monkeypatch.setattr(module, "METHODS", {"sight": Config()})
    (first,) = compare_methods("uh2-apt", (302,))
    silent = {303, 304}
    monkeypatch.setattr(
        module, "run", lambda scenario, slam: run(scenario, OdometryOnly() if scenario.seed in silent else slam)
    )
    assert list(compare_methods("uh2-apt", (302, 303))) == [first] and first.labels_std is first.rooms_std is None
    (nothing,) = compare_methods("uh2-apt", (303, 304))
    assert set(astuple(nothing)) == {"sight", None}
