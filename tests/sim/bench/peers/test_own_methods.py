"""A method of the user's own gets rows of its own, changes no other row, and is named in the errors that it causes."""

import csv
import sys
from dataclasses import replace

import numpy as np
import pytest
from helpers.command_line import status_of
from helpers.documentation import blocks
from helpers.two_laps import two_laps, walk_of

from sim.baselines.places import EmbeddingSimilarity
from sim.baselines.rooms import DistanceTransform
from sim.bench.peers import difficulty_sweep, place_methods
from sim.bench.peers.difficulty_sweep import DIFFICULTIES, METHODS, sweep
from sim.bench.peers.own_methods import OwnMethodError, OwnPlaces, OwnSegmentation
from sim.bench.peers.place_methods import Contestant, compare_place_methods
from sim.cli import parser

CLOSED = replace(DIFFICULTIES["openness"], values=(0.0,), methods=("positions alone", "distance transform"))
SEGMENTING = ["bench", "openness", "--houses", "1", "--seed", "901", "--segmentation"]
PLACING = ["bench", "fig5", "--houses", "1", "--place-method"]
FREE = np.ones((4, 3), bool)


class Answer:
    """A method that returns the same value for every input, or raises it if it is an exception."""

    def __init__(self, value):
        self.value = value

    def segments(self, free, resolution_m):
        if isinstance(self.value, BaseException):
            raise self.value
        return self.value

    def scores(self, seen):
        return self.segments(None, 0.0)


class Scribbling(EmbeddingSimilarity):
    """Writes into what it is given."""

    def scores(self, seen):
        found = super().scores(seen)
        seen.eligible[:], seen.embeddings[:] = False, 0.0
        return found


