from dataclasses import replace

import numpy as np
import pytest

from lexis.config import PoseGraphConfig
from lexis.errors import LexisError
from lexis.graph.pose_graph import PoseGraph
from lexis.maths import se3
from lexis.types import NO_FEATURES, NO_LANDMARKS, Keyframe, LoopEdge

STEP_COVARIANCE = np.diag(np.repeat([0.01, 0.03], 3) ** 2)
LOOP_COVARIANCE = np.diag(np.repeat([0.005, 0.02], 3) ** 2)


@pytest.fixture
def odometry(rng):
    """Odometry of 30 poses that starts at an arbitrary pose."""
    steps = se3.exp(rng.normal([0, 0, 0.2, 0.5, 0, 0], [0.02, 0.02, 0.1, 0.05, 0.02, 0.02], (30, 6)))
    T = [se3.exp(rng.normal(size=6))]
    for step in steps[1:]:
        T.append(T[-1] @ step)
    return np.stack(T)


def graph_of(T_O_B, config=None):
    graph = PoseGraph(config or PoseGraphConfig())
    for i, T in enumerate(T_O_B):
        graph.add_keyframe(Keyframe(i, i, float(i), T, STEP_COVARIANCE, np.ones(1, np.float32), NO_FEATURES, NO_LANDMARKS))
    return graph


def loop(match, query, T_O_B, shift_m=0.1):
    shift = se3.exp(np.array([0.0, 0.0, 0.0, shift_m, 0.0, 0.0]))
    return LoopEdge(query, match, se3.between(T_O_B[match], T_O_B[query]) @ shift, LOOP_COVARIANCE, 50)


def test_without_loops_the_estimate_is_the_odometry(odometry):
    graph = graph_of(odometry)
    assert not graph.optimise_if_due(final=True)
    np.testing.assert_allclose(graph.T_W_B, odometry, atol=1e-12)
    np.testing.assert_allclose(graph.path_m[-1], np.linalg.norm(np.diff(odometry[:, :3, 3], axis=0), axis=1).sum())


def test_an_optimised_graph_grows_on_by_odometry_and_stays_anchored(odometry):
    graph = graph_of(odometry[:20])
    graph.add_loops([loop(0, 19, odometry)])
    assert graph.optimise_if_due()
    for one in graph_of(odometry).keyframes[20:]:
        graph.add_keyframe(one)
    np.testing.assert_allclose(graph.T_W_B[0], odometry[0], atol=1e-6)
    assert np.linalg.norm(graph.T_W_B[19] - odometry[19]) > 0.02
    np.testing.assert_allclose(
        se3.between(graph.T_W_B[19:-1], graph.T_W_B[20:]), se3.between(odometry[19:-1], odometry[20:]), atol=1e-9
    )


def test_optimisation_waits_for_enough_keyframes_unless_it_is_the_last(odometry):
    graph = graph_of(odometry[:20], PoseGraphConfig(every=10))
    graph.add_loops([loop(0, 19, odometry)])
    assert graph.optimise_if_due()
    graph.add_loops([loop(1, 18, odometry)])
    assert not graph.optimise_if_due()
    assert graph.optimise_if_due(final=True)
    assert not graph.optimise_if_due(final=True)  # nothing has been added since


def test_weights_are_one_per_loop_and_low_for_what_does_not_fit(odometry):
    graph = graph_of(odometry)
    graph.add_loops([loop(0, 25, odometry, 0.01), loop(3, 28, odometry, 5.0)])
    graph.optimise_if_due(final=True)
    good, bad = graph.loop_weights
    assert good > 0.9
    assert bad < 0.1


def laps(rng, count):
    """Drifting odometry of `count` poses on a circle of 40 poses, and true loops to the lap before, every third keyframe."""
    step = se3.exp(np.array([0.0, 0.0, 2 * np.pi / 40, 0.5, 0.0, 0.0]))
    noise = se3.exp(rng.multivariate_normal(np.zeros(6), 0.04 * STEP_COVARIANCE, count))
    T = [np.eye(4)]
    for error in noise[1:]:
        T.append(T[-1] @ step @ error)
    loops = {query: LoopEdge(query, query - 40, np.eye(4), LOOP_COVARIANCE, 50) for query in range(40, count, 3)}
    return np.stack(T), loops


