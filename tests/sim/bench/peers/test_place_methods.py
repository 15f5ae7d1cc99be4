"""The benchmark: every method answers the same queries, counts are summed, and files hold rows and drawings."""

import csv
from dataclasses import replace

import numpy as np
import pytest
from helpers.two_laps import two_laps, walk_of

from sim.baselines.places import EmbeddingSimilarity, SequenceMatching
from sim.bench.peers import place_methods as module
from sim.bench.peers.place_methods import Contestant, compare_place_methods, equally_often, totals
from sim.bench.peers.place_picture import write_places
from sim.bench.peers.place_tuning import SettingsSearch
from sim.cli import main


@pytest.fixture
def found(rng, monkeypatch):
    methods = {"embedding": Contestant(EmbeddingSimilarity, 0.3), "sequences": Contestant(SequenceMatching, 0.3)}
    monkeypatch.setattr(module, "METHODS", methods)
    return list(compare_place_methods(walk_of(two_laps(rng, noise=0.5)) for _ in range(3)))


def test_totals_are_sums_over_walks_and_recalls_are_means(found):
    assert [each.row.method for each in found] == ["embedding", "sequences"] * 3
    for name, total in totals(found)["home"].items():
        rows = [each.row for each in found if each.row.method == name]
        assert total.counts[0].tp == sum(row.tp_1 for row in rows) and total.counts[2].fp == sum(row.fp_5 for row in rows)
        assert total.counts[0].possible == 3 * rows[0].possible_1 and sum(total.false_places) == total.counts[0].fp
        assert total.recalls[1] == pytest.approx(np.mean([row.recall_at_3 for row in rows]))


def test_with_equally_many_answers_the_counts_of_both_methods_have_equal_sums(found):
    equal, own = equally_often(found)["home"], totals(found)["home"]
    assert list(equal) == ["sequences"]
    for ours, others in zip(equal["sequences"], own["sequences"].counts, strict=True):
        assert ours.tp + ours.fp == others.tp + others.fp and ours.possible == others.possible


def test_a_method_with_as_many_answers_as_it_gave_keeps_its_counts(found):
    for name, total in totals(found)["home"].items():
        mine = [each for each in found if each.row.method == name]
        kept = [each.counts_of(each.answered) for each in mine]
        assert [sum(counts[k].tp for counts in kept) for k in range(3)] == [each.tp for each in total.counts]
        assert [sum(counts[k].fp for counts in kept) for k in range(3)] == [each.fp for each in total.counts]


def test_the_queries_with_the_best_scores_are_answered_first(found):
    for each in found:
        best = np.sort(each.best)[::-1]
        for answered in (0, 1, 5, 9):
            taken = np.isin(each.best, best[:answered])
            assert taken.sum() == answered
            for n, counts in zip((1, 3, 5), each.counts_of(answered), strict=True):
                assert counts.tp == (each.hits[taken] >= n).sum() and counts.tp + counts.fp == answered
        assert each.counts_of(1000)[0].tp + each.counts_of(1000)[0].fp == np.isfinite(each.best).sum()


def test_files_hold_the_rows_and_drawings(found, tmp_path):
    for name in ("rows.csv", "plot.png", "plot.svg"):
        write_places(found, tmp_path / name)
    with (tmp_path / "rows.csv").open() as file:
        assert [row["tp_1"] for row in csv.DictReader(file)] == [str(each.row.tp_1) for each in found]
    assert (tmp_path / "plot.png").read_bytes().startswith(b"\x89PNG") and "<svg" in (tmp_path / "plot.svg").read_text()


@pytest.mark.parametrize(("options", "shown"), [((), "look-alike room"), (("--tune",), "least score")])
def test_the_command_prints_what_was_found_on_the_walks(found, options, shown, rng, monkeypatch, tmp_path, capsys):
    walks = [walk_of(two_laps(rng, noise=0.5)) for _ in range(2)]
    monkeypatch.setattr("sim.bench.peers.place_walks.record_walks", lambda presets, seeds, length_m, rate_hz: iter(walks))
    monkeypatch.setattr("sim.bench.peers.place_tuning.SEARCHES", {"sequences": SettingsSearch(SequenceMatching)})
    files = () if options else ("--out", str(tmp_path / "rows.csv"))
    assert main(["bench", "fig5", "--presets", "home", "--houses", "2", *files, *options]) == 0
    printed = capsys.readouterr().out
    assert shown in printed and "sequences" in printed and (tmp_path / "rows.csv").exists() == (not options)


@pytest.mark.filterwarnings("error")
def test_without_a_revisit_there_is_no_recall_and_no_precision(found, rng, monkeypatch, tmp_path, capsys):
    walk = walk_of(two_laps(rng, noise=0.5))
    never = replace(walk, right=np.zeros_like(walk.right))
    monkeypatch.setattr("sim.bench.peers.place_walks.record_walks", lambda *_: iter([never]))
    assert main(["bench", "fig5", "--houses", "1", "--out", str(tmp_path / "rows.csv")]) == 0
    printed = capsys.readouterr().out
    assert "nan" not in printed and "0.00" not in printed and printed.count("– / – / –") == 2
    assert all(line.endswith(",,,") for line in (tmp_path / "rows.csv").read_text().splitlines()[1:])


def test_tuning_writes_no_files(tmp_path, capsys):
    assert main(["bench", "fig5", "--tune", "--out", str(tmp_path / "rows.csv")]) == 2
    assert "valid: --tune without --out" in capsys.readouterr().err