@pytest.fixture
def own_modules(tmp_path, monkeypatch):
    """The current folder, with modules of a user: the examples of the page, and one with faulty classes."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", [*sys.path])
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    page = [each.content for each in blocks("sim/pages/baselines.md") if each.language == "python"]
    (tmp_path / "my_rooms.py").write_text(next(each for each in page if "class WideParts" in each))
    (tmp_path / "my_places.py").write_text(next(each for each in page if "class PairsOfViews" in each))
    (tmp_path / "own_faulty.py").write_text(
        "from sim.baselines.places import EmbeddingSimilarity\n"
        "from sim.baselines.rooms import Voronoi\n"
        "number = 3\n"
        "class Empty: pass\n"
        "class Greedy:\n    def __init__(self, weights): pass\n"
        "class Unlicensed:\n    def __init__(self): raise OSError('no licence')\n"
        "class Narrow:\n    def segments(self, free): pass\n    def scores(self): pass\n"
        "class Lost:\n    def segments(self, free, resolution_m): raise ValueError('lost')\n"
        "    scores = lambda self, seen: 1 / 0\n"
        "lost = Lost()\n"
    )
    yield tmp_path
    for name in ("my_rooms", "my_places", "own_faulty"):
        sys.modules.pop(name, None)


@pytest.fixture
def walk(rng, monkeypatch):
    walk = walk_of(two_laps(rng, noise=0.5))
    monkeypatch.setattr(place_methods, "METHODS", {"embedding": Contestant(EmbeddingSimilarity, 0.3)})
    monkeypatch.setattr("sim.bench.peers.place_walks.record_walks", lambda *_: iter([walk]))
    return walk


def test_a_copy_of_a_segmentation_has_equal_figures_and_no_other_row_changes():
    usual = list(sweep("home", (901,), CLOSED))
    rows = list(sweep("home", (901,), CLOSED, own={"mine": OwnSegmentation("mine", DistanceTransform())}))
    assert rows == [*usual, replace(usual[-1], method="mine")]


def test_a_copy_of_a_place_method_has_equal_figures_and_no_other_row_changes(walk):
    own = {name: Contestant(lambda: OwnPlaces("mine", Scribbling()), 0.3) for name in ("mine", "again")}
    usual, *copies = (each.row for each in compare_place_methods([walk], own))
    assert usual == next(compare_place_methods([walk])).row and usual.tp_1 > 0
    assert copies == [replace(usual, method=name) for name in own]


def test_scores_of_keyframes_that_are_not_eligible_do_not_count(walk):
    (_, found) = compare_place_methods([walk], {"all": Contestant(lambda: OwnPlaces("all", Answer(1.0 * walk.right)), 1.0)})
    (_, masked) = compare_place_methods(
        [walk], {"all": Contestant(lambda: OwnPlaces("all", Answer(walk.seen.only_eligible(1.0 * walk.right))), 1.0)}
    )
    assert walk.right.diagonal().all() and found.row == masked.row and found.row.fp_1 == 0


@pytest.mark.parametrize(
    ("value", "message"),
    [
        (FREE.T.astype(int), r"returns int64 of shape \(3, 4\); valid: an array of whole numbers of shape \(4, 3\)"),
        (FREE, "returns bool of shape"),
        (np.full((4, 3), 0.5), "returns float64 of shape"),
        (None, "returns an instance of NoneType; valid: an array"),
        (np.full((4, 3), -1), "returns -1 for a cell; valid: 1 or more"),
        (ValueError("lost"), r"raises ValueError: lost, in test_own_methods.py:\d+"),
        (SystemExit(0), "raises SystemExit: 0"),
    ],
)
def test_what_a_segmentation_must_not_return_is_named(value, message):
    with pytest.raises(OwnMethodError, match=rf"^mine: segments\(\) {message}"):
        OwnSegmentation("mine", Answer(value)).segments(FREE, 0.05)


@pytest.mark.parametrize(
    ("value", "message"),
    [
        (np.zeros((2, 2)), r"returns float64 of shape \(2, 2\); valid: an array of numbers of shape \(28, 28\)"),
        ([[1.0]], "returns an instance of list"),
        (np.full((28, 28), np.nan), "returns nan; valid: finite numbers"),
        (np.full((28, 28), np.inf), "returns inf; valid: finite numbers"),
        (np.full((28, 28), "near"), "returns <U4 of shape"),
        (KeyError("orb"), r"raises KeyError: 'orb', in test_own_methods.py:\d+"),
    ],
)
def test_what_a_place_method_must_not_return_is_named_with_the_house(value, message, walk):
    own = {"mine": Contestant(lambda: OwnPlaces("mine", Answer(value)), 0.0)}
    with pytest.raises(OwnMethodError, match=rf"^home, seed 1: mine: scores\(\) {message}"):
        list(compare_place_methods([walk], own))


def test_the_segmentation_of_the_page_and_an_instance_have_rows(own_modules, monkeypatch, capsys):
    monkeypatch.setattr(difficulty_sweep, "METHODS", {"positions alone": METHODS["positions alone"]})
    monkeypatch.setattr(
        difficulty_sweep, "DIFFICULTIES", {"openness": replace(CLOSED, values=(0.0, 0.9), methods=("positions alone",))}
    )
    with (own_modules / "my_rooms.py").open("a") as file:
        file.write("\n\nsame = WideParts()\n")
    words = [*SEGMENTING, "my_rooms:WideParts", "--segmentation", "my_rooms:same", "--out", "own.csv", "own.png"]
    assert status_of(words) == 0
    with (own_modules / "own.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [row["method"] for row in rows] == ["positions alone", "WideParts", "same"] * 2
    assert rows[1] == {**rows[2], "method": "WideParts"} and float(rows[1]["pq"]) > 0.7
    assert "WideParts" in capsys.readouterr().out and (own_modules / "own.png").exists()


def test_the_place_method_of_the_page_has_a_row_and_tuning_finds_its_least_score(own_modules, walk, capsys):
    assert status_of([*PLACING, "my_places:PairsOfViews", "--tune"]) == 0
    printed = capsys.readouterr().out
    assert "PairsOfViews" in printed and "embedding" not in printed
    answered = {}
    for least in ("", "=0.5", "=9"):
        assert status_of([*PLACING, f"my_places:PairsOfViews{least}", "--out", "own.csv", "own.png"]) == 0
        with (own_modules / "own.csv").open() as file:
            usual, own = csv.DictReader(file)
        assert (usual["method"], own["method"]) == ("embedding", "PairsOfViews")
        answered[least] = int(own["tp_1"]) + int(own["fp_1"])
    assert answered[""] == walk.seen.eligible.any(axis=1).sum() and answered[""] > answered["=0.5"] > answered["=9"] == 0


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ([*SEGMENTING, "own_faulty"], "--segmentation 'own_faulty': is no MODULE:NAME; valid: such as my_rooms:MyRooms"),
        ([*SEGMENTING, "my_rooms.py:WideParts"], "names a file; leave out .py: my_rooms:WideParts"),
        ([*SEGMENTING, "own_nowhere:A"], "cannot be imported: ModuleNotFoundError"),
        ([*SEGMENTING, "own_faulty:Missing"], "the module has no Missing"),
        (
            [*SEGMENTING, "own_faulty:Empty"],
            "Empty has no method segments(); valid: a class without arguments, or",
        ),
        ([*SEGMENTING, "own_faulty:number"], "int has no method segments()"),
        ([*SEGMENTING, "own_faulty:Greedy"], "is the class Greedy, which cannot be called without arguments"),
        ([*SEGMENTING, "own_faulty:Unlicensed"], "the class raises OSError: no licence"),
        ([*SEGMENTING, "own_faulty:Narrow"], "valid: def segments(self, free, resolution_m)"),
        ([*SEGMENTING, "own_faulty:Voronoi"], "another row of the table is named 'Voronoi'; valid: another name"),
        ([*SEGMENTING, "own_faulty:Lost", "--segmentation", "own_faulty:Lost"], "another row of the table is named 'Lost'"),
        ([*SEGMENTING, "own_faulty:lost"], "home, seed 901, at the value 0.0: lost: segments() raises ValueError: lost, in"),
        ([*PLACING, "own_faulty:Narrow"], "valid: def scores(self, seen)"),
        ([*PLACING, "own_faulty:Lost=much"], "'much' is not a finite number; valid: such as my_places:MyPlaces=0.8"),
        ([*PLACING, "own_faulty:Lost=nan"], "the score 'nan' is not a finite number"),
        ([*PLACING, "own_faulty:Lost="], "the score '' is not a finite number"),
        ([*PLACING, "own_faulty:Lost"], "home, seed 1: Lost: scores() raises ZeroDivisionError: division by zero, in"),
        ([*PLACING, "own_faulty:Lost", "--tune"], "home, seed 1: Lost: scores() raises ZeroDivisionError"),
    ],
)
def test_wrong_input_is_named_in_one_line(words, message, own_modules, walk, monkeypatch, capsys):
    few = replace(CLOSED, methods=("positions alone",))
    monkeypatch.setattr(difficulty_sweep, "DIFFICULTIES", {"openness": few})
    assert status_of(words) == 2
    printed = capsys.readouterr().err
    assert message in printed and printed.count("\n") == 1 and "Traceback" not in printed


def test_the_sweep_over_other_difficulties_takes_segmentations_too():
    words = ["bench", "sweep", "clutter", "--segmentation", "a:B", "--segmentation", "c:D"]
    assert parser().parse_args(words).segmentation == ["a:B", "c:D"]