def test_optimising_windows_ends_at_the_same_map_as_optimising_the_whole_graph(rng):
    T_O_B, loops = laps(rng, 300)
    loops[151] = LoopEdge(151, 20, se3.exp(np.array([0.0, 0.0, 1.0, 3.0, 1.0, 0.0])), LOOP_COVARIANCE, 50)
    windows, whole = PoseGraphConfig(growth=0.3, window=30, copies=None), PoseGraphConfig(growth=0.0, copies=None)
    graphs = PoseGraph(windows), PoseGraph(whole)
    for one in graph_of(T_O_B).keyframes:
        for graph in graphs:
            graph.add_keyframe(one)
            graph.add_loops([loops[one.id]] if one.id in loops else [])
            graph.optimise_if_due()
    worst = np.linalg.norm(graphs[0].T_W_B[:, :3, 3] - graphs[1].T_W_B[:, :3, 3], axis=1).max()
    assert 1e-3 < worst < 0.5  # windows are an approximation, until the end
    for graph in graphs:
        assert graph.optimise_if_due(final=True)
    a, b = (graph.T_W_B for graph in graphs)
    assert np.linalg.norm(a[:, :3, 3] - b[:, :3, 3], axis=1).max() < 1e-3
    assert se3.rotation_angle(se3.between(a, b)).max() < 1e-4
    np.testing.assert_allclose(graphs[0].loop_weights, graphs[1].loop_weights, atol=1e-3)


def test_the_finished_graph_is_optimised_as_a_whole_even_if_a_window_has_used_all_loops(rng):
    T_O_B, loops = laps(rng, 100)
    graph = graph_of(T_O_B, PoseGraphConfig(growth=0.9, window=10))
    graph.add_loops([loops[43]])
    assert graph.optimise_if_due(final=True)
    for one in graph_of(laps(rng, 120)[0]).keyframes[100:]:
        graph.add_keyframe(one)
    before = graph.T_W_B.copy()
    graph.add_loops([loops[97]])
    assert graph.optimise_if_due()
    np.testing.assert_array_equal(graph.T_W_B[:110], before[:110])
    assert graph.optimise_if_due(final=True)
    assert np.abs(graph.T_W_B[50:110] - before[50:110]).max() > 1e-3


def test_the_finished_graph_has_converged_although_optimisations_during_the_walk_end_early(rng):
    T_O_B, loops = laps(rng, 120)
    graph = graph_of(T_O_B, PoseGraphConfig(growth=0.0))  # every optimisation is of the whole graph
    graph.add_loops(list(loops.values()))
    assert graph.optimise_if_due() and graph.optimise_if_due(final=True)
    finished = graph.T_W_B.copy()
    np.testing.assert_allclose(graph._optimiser.optimise(1e-12), finished, atol=1e-4)
    assert not graph.optimise_if_due(final=True)


def walked(T_O_B, loops, config):
    """The finished graph of a walk, and the largest number of keyframes in the optimisation on the way."""
    graph, most = PoseGraph(config), 0
    for one in graph_of(T_O_B).keyframes:
        graph.add_keyframe(one)
        graph.add_loops([loops[one.id]] if one.id in loops else [])
        graph.optimise_if_due()
        most = max(most, len(graph.active))
    graph.optimise_if_due(final=True)
    return graph, most


THIN = PoseGraphConfig(window=20, growth=0.1, copies=2, retire_above=0)


def every_lap(rng, count):
    """Drifting odometry on a circle of 40 poses, and a true loop to the first lap from every keyframe."""
    return laps(rng, count)[0], {q: LoopEdge(q, q % 40, np.eye(4), LOOP_COVARIANCE, 50) for q in range(40, count)}


def test_the_optimisation_grows_with_the_area_and_not_with_the_number_of_laps(rng):
    T_O_B, loops = every_lap(rng, 800)
    few, many = (walked(T_O_B[:count], loops, THIN)[1] for count in (320, 800))
    assert many <= 1.3 * few < 320 / 2


def test_a_thinned_graph_ends_near_the_same_map(rng):
    T_O_B, loops = every_lap(rng, 400)
    thin, whole = (walked(T_O_B, loops, replace(THIN, copies=copies))[0] for copies in (2, None))
    drift = np.linalg.norm(T_O_B[:, :3, 3] - whole.T_W_B[:, :3, 3], axis=1).max()
    assert np.linalg.norm(thin.T_W_B[:, :3, 3] - whole.T_W_B[:, :3, 3], axis=1).max() < 0.25 * drift
    assert thin.loop_weights.shape == (len(thin.loops),)


