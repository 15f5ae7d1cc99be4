"""The benchmark of growth: what it measures, and that a map grows with the area and not with the number of laps."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from helpers.same_map import assert_same

from lexis.config import Config, PoseGraphConfig
from lexis.map.folder import load_map, save_map
from lexis.map.relabelling import relabel
from lexis.maths.se3 import between
from lexis.merging import merge
from lexis.planning import plan
from lexis.slam import Slam
from lexis.types import LoopEdge
from lexis.verification import Verification
from sim.bench.scale import LAP_M, map_bytes, measure_scale
from sim.feature_sensor.oracle import Oracle
from sim.harness import Scenario, evaluate, run
from sim.harness.adapters import Lexis
from worlds.presets import sample_house

RETIRED_BYTES = 750
"""Upper bound for the size of a retired keyframe in a map."""


def test_portions_cover_the_walk_and_the_size_is_that_of_the_saved_map(tmp_path):
    portions, finished = measure_scale(rooms=3, length_m=30.0, seed=302)
    assert portions[0].first == 0 and len(finished.keyframes) - 3 <= portions[-1].last < len(finished.keyframes)
    assert all(before.last + 1 == after.first for before, after in pairwise(portions))
    assert all(portion.keyframe_ms > 0 for portion in portions)
    save_map(finished, tmp_path / "map")
    with np.load(tmp_path / "map" / "arrays.npz") as arrays:
        stored = sum(array.nbytes for array in arrays.values())
    assert map_bytes(finished) == stored and 0.8 * stored < portions[-1].map_bytes < stored
    assert portions[-1].active == portions[-1].last + 1


def test_a_walk_too_short_for_a_keyframe_at_every_mark_is_measured_all_the_same():
    portions, finished = measure_scale(rooms=3, length_m=1.0, seed=302)
    assert portions and portions[-1].last < len(finished.keyframes)


def test_laps_repeat_one_circuit():
    _, finished = measure_scale(rooms=3, length_m=1.0, seed=302, laps=2)
    steps = np.linalg.norm(np.diff(finished.T_W_B[:, :3, 3], axis=0), axis=1)
    assert abs(steps.sum() - 2 * LAP_M) < 0.1 * 2 * LAP_M


@pytest.fixture(scope="module")
def walked():
    """Ten laps through a small house, by a LEXIS whose keyframes retire, and by one whose keyframes do not."""
    house = sample_house("home", 302, rooms=4)
    scenario = Scenario(
        house=house,
        seed=302,
        fidelity="features",
        encoder="oracle",
        frame_rate_hz=2.0,
        tour_kind="loop",
        length_m=10 * LAP_M,
    )
    graphs = PoseGraphConfig(retire_above=0), PoseGraphConfig(copies=None)
    slams = [Lexis("oracle", Config(pose_graph=graph)) for graph in graphs]
    return [(run(scenario, slam), slam) for slam in slams]


@pytest.fixture(scope="module")
def thinned(walked):
    return walked[0][1].map


def retired(lexis_map):
    return [keyframe for keyframe in lexis_map.keyframes if keyframe.anchor is not None]


def active(lexis_map):
    return [keyframe for keyframe in lexis_map.keyframes if keyframe.anchor is None]


def test_many_keyframes_retire_and_the_map_is_nearly_the_same(walked):
    (finished, thin), (_, whole) = walked
    assert len(retired(thin.map)) > 0.5 * len(thin.map.keyframes) and not retired(whole.map)
    apart = np.linalg.norm(thin.map.T_W_B[:, :3, 3] - whole.map.T_W_B[:, :3, 3], axis=1)
    drift = np.linalg.norm(finished.odometry_poses[:, :3, 3] - whole.map.T_W_B[:, :3, 3], axis=1)
    assert apart.max() < 0.15 < 0.2 * drift.max()
    assert (thin.map.labels == whole.map.labels).mean() > 0.95
    assert (thin.map.floors == whole.map.floors).all()


def test_landmarks_loops_candidates_and_spaces_are_those_of_active_keyframes(walked):
    _, slam = walked[0]
    kept = {keyframe.id for keyframe in active(slam.map)}
    assert {keyframe.id for keyframe in slam.map.keyframes if len(keyframe.points)} <= kept
    assert {loop.query for loop in slam.map.loops} | {query for query, _ in slam.map.candidates} <= kept
    assert {decision.query for decision in slam.map.decisions} <= kept
    spaces = slam._running._spaces
    assert [id for id, views in enumerate(spaces) if sum(len(view.weights) for view in views)] == sorted(kept)


def test_the_estimates_contain_what_retired_keyframes_have_given_up(walked):
    (finished, slam), (whole, _) = walked
    estimates = finished.estimate
    assert [query for query, _ in estimates.candidates] == list(range(len(slam.map.keyframes)))
    proposed = {(query, match) for query, matches in estimates.candidates for match in matches}
    accepted = {(decision.query, decision.match) for decision in estimates.decisions if decision.accepted}
    assert {(decision.query, decision.match) for decision in estimates.decisions} == proposed
    loops = list(zip(estimates.loops.query.tolist(), estimates.loops.match.tolist(), strict=True))
    assert set(loops) == accepted and len(loops) == len(accepted) > 2 * len(slam.map.loops)
    weights = dict(zip(loops, estimates.loops.weights.tolist(), strict=True))
    kept = [weights[loop.query, loop.match] for loop in slam.map.loops]
    np.testing.assert_array_equal(kept, slam.map.loop_weights)
    recalls = [evaluate(each).loops.recall for each in (finished, whole)]
    assert min(recalls) > 0.9 and abs(recalls[0] - recalls[1]) < 0.05


def test_a_retired_keyframe_takes_few_bytes(walked):
    thin, whole = (slam.map for _, slam in walked)
    of_active = map_bytes(whole) / len(whole.keyframes)
    assert map_bytes(thin) < 1.1 * of_active * len(active(thin)) + RETIRED_BYTES * len(retired(thin))
    assert 0.25 * of_active > RETIRED_BYTES


def test_the_thinned_map_is_saved_and_loaded_relabelled_and_planned_in(thinned, tmp_path):
    save_map(thinned, tmp_path / "map")
    loaded = load_map(tmp_path / "map")
    assert_same(replace(loaded, stage_seconds={}), replace(thinned, stage_seconds={}))
    again = relabel(loaded, loaded.room_names, Oracle())
    np.testing.assert_array_equal(again.labels, thinned.labels)
    np.testing.assert_allclose(again.similarities, thinned.similarities, atol=1e-12)
    first, last = thinned.rooms[0], thinned.rooms[-1]
    assert plan(loaded, first.label, last.label).length_m == plan(thinned, first.label, last.label).length_m


def test_a_session_that_continues_the_map_begins_with_the_same_map(thinned):
    continued = Slam(thinned.camera, Oracle(), thinned.room_names, map=thinned).snapshot()
    for name in ("keyframes", "rooms", "labels", "floors", "loops", "candidates", "decisions"):
        assert_same(getattr(continued, name), getattr(thinned, name))
    np.testing.assert_allclose(continued.T_W_B, thinned.T_W_B, atol=1e-9)


def test_a_merged_map_in_which_more_keyframes_retire_can_be_saved_and_loaded(walked, tmp_path):
    (finished, slam), _ = walked
    truth, count, graph = finished.true_poses, len(slam.map.keyframes), PoseGraphConfig(retire_above=0)

    def verify_by_truth(query, candidates, graph, camera, config):
        T_match_query = [between(truth[candidate % count], truth[query.id % count]) for candidate in candidates]
        found = [(i, T) for i, T in zip(candidates, T_match_query, strict=True) if np.linalg.norm(T[:3, 3]) < 1.0]
        return Verification(tuple(LoopEdge(query.id, i, T, 1e-3 * np.eye(6), 50) for i, T in found), ())

    merged = merge(slam.map, slam.map, Oracle(), Config(pose_graph=graph), verify_by_truth)
    standing = {keyframe.id for keyframe in active(merged)}
    assert {keyframe.anchor for keyframe in retired(merged)} <= standing
    assert len(standing) < 1.5 * len(active(slam.map))
    save_map(merged, tmp_path / "map")
    assert len(load_map(tmp_path / "map").keyframes) == 2 * count


def test_keyframes_of_a_merged_map_stay_retired(thinned):
    merged, count = merge(thinned, thinned, Oracle()), len(thinned.keyframes)
    for own, before in zip(merged.keyframes[count:], thinned.keyframes, strict=True):
        assert own.anchor == (None if before.anchor is None else before.anchor + count)
    ids = [keyframe.id for keyframe in retired(thinned)]
    anchors = [keyframe.anchor for keyframe in retired(thinned)]
    for shift in (0, count):
        relative = [
            np.linalg.inv(T[np.add(anchors, first)]) @ T[np.add(ids, first)]
            for T, first in ((merged.T_W_B, shift), (thinned.T_W_B, 0))
        ]
        np.testing.assert_allclose(*relative, atol=1e-9)
