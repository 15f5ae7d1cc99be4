"""Several systems on one walk estimate what each of them estimates alone."""

from dataclasses import replace

import numpy as np
from helpers.open_flat import OPEN_FLAT

from lexis.config import PAPER, Config, PoseGraphConfig
from sim.bench.peers.side_by_side import run_side_by_side
from sim.harness import Scenario, run
from sim.harness.adapters import GeometricRooms, Lexis, OdometryOnly
from worlds.presets import sample_house

FAR_APART = replace(PAPER, keyframes=replace(PAPER.keyframes, spacing_m=1.0))
SLAMS = {
    "odometry": OdometryOnly,
    "rooms": GeometricRooms,
    "LEXIS": lambda: Lexis("oracle", PAPER),
    "LEXIS, other rooms and loops": lambda: Lexis("oracle"),
    "LEXIS, other keyframes": lambda: Lexis("oracle", FAR_APART),
}


def test_systems_side_by_side_estimate_what_they_estimate_alone():
    together = run_side_by_side(OPEN_FLAT, {name: make() for name, make in SLAMS.items()})
    assert list(together) == list(SLAMS)
    for name, make in SLAMS.items():
        alone = run(OPEN_FLAT, make()).estimate
        assert (together[name].estimate.frames == alone.frames).all()
        for estimate in ("T_W_B", "labels", "rooms", "floors"):
            mine, other = getattr(together[name].estimate, estimate), getattr(alone, estimate)
            assert (mine is None and other is None) or np.array_equal(mine, other)


def test_keyframes_that_retire_in_one_system_stay_in_the_others():
    house = sample_house("home", 302, rooms=3)
    fast = {"fidelity": "features", "encoder": "oracle", "frame_rate_hz": 2.0}
    walk = Scenario(house=house, seed=302, tour_kind="loop", length_m=160.0, **fast)
    graphs = {"thin": PoseGraphConfig(retire_above=0, copies=1), "whole": PoseGraphConfig(copies=None)}
    slams = {name: Lexis("oracle", Config(pose_graph=graph)) for name, graph in graphs.items()}
    together = run_side_by_side(walk, slams)
    assert any(keyframe.anchor is not None for keyframe in slams["thin"].map.keyframes)
    for name, graph in graphs.items():
        estimated, alone = together[name].estimate, run(walk, Lexis("oracle", Config(pose_graph=graph))).estimate
        assert estimated.candidates == alone.candidates and estimated.decisions == alone.decisions
        for estimate in ("frames", "T_W_B", "labels", "rooms", "floors", "similarities"):
            assert np.array_equal(getattr(estimated, estimate), getattr(alone, estimate))
        for part in ("query", "match", "T_match_query", "weights"):
            assert np.array_equal(getattr(estimated.loops, part), getattr(alone.loops, part))


def test_each_run_has_its_own_system():
    slams = {name: make() for name, make in SLAMS.items()}
    assert all(found.slam is slams[name] for name, found in run_side_by_side(OPEN_FLAT, slams).items())