def test_without_loops_no_keyframe_retires(rng):
    graph, _ = walked(every_lap(rng, 200)[0], {}, THIN)
    np.testing.assert_array_equal(graph.active, np.arange(200))


def test_a_small_graph_keeps_all_keyframes_and_loops_until_it_has_grown_enough(rng):
    T_O_B, loops = every_lap(rng, 400)
    small, _ = walked(T_O_B[:300], loops, replace(THIN, retire_above=300))
    assert len(small.active) == 300 and len(small.loops) == 260
    large, most = walked(T_O_B, loops, replace(THIN, retire_above=300))
    assert 300 < most < 400 and len(large.active) < 200


def test_retired_keyframes_follow_their_anchors(rng):
    T_O_B, loops = every_lap(rng, 240)
    graph, _ = walked(T_O_B, loops, THIN)
    ids, anchors = graph._retired.ids, graph._retired.anchors
    assert len(ids) > 50 and set(anchors.tolist()) <= set(graph.active.tolist())
    np.testing.assert_allclose(se3.between(graph.T_W_B[anchors], graph.T_W_B[ids]), graph._retired.T_anchor_B, atol=1e-9)
    assert sorted([*ids.tolist(), *graph.active.tolist()]) == list(range(240))


def test_a_keyframe_whose_anchor_has_retired_is_anchored_to_the_anchor_of_that_one(rng):
    T_O_B, loops = every_lap(rng, 240)
    graph, _ = walked(T_O_B, loops, THIN)
    gone, anchor = int(graph.retired[0]), int(graph._retired.anchors[0])
    T_gone_B = se3.exp(np.array([0.0, 0.0, 0.1, 0.2, 0.0, 0.0]))
    own = np.zeros_like(graph.keyframes[gone].embedding)
    graph.add_retired(replace(graph.keyframes[gone], id=240, anchor=gone, embedding=own), T_gone_B)
    np.testing.assert_allclose(graph.T_W_B[240], graph.T_W_B[gone] @ T_gone_B, atol=1e-12)
    assert graph.keyframes[240].anchor == anchor == graph.shown_by[240]
    np.testing.assert_array_equal(graph.keyframes[240].embedding, graph.keyframes[anchor].embedding)
    assert set(graph._retired.anchors.tolist()) <= set(graph.active.tolist())


def test_a_loop_without_a_definite_covariance_is_refused_even_if_it_does_not_act(rng):
    """A loop between a retired keyframe and its anchor takes no part in the optimisation."""
    graph, _ = walked(*every_lap(rng, 240), THIN)
    gone, anchor = int(graph.retired[0]), int(graph._retired.anchors[0])
    singular = LoopEdge(max(gone, anchor), min(gone, anchor), np.eye(4), np.zeros((6, 6)), 50)
    before = len(graph.loops)
    with pytest.raises(LexisError, match="has a singular covariance"):
        graph.add_loops([singular])
    assert len(graph.loops) == before


def test_a_loop_to_a_retired_keyframe_acts_as_a_loop_to_its_anchor(rng):
    T_O_B, loops = every_lap(rng, 240)
    trusting = replace(THIN, outlier_threshold=1e4)
    graphs = [walked(T_O_B, loops, trusting)[0] for _ in range(2)]
    gone, anchor = (int(ids[0]) for ids in (graphs[0]._retired.ids, graphs[0]._retired.anchors))
    T_anchor_gone, shift = graphs[0]._retired.T_anchor_B[0], se3.exp(np.array([0.0, 0.0, 0.05, 0.1, 0.0, 0.0]))
    before = graphs[0].T_W_B.copy()
    measured = se3.between(before[gone], before[239]) @ shift
    graphs[0].add_loops([LoopEdge(239, gone, measured, 0.01 * LOOP_COVARIANCE, 50)])
    graphs[1].add_loops([LoopEdge(239, anchor, T_anchor_gone @ measured, 0.01 * LOOP_COVARIANCE, 50)])
    for graph in graphs:
        graph.optimise_if_due(final=True)
    assert np.abs(graphs[0].T_W_B - before).max() > 0.005
    np.testing.assert_allclose(graphs[0].T_W_B, graphs[1].T_W_B, atol=1e-9)


