"""The sweep over openness writes a row for each method, house and openness, and averages over houses."""

import csv
from pathlib import Path

import pytest

from sim.bench.peers import openness_sweep as module
from sim.bench.peers.openness_sweep import METHODS, SweepRow, check_files, means, sweep, write_sweep
from sim.errors import SimError


def test_every_method_finds_rooms_in_the_same_house(monkeypatch):
    monkeypatch.setattr(module, "METHODS", {name: METHODS[name] for name in ("positions alone", "Voronoi")})
    rows = list(sweep("home", (901,), (0.0,)))
    assert [row.method for row in rows] == ["positions alone", "Voronoi"]
    assert rows[1].pq > rows[0].pq


def test_means_are_over_the_houses_of_a_method_at_one_openness():
    rows = [SweepRow("a", 0.0, 1, 0.4, 2, 0), SweepRow("a", 0.0, 2, 0.6, 0, 1), SweepRow("b", 0.0, 1, 1.0, 0, 0)]
    found = means(rows)["a"][0.0]
    assert (found.pq, found.splits, found.merges) == (0.5, 1.0, 0.5) and found.pq_std == pytest.approx(0.1)


def test_files_hold_the_rows_and_drawings(tmp_path):
    rows = [SweepRow("a", value, 1, 0.5, 2, 0) for value in (0.0, 0.3)]
    for name in ("rows.csv", "plot.png", "plot.svg"):
        write_sweep(rows, tmp_path / name)
    with (tmp_path / "rows.csv").open() as file:
        assert [row["openness"] for row in csv.DictReader(file)] == ["0.0", "0.3"]
    assert (tmp_path / "plot.png").read_bytes().startswith(b"\x89PNG") and "<svg" in (tmp_path / "plot.svg").read_text()


@pytest.mark.parametrize("path", ["no-folder/rows.csv", "rows.txt"])
def test_unusable_files_are_refused_before_the_work(path):
    with pytest.raises(SimError, match=r"valid: "):
        check_files([Path(path)])
