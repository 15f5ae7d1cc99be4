"""Benchmarks on walks that are so long that keyframes retire: their figures cover the loops of all keyframes."""

import numpy as np
import pytest

from lexis.config import Config, PoseGraphConfig
from sim.bench.rigs import _row
from sim.bench.segmentation import run_houses
from sim.harness import Scenario, run
from sim.harness.adapters import Lexis
from worlds.presets import sample_house

THIN = Config(pose_graph=PoseGraphConfig(retire_above=0, copies=1))
WHOLE = Config(pose_graph=PoseGraphConfig(copies=None))


@pytest.fixture(scope="module")
def walk():
    house = sample_house("home", 302, rooms=3)
    fast = {"fidelity": "features", "encoder": "oracle", "frame_rate_hz": 2.0}
    return Scenario(house=house, seed=303, tour_kind="loop", length_m=160.0, **fast)


def test_figures_of_segmentation_cover_retired_keyframes(walk):
    (_, thin), (_, whole) = (next(run_houses(walk, [303], settings=settings)) for settings in (THIN, WHOLE))
    assert thin.loop_recall == pytest.approx(whole.loop_recall, abs=0.05) and whole.loop_recall > 0.9
    assert thin.false_loops == whole.false_loops == 0


def test_figures_of_rigs_cover_retired_keyframes(walk):
    slam = Lexis("oracle", THIN)
    finished = run(walk, slam)
    row = _row(finished, "front", slam)
    assert any(keyframe.anchor is not None for keyframe in slam.map.keyframes)
    assert row.trusted > len(slam.map.loops) and row.false == 0


def test_loops_that_the_map_still_contains_keep_the_weights_of_the_map(walk, monkeypatch):
    monkeypatch.setattr("lexis.graph.pose_graph.loop_weights", lambda poses, loops, config: np.full(len(loops), 0.625))
    slam = Lexis("oracle", THIN)
    estimated = run(walk, slam).estimate.loops
    held = {(loop.query, loop.match) for loop in slam.map.loops}
    is_held = np.array([pair in held for pair in zip(estimated.query.tolist(), estimated.match.tolist(), strict=True)])
    assert is_held.any() and not is_held.all()
    assert (estimated.weights[is_held] == 0.625).all() and (estimated.weights[~is_held] != 0.625).all()