def test_embeddings_and_loops_are_those_of_active_keyframes(rng):
    T_O_B, loops = every_lap(rng, 400)
    graph, _ = walked(T_O_B, loops, THIN)
    assert len(graph.active) < 100 and len(graph.embeddings) == len(graph.active)
    assert {loop.query for loop in graph.loops} <= set(graph.active.tolist())
    active = [keyframe.id for keyframe in graph.keyframes if keyframe.anchor is None]
    np.testing.assert_array_equal(active, graph.active)
    assert {keyframe.anchor for keyframe in graph.keyframes} - {None} <= set(active)
    np.testing.assert_array_equal(graph.shown_by[graph._retired.ids], graph._retired.anchors)


def test_a_resumed_graph_goes_on_like_the_graph_that_was_never_stopped(rng):
    T_O_B, loops = every_lap(rng, 440)
    whole, again = PoseGraph(THIN), PoseGraph(THIN)
    for one in graph_of(T_O_B).keyframes:
        if one.id == 400:
            again.resume(whole.keyframes, whole.T_W_B, whole.loops, np.zeros(1, int))
            np.testing.assert_array_equal(again.active, whole.active)
            np.testing.assert_allclose(again.T_W_B, whole.T_W_B, atol=1e-9)
            np.testing.assert_allclose(again._covariances, whole._covariances, rtol=1e-9)
        for graph in (whole, again) if one.id >= 400 else (whole,):
            graph.add_keyframe(one)
            graph.add_loops([loops[one.id]] if one.id in loops else [])
            if one.id < 400:
                graph.optimise_if_due()
    for graph in (whole, again):
        graph.optimise_if_due(final=True)
    assert len(whole.active) < 200
    np.testing.assert_allclose(again.T_W_B, whole.T_W_B, atol=1e-6)


def two_sessions(rng, config):
    """A graph of 200 keyframes on the circle, and a second session of 160 there, joined at its second keyframe."""
    T_O_B, loops = every_lap(rng, 360)
    moved = se3.exp(np.array([0.0, 0.0, 1.0, 30.0, 0.0, 0.0])) @ T_O_B
    graph = PoseGraph(config)
    for one in graph_of(T_O_B).keyframes:
        again = one.id >= 200
        graph.add_keyframe(replace(one, session=int(again), T_O_B=moved[one.id] if again else one.T_O_B))
        found = {202: (200, 202)}.get(one.id, (one.id,) * (one.id != 200))  # the first one is recognised after the second
        loop = [loops[query] for query in found if query in loops]
        if one.id == 201:
            graph.join(loop, graph.T_W_B[loop[0].match] @ loop[0].T_match_query @ se3.inverse(graph.T_W_B[201]))
        else:
            graph.add_loops(loop)
        graph.optimise_if_due()
    graph.optimise_if_due(final=True)
    return graph


def test_keyframes_of_several_sessions_retire_but_no_odometry_joins_the_sessions(rng):
    thin, whole = (two_sessions(np.random.default_rng(5), replace(THIN, copies=copies)) for copies in (2, None))
    assert len(thin.active) < 200 < len(whole.active) and {199, 200} <= set(thin.active.tolist())
    # Odometry between the sessions would tear the map apart, because it says that they are 30 m apart.
    assert np.linalg.norm(thin.T_W_B[:, :3, 3] - whole.T_W_B[:, :3, 3], axis=1).max() < 0.2
    assert np.abs(thin.T_W_B[:, :3, 3]).max() < 10.0


def test_where_the_frame_of_a_resumed_map_lies_costs_nothing(rng):
    """The relation of two sessions is unknown, and so is not a reason to stay near the frame of the odometry."""
    graph = two_sessions(rng, PoseGraphConfig())
    graph.optimise_if_due(final=True)
    shift = np.eye(4)
    shift[:2, 3] = 5e6, 3e6
    moved = PoseGraph(PoseGraphConfig())
    moved.resume(graph.keyframes, shift @ graph.T_W_B, graph.loops, np.zeros(2, int))
    assert moved._optimiser.cost == pytest.approx(graph._optimiser.cost, rel=1e-3)


def test_nothing_retires_while_the_sessions_are_not_joined(rng):
    T_O_B, loops = every_lap(rng, 200)
    graph = PoseGraph(THIN)
    for one in graph_of(T_O_B).keyframes:
        graph.add_keyframe(replace(one, session=int(one.id >= 10)))
        graph.add_loops([loops[one.id]] if one.id >= 50 and one.id % 40 >= 10 else [])
        graph.optimise_if_due()
    assert graph.is_split and len(graph.active) == 200
