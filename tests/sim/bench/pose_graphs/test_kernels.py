"""Kernels against injected loops: without them all kernels agree, and the robust kernels withstand them."""

import csv
from dataclasses import fields, replace
from itertools import product

import numpy as np
import pytest

from lexis.config import Config, PoseGraphConfig, VerificationConfig
from lexis.evaluation.loops import true_edges
from lexis.maths.se3 import between, exp, inverse, log
from lexis.types import NO_FEATURES, NO_LANDMARKS, Keyframe, LoopArrays, LoopEdge
from sim.bench.pose_graphs import kernels as module
from sim.bench.pose_graphs.injected_loops import GROUP, KINDS, injected
from sim.bench.pose_graphs.kernels import (
    KERNELS,
    KernelRow,
    MappedHouse,
    draw_kernels,
    kernel_runs,
    mapped_houses,
    summarised,
)
from sim.bench.row_files import PICTURES, check_files, write_rows
from sim.errors import SimError
from sim.harness import Scenario
from sim.harness.adapters import Lexis
from worlds.presets import sample_house

SIGMAS = np.repeat([0.01, 0.03], 3)


@pytest.fixture(scope="module")
def house():
    """Two laps on a circle with noisy odometry, and true loops from lap to lap."""
    rng, count, laps = np.random.default_rng(0), 100, 2
    true = np.array([exp(np.array([0, 0, 2 * np.pi * laps * k / count, 0, 0, 0])) for k in range(count)])
    true[:, :2, 3] = 4 * true[:, :2, 0]
    steps = between(true[:-1], true[1:]) @ exp(rng.normal(size=(count - 1, 6)) * SIGMAS)
    odometry = [true[0]]
    for step in steps:
        odometry.append(odometry[-1] @ step)
    nothing = (
        NO_FEATURES,
        NO_LANDMARKS,
    )
    unit = np.array([1.0], np.float32)
    keyframes = tuple(Keyframe(k, k, float(k), pose, np.diag(SIGMAS**2), unit, *nothing) for k, pose in enumerate(odometry))
    loops = tuple(
        LoopEdge(k + 50, k, between(true[k], true[k + 50]) @ exp(rng.normal(size=6) * SIGMAS), np.diag(SIGMAS**2), 40)
        for k in range(0, 50, 2)
    )
    return MappedHouse(0, keyframes, loops, np.ones(len(loops), bool), true)


@pytest.fixture(scope="module")
def runs(house):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(module, "SHARES", (0.0, 0.5))
        return list(kernel_runs(house))


def test_without_injected_loops_all_kernels_agree_within_a_centimetre(runs):
    clean = [run for run in runs if run.share == 0.0]
    assert len(clean) == len(KINDS) * len(KERNELS)
    assert np.ptp([run.ate_m for run in clean]) < 0.01
    assert all(run.true_rejected == 0.0 for run in clean if run.kernel in ("dcs", "none"))
    assert all(run.false_trusted is None for run in clean)


def test_robust_kernels_withstand_half_of_false_loops_that_spoil_least_squares(runs):
    rows = {(row.kind, row.share, row.kernel): row for row in summarised(runs)}
    assert len(rows) == len(KINDS) * 2 * len(KERNELS)
    for kind in KINDS:
        assert rows[kind, 0.5, "dcs"].growth < 0.2 and rows[kind, 0.5, "gnc"].growth < 0.2
        assert rows[kind, 0.5, "none"].growth > 2.0 and rows[kind, 0.5, "none"].false_trusted == 1.0
        assert rows[kind, 0.5, "dcs"].false_trusted < 0.1


class HastyLexis(Lexis):
    """LEXIS whose keyframes retire as soon as its settings allow."""

    def __init__(self, config=None):
        graph = (config or Config()).pose_graph
        super().__init__("oracle", Config(pose_graph=replace(graph, retire_above=0, copies=graph.copies and 1)))


def test_hardly_any_true_loop_is_rejected_on_a_walk_on_which_keyframes_could_retire(monkeypatch):
    house = sample_house("home", 302, rooms=3)
    fast = {"fidelity": "features", "encoder": "oracle", "frame_rate_hz": 2.0}
    walk = Scenario(house=house, seed=302, tour_kind="loop", length_m=200.0, **fast)
    monkeypatch.setattr(module, "for_seeds", lambda *_: [walk])
    monkeypatch.setattr(module, "Lexis", HastyLexis)
    monkeypatch.setattr(module, "SHARES", (0.0,))
    (mapped,) = mapped_houses("home", [302])
    assert len(mapped.loops) == len(mapped.is_true) > 50 and mapped.is_true.mean() > 0.9
    assert all(run.true_rejected < 0.02 for run in kernel_runs(mapped) if run.kernel == "dcs")


def test_houses_are_mapped_with_the_given_settings_but_no_keyframe_retires(monkeypatch):
    made = []
    monkeypatch.setattr(module, "Lexis", lambda config: made.append(config))
    monkeypatch.setattr(module, "for_seeds", lambda *_: [])
    settings = Config(verification=VerificationConfig(max_contradiction=16.8), pose_graph=PoseGraphConfig(every=7))
    assert not list(mapped_houses("home", [302], settings))
    assert made == [replace(settings, pose_graph=PoseGraphConfig(every=7, copies=None))]


