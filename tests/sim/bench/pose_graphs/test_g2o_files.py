"""Pose graphs in files: both starts reach the least cost, the chordal one also where odometry does not."""

from pathlib import Path

import gtsam
import numpy as np
import pytest

from lexis.files.g2o import read_g2o
from lexis.maths.se3 import between, exp
from sim.bench.pose_graphs import g2o_files as module
from sim.bench.pose_graphs.g2o_files import KnownGraph, names_of, optimise_files, optimiser_of
from sim.errors import SimError


def written(path, rng, turn_sigma, count=60):
    """A g2o file of two laps on a circle with noisy odometry, and loops from lap to lap."""
    true = np.array([exp(np.array([0, 0, 4 * np.pi * k / count, 0, 0, 0])) for k in range(count)])
    true[:, :2, 3] = 5 * true[:, :2, 0]
    graph, values = gtsam.NonlinearFactorGraph(), gtsam.Values()
    pairs = [(k, k + 1) for k in range(count - 1)] + [(k, k + count // 2) for k in range(0, count // 2, 2)] + [(9, 3)]
    for a, b in pairs:
        sigmas = np.repeat([turn_sigma if b == a + 1 else 0.01, 0.02], 3)
        measured = between(true[a], true[b]) @ exp(rng.normal(size=6) * sigmas)
        graph.add(gtsam.BetweenFactorPose3(a, b, gtsam.Pose3(measured), gtsam.noiseModel.Diagonal.Sigmas(sigmas)))
    for k, pose in enumerate(true):
        values.insert(k, gtsam.Pose3(pose))
    gtsam.writeG2o(graph, values, str(path))
    return graph, values


def test_both_starts_reach_the_cost_that_gtsam_reaches_from_the_truth(tmp_path, rng):
    graph, values = written(tmp_path / "circle.g2o", rng, 0.03)
    graph.add(gtsam.PriorFactorPose3(0, values.atPose3(0), gtsam.noiseModel.Isotropic.Sigma(6, 1e-6)))
    least = graph.error(gtsam.LevenbergMarquardtOptimizer(graph, values).optimize())
    odometry, chordal = optimise_files([tmp_path / "circle.g2o"])
    assert (odometry.start, chordal.start) == ("odometry", "chordal") and odometry.edges == graph.size() - 1
    assert odometry.cost == pytest.approx(least, rel=1e-3) and chordal.cost == pytest.approx(least, rel=1e-3)
    assert chordal.start_cost < odometry.start_cost and odometry.excess is None
    assert chordal.iterations is not None and 0 < chordal.iterations < 20


@pytest.mark.parametrize(("poses", "excess"), [(60, 0.0), (61, None)])
def test_only_the_known_graph_is_compared_with_the_least_known_cost(poses, excess, tmp_path, rng, monkeypatch):
    path = tmp_path / "sphere2500.g2o"
    graph, _ = written(path, rng, 0.03)
    usual, _ = optimise_files([path])
    monkeypatch.setattr(module, "KNOWN", {"sphere2500": KnownGraph(poses, graph.size(), usual.cost)})
    assert usual.excess is None and all(row.excess == pytest.approx(excess, abs=1e-3) for row in optimise_files([path]))


@pytest.mark.parametrize(
    ("paths", "names"),
    [
        (["a/good.g2o", "b/grid.g2o"], ["good", "grid"]),
        (["a/good.g2o", "b/good.g2o", "b/grid.g2o"], ["a/good.g2o", "b/good.g2o", "b/grid.g2o"]),
        (["a/good.g2o", "a/good.txt"], ["good.g2o", "good.txt"]),
        (["/1/a/good.g2o", "/2/a/good.g2o"], ["1/a/good.g2o", "2/a/good.g2o"]),
        (["good.g2o", "a/good.g2o"], ["good.g2o", "a/good.g2o"]),
    ],
)
def test_names_tell_files_apart(paths, names):
    assert list(names_of([Path(path) for path in paths])) == names


def test_a_graph_that_cannot_be_solved_is_named(tmp_path, rng):
    """The stiffest edge has an information of 1e32: beside it, all other numbers are lost to rounding."""
    written(tmp_path / "stiff.g2o", rng, 0.03)
    lines = (tmp_path / "stiff.g2o").read_text().splitlines()
    triangle = " ".join("1e32" if row == column else "0" for row in range(6) for column in range(row, 6))
    stiff = f"EDGE_SE3:QUAT 3 20 1e9 0 0 0 0 0 1 {triangle}"
    (tmp_path / "stiff.g2o").write_text("\n".join([*lines, stiff]))
    with pytest.raises(SimError, match=r"stiff\.g2o: cannot be optimised: .*; valid: "):
        list(optimise_files([tmp_path / "stiff.g2o"]))


def test_a_graph_without_loops_is_solved_from_both_starts(tmp_path):
    pose = "0 0 0 0 0 0 1"
    information = " ".join("1" if k in (0, 6, 11, 15, 18, 20) else "0" for k in range(21))
    lines = [f"VERTEX_SE3:QUAT {k} {pose}" for k in (0, 1)] + [f"EDGE_SE3:QUAT 0 1 1{pose[1:]} {information}"]
    (tmp_path / "two.g2o").write_text("\n".join(lines) + "\n")
    assert [row.cost for row in optimise_files([tmp_path / "two.g2o"])] == pytest.approx([0.0, 0.0], abs=1e-12)


def test_the_chordal_start_helps_where_odometry_ends_in_a_wrong_minimum(tmp_path):
    better = 0
    for seed in range(6):
        path = tmp_path / f"wild-{seed}.g2o"
        written(path, np.random.default_rng(seed), 1.2)
        odometry, chordal = optimise_files([path])
        assert chordal.cost < 1.01 * odometry.cost
        better += chordal.cost < 0.9 * odometry.cost
    assert better


def test_graphs_without_odometry_between_all_poses_are_refused(tmp_path, rng):
    path = tmp_path / "gap.g2o"
    written(path, rng, 0.03)
    path.write_text("".join(line for line in path.read_text().splitlines(True) if " 7 8 " not in line))
    with pytest.raises(SimError, match="no edge between poses 7 and 8"):
        optimiser_of(read_g2o(path), "gap.g2o")