def test_graphs_are_optimised_with_the_given_settings(house, monkeypatch):
    monkeypatch.setattr(module, "SHARES", (0.0,))
    strict = [run for run in kernel_runs(house, PoseGraphConfig(outlier_threshold=1e-6)) if run.kernel == "dcs"]
    assert strict and all(run.true_rejected > 0.5 for run in strict)


@pytest.mark.parametrize("kind", KINDS)
def test_injected_loops_are_false_and_as_many_as_wanted(house, kind, rng):
    loops = injected(kind, 33, house.true_poses, house.loops, rng)
    edges = LoopArrays.of(loops)
    assert len(loops) == 33 and (edges.match < edges.query).all()
    assert not true_edges(edges.query, edges.match, edges.T_match_query, house.true_poses).any()
    apart = np.linalg.norm(house.true_poses[edges.match, :3, 3] - house.true_poses[edges.query, :3, 3], axis=1)
    assert (apart < 3).all() if kind == "local" else np.median(apart) > 3


def test_the_loops_of_a_cluster_agree_with_each_other(house, rng):
    loops = injected("grouped", GROUP, house.true_poses, house.loops, rng)
    true = house.true_poses
    moved = [true[a.match] @ a.T_match_query @ inverse(true[a.query]) for a in loops]
    there = [each @ true[loop.query] for loop, each in zip(loops, moved, strict=True)]
    first = [moved[0] @ true[loop.query] for loop in loops]
    assert np.linalg.norm(log(between(np.array(first), np.array(there))), axis=1).max() < 0.4
    assert np.ptp([a.query - a.match for a in loops]) == 0


def test_walks_without_a_pair_that_fits_get_no_false_loops(house, rng):
    assert injected("local", 5, np.tile(np.eye(4), (50, 1, 1)), house.loops, rng) == []
    assert injected("random", 5, house.true_poses, [], rng) == []


def test_a_house_into_whose_graph_no_false_loops_can_be_injected_has_rows_without_them_only(house):
    alone = replace(house, loops=(), is_true=np.zeros(0, bool))
    few = replace(house, loops=house.loops[:1], is_true=house.is_true[:1])  # 10 % of one loop are no loop
    for unlike, shares in ((alone, {0.0}), (few, {0.0, 0.4, 0.5})):
        runs = list(kernel_runs(unlike))
        assert {run.share for run in runs} == shares and {run.kind for run in runs} == set(KINDS)
    together = [*kernel_runs(alone), *kernel_runs(replace(few, seed=1))]
    rows = list(summarised(together))
    assert {row.share: row.houses for row in rows} == {0.0: 2, 0.4: 1, 0.5: 1}
    assert [(row.kind, row.share, row.kernel) for row in rows] == list(product(KINDS, (0.0, 0.4, 0.5), KERNELS))


def test_a_house_without_loops_has_no_share_of_rejected_loops(house, runs):
    alone = list(kernel_runs(replace(house, seed=1, loops=(), is_true=np.zeros(0, bool))))
    assert all(run.true_rejected is run.false_trusted is None for run in alone)
    for with_loops, with_both in zip(summarised(runs), summarised([*runs, *alone]), strict=True):
        for name in ("true_rejected", "true_rejected_std", "false_trusted", "houses_without_rejected_true_loops"):
            assert getattr(with_both, name) == getattr(with_loops, name)


def test_a_walk_of_two_keyframes_has_no_ate(house, runs, tmp_path):
    brief = replace(house, seed=1, keyframes=house.keyframes[:2], true_poses=house.true_poses[:2])
    found = list(kernel_runs(replace(brief, loops=(), is_true=np.zeros(0, bool))))
    assert found and {run.ate_m for run in found} == {None}
    for row, usual in zip(summarised([*runs, *found]), summarised(runs), strict=True):
        assert (row.ate_m, row.ate_std_m, row.growth) == (usual.ate_m, usual.ate_std_m, usual.growth)
    rows = list(summarised(found))
    assert {(row.ate_m, row.ate_std_m, row.growth, row.houses_without_rejected_true_loops) for row in rows} == {(None,) * 4}
    draw_kernels(rows, tmp_path / "nothing.svg")


def test_rows_become_a_csv_file_and_pictures(runs, tmp_path):
    rows = list(summarised(runs))
    with pytest.raises(SimError, match="there are no rows to write"):
        write_rows([], tmp_path / "rows.csv")
    write_rows(rows, tmp_path / "rows.csv")
    with (tmp_path / "rows.csv").open() as file:
        read = list(csv.DictReader(file))
    assert [row["kernel"] for row in read] == [row.kernel for row in rows]
    assert list(read[0]) == [field.name for field in fields(KernelRow)]
    for name, start in (("a.png", b"\x89PNG"), ("a.svg", b"<?xml")):
        check_files(tmp_path / name)
        draw_kernels(rows, tmp_path / name)
        assert (tmp_path / name).read_bytes().startswith(start)
    check_files(tmp_path / "rows.csv", None)
    draw_kernels(rows, tmp_path / "capitals.SVG")
    assert (tmp_path / "capitals.SVG").read_bytes() == (tmp_path / "a.svg").read_bytes()
    for name in ("a.pdf", "nowhere/a.png", "nowhere/a.csv", "."):
        with pytest.raises(SimError, match="valid"):
            check_files(tmp_path / name)
    for name, valid in (("a.csv", PICTURES), ("a.png", (".csv",))):
        with pytest.raises(SimError, match=f"valid: a name that ends in {' or '.join(valid)}"):
            check_files(tmp_path / name, valid=valid)
