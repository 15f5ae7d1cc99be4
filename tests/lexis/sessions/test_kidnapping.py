"""A robot walks laps on a circle and is carried elsewhere; a verifier that knows the truth stands in for PnP."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.box_room import FORWARD_CAMERA
from helpers.circle_encoder import CircleEncoder
from helpers.map_builder import keyframe, with_retired

from lexis.config import Config, PlaceRecognitionConfig, PoseGraphConfig, SessionConfig, VerificationConfig
from lexis.graph.components import sessions_apart
from lexis.graph.pose_graph import PoseGraph
from lexis.graph.walked_steps import carried_before, walked_steps
from lexis.maths import se3
from lexis.merging import merge
from lexis.sessions.kidnapping import find_kidnapping, strongest
from lexis.slam import Slam
from lexis.types import Features, LoopDecision, LoopEdge, Observation, Percept
from lexis.verification import plausible

LAP = 40
"""Keyframes of one lap."""
CARRIED, AWAY = 60, 8
"""Number of keyframes before the robot is carried, and keyframes of the circle that it skips: 3.8 m."""
COVARIANCE = np.diag(np.repeat([0.001, 0.003], 3) ** 2)
LOOP_COVARIANCE = np.diag(np.repeat([0.005, 0.02], 3) ** 2)
STEP = se3.exp(np.array([0.0, 0.0, 2 * np.pi / LAP, 0.501, 0.0, 0.0]))
UP = se3.exp(np.array([0.0, 0.0, 0.0, 0.0, 0.0, 3.0]))


def poses(count, moved=None):
    """Poses of keyframes on the circle; before each keyframe in `moved`, the robot is moved by the rigid motion there."""
    T = [np.eye(4)]
    for i in range(1, count):
        T.append(T[-1] @ (moved or {}).get(i, np.eye(4)) @ STEP)
    return np.stack(T)


def along(keyframes):
    """The motion along the circle to a place that is so many keyframes ahead."""
    return np.linalg.matrix_power(STEP, keyframes)


def verifier(true, false=lambda query, match: None):
    """Confirms each candidate by the truth, or 3 m beside it where `false` returns a pose of the query beside it."""

    def check(query, candidates, graph, camera, config):
        located = []
        for match in candidates:
            beside = false(query.id, match)
            if beside is None and np.linalg.norm(se3.between(true[match], true[query.id])[:3, 3]) > 2.0:
                located.append((LoopDecision(query.id, match, "few inliers"), None))
                continue
            T = se3.between(true[match], true[query.id]) if beside is None else beside
            located.append((LoopDecision(query.id, match, "accepted"), LoopEdge(query.id, match, T, LOOP_COVARIANCE, 50)))
        return plausible(located, graph, config)

    return check


def walk(true, odometry, verify, config=None):
    """Run LEXIS on a robot at the poses `true`, at which odometry estimates the poses `odometry`."""
    slam, rng = Slam(FORWARD_CAMERA, CircleEncoder(), ("office", "kitchen"), config, verify), np.random.default_rng(2)
    for i, (T_W_B, T_O_B) in enumerate(zip(true, odometry, strict=True)):
        embedding = np.array([0.3, 0.0, *T_W_B[:2, 3] / 3.2])
        percept = Percept(
            np.float32(embedding / np.linalg.norm(embedding)),
            Features(rng.uniform(0, 20, (3, 2)).astype(np.float32), rng.integers(0, 256, (3, 61), np.uint8)),
        )
        slam.process(Observation(i, 1.0 + i, percept, T_O_B, COVARIANCE))
    return slam.finish()


def test_the_map_is_right_although_the_robot_was_carried():
    true, odometry = poses(140, {CARRIED: along(AWAY)}), poses(140)
    np.testing.assert_allclose(walk(true, odometry, verifier(true)).T_W_B, true, atol=1e-3)
    assert np.linalg.norm(odometry[-1] - true[-1]) > 2.0


def test_the_images_show_the_step_if_no_loop_bridges_the_steps_around_it():
    true = poses(120, {30: along(AWAY)})  # the first lap is not complete
    np.testing.assert_allclose(walk(true, poses(120), verifier(true)).T_W_B, true, atol=1e-3)


def test_without_the_setting_the_map_follows_the_odometry():
    true, config = poses(140, {CARRIED: along(AWAY)}), Config(sessions=SessionConfig(kidnapping_agreeing=None))
    np.testing.assert_allclose(walk(true, poses(140), verifier(true), config).T_W_B, poses(140), atol=1e-3)


def test_retired_keyframes_are_corrected_too():
    true, thinned = poses(300, {130: along(AWAY)}), Config(pose_graph=PoseGraphConfig(retire_above=100))
    found = walk(true, poses(300), verifier(true), thinned)
    assert sum(keyframe.anchor is not None for keyframe in found.keyframes) > 50
    np.testing.assert_allclose(found.T_W_B, true, atol=0.02)
    assert carried_before(found).tolist() == [130]


def test_a_robot_that_is_turned_in_place_is_corrected_and_may_walk_there():
    turn = se3.exp(np.array([0.0, 0.0, np.pi / 2, 0.0, 0.0, 0.0]))
    true = poses(160, {CARRIED: turn})
    estimated = walk(true, poses(160), verifier(true))
    np.testing.assert_allclose(estimated.T_W_B, true, atol=1e-3)
    assert carried_before(estimated).tolist() == [CARRIED]
    assert (CARRIED - 1, CARRIED) in {tuple(step) for step in walked_steps(estimated).tolist()}


def test_the_loops_that_show_it_become_part_of_the_map():
    true = poses(140, {CARRIED: along(AWAY)})
    found = walk(true, poses(140), verifier(true))
    across = {(loop.query, loop.match) for loop in found.loops if loop.query >= CARRIED > loop.match}
    accepted = {(each.query, each.match) for each in found.decisions if each.outcome == "accepted"}
    assert len({query for query, _ in across}) >= 10
    assert accepted == {(loop.query, loop.match) for loop in found.loops}
    assert len(found.loops) == len(accepted)


@pytest.mark.parametrize("anchors", [{}, {59: 19, 60: 28, 61: 29}], ids=["all active", "retired where it was carried"])
def test_a_corrected_map_stays_right_when_it_is_merged_into_another_one(anchors):
    """The correction is part of the map: it does not have to be found again."""
    true = poses(140, {CARRIED: along(AWAY)})
    corrected, first = walk(true, poses(140), verifier(true)), walk(true[:30], true[:30], verifier(true))
    corrected = with_retired(corrected, anchors)

    def within_sessions(query, candidates, graph, camera, config):
        index = [keyframe.observation_index for keyframe in graph.keyframes]
        known = verifier(np.stack([true[i] for i in index]))
        return replace(known(query, candidates, graph, camera, config), far=())

    merged = merge(first, corrected, CircleEncoder(), verifier=within_sessions)
    assert sessions_apart(merged) == []
    np.testing.assert_allclose(merged.T_W_B, np.concatenate([true[:30], true]), atol=1e-3)


def test_no_plan_leads_along_the_step_in_which_the_robot_was_carried():
    true = poses(140, {CARRIED: along(4)})
    found = walk(true, poses(140), verifier(true))
    np.testing.assert_allclose(found.T_W_B, true, atol=1e-3)
    assert np.linalg.norm(true[CARRIED, :3, 3] - true[CARRIED - 1, :3, 3]) < 3.0
    walked = {tuple(step) for step in walked_steps(found).tolist()}
    assert walked == {(i, i + 1) for i in range(139)} - {(CARRIED - 1, CARRIED)}


def looks_like(queries, keyframes):
    """Each of these keyframes looks like an earlier one, so many keyframes before, and 0.2 m behind."""
    T = se3.exp(np.array([0.0, 0.0, 0.0, 0.2, 0.0, 0.0]))
    return lambda query, match: T if query in queries and query - match == keyframes else None


def assert_not_moved(true, false):
    """Many keyframes have far loops, and the map is right nevertheless."""
    candidates = PlaceRecognitionConfig(method="similarity", candidates=100, min_gap_m=4.0)
    found = walk(true, true, verifier(true, false), Config(place_recognition=candidates))
    far = {each.query for each in found.decisions if each.outcome == "far from the estimate"}
    assert len(far) >= 10
    np.testing.assert_allclose(found.T_W_B, true, atol=1e-3)


@pytest.mark.parametrize("count", [35, 80], ids=["without coming back", "coming back"])
def test_rooms_that_look_alike_do_not_move_the_map(count):
    assert_not_moved(poses(count), looks_like(range(20, 36), 20))


def test_storeys_that_look_alike_do_not_move_the_map():
    """No loop bridges the step in which the robot goes up, and each keyframe has a far loop to the storey below."""
    assert_not_moved(poses(120, {CARRIED: UP}), looks_like(range(CARRIED, 120), CARRIED))


def far_loop(query, match, T_match_query=STEP):
    return LoopEdge(query, match, T_match_query, LOOP_COVARIANCE, 50)


def graph_with(loops, far, count=60):
    graph = PoseGraph(PoseGraphConfig())
    rng = np.random.default_rng(3)
    for i, T in enumerate(poses(count)):
        graph.add_keyframe(keyframe(rng, i, T))
    graph.add_loops([far_loop(query, match, along(query - match)) for query, match in loops])
    graph.add_far_loops(59, [], far)
    return graph


def test_many_keyframes_have_to_agree():
    bridges = [(29, 0), (59, 30)]  # of all steps but one
    far = [far_loop(query, query - 30) for query in range(40, 55)]
    found = find_kidnapping(graph_with(bridges, far), 15, VerificationConfig())
    assert found is not None and found.step == 30 and list(found.loops) == far
    assert find_kidnapping(graph_with(bridges, far), 16, VerificationConfig()) is None


def test_a_loop_that_is_not_trusted_bridges_no_step():
    far = [far_loop(query, query - 30) for query in range(40, 55)]
    graph = graph_with([(29, 0), (59, 30)], far)
    graph.add_loops([far_loop(35, 20, STEP)])
    assert graph.loop_weights[-1] < 0.5
    found = find_kidnapping(graph, 15, VerificationConfig())
    assert found is not None and found.step == 30


def test_far_loops_that_fit_the_corrected_map_show_nothing():
    far = [far_loop(query, query - 30, along(30)) for query in range(40, 55)]
    assert find_kidnapping(graph_with([(29, 0), (59, 30)], far), 2, VerificationConfig()) is None


def test_a_few_false_loops_among_them_do_not_displace_the_map():
    beside = se3.exp(np.array([0.0, 0.0, 0.0, 0.0, 2.5, 0.0]))
    true = [far_loop(query, query - 30) for query in range(40, 55)]
    false = [far_loop(query, query - 30, STEP @ beside) for query in range(37, 40)]
    found = find_kidnapping(graph_with([(29, 0), (59, 30)], [*false, *true]), 15, VerificationConfig(gate_m=3.0))
    assert found is not None and list(found.loops) == true


@pytest.mark.parametrize(("gap", "certain"), [(8, False), (9, True)])
def test_if_several_steps_are_possible_the_loops_must_be_of_several_visits(gap, certain):
    far = [far_loop(query, query - 30) for query in (*range(40, 45), *range(44 + gap, 49 + gap))]
    found = find_kidnapping(graph_with([(28, 0), (59, 30)], far), 10, VerificationConfig())
    assert (found is not None) == certain


def shows(graph, changed, similarity=0.0):
    """Let the image change before each of the keyframes `changed`, to another one of the given similarity."""
    first, second = np.eye(2, graph.keyframes[0].embedding.size, dtype=np.float32)
    other = np.float32(similarity) * first + np.float32(np.sqrt(1.0 - similarity**2)) * second
    for i, each in enumerate(graph.keyframes):
        graph.keyframes[i] = replace(each, embedding=other if sum(step <= i for step in changed) % 2 else first)


@pytest.mark.parametrize("changed", [29, 30])
def test_among_several_steps_the_image_changes_most_where_the_robot_was_carried(changed):
    far = [far_loop(query, query - 30) for query in (*range(40, 45), *range(53, 58))]
    graph = graph_with([(28, 0), (59, 30)], far)
    shows(graph, [changed])
    found = find_kidnapping(graph, 10, VerificationConfig())
    assert found is not None and found.step == changed


@pytest.mark.parametrize(
    ("changed", "similarity", "steps"),
    [([], 0.0, {28, 29, 30}), ([10], 0.98, {28, 29, 30}), ([10], 0.8, {10}), ([29], 0.8, {29})],
)
def test_a_step_by_itself_has_to_be_more_probable_than_several_that_lie_together(changed, similarity, steps):
    """If the robot was carried in one of four steps, 10, 28, 29 and 30, the step 10 may displace 20 keyframes wrongly."""
    far = [far_loop(query, query % 10, along(query - 30 - query % 10)) for query in (*range(40, 45), *range(54, 59))]
    graph = graph_with([(9, 0), (27, 10), (59, 30)], far)
    shows(graph, changed, similarity)
    found = find_kidnapping(graph, 10, VerificationConfig())
    assert found is not None and found.step in steps


def test_tolerances_of_zero_are_no_error():
    far = [far_loop(query, query - 30) for query in range(40, 55)]
    exact = VerificationConfig(gate_m=0.0, gate_share=0.0, gate_rad=0.0, gate_rad_m=0.0)
    assert find_kidnapping(graph_with([(29, 0), (59, 30)], far), 15, exact) is None


def test_each_keyframe_keeps_the_loops_with_most_inliers():
    loops = [replace(far_loop(50, match), inliers=match) for match in (3, 1, 2)] + [far_loop(51, 4)]
    assert [(loop.query, loop.match) for loop in strongest(loops, 2)] == [(50, 3), (50, 2), (51, 4)]


def test_steps_stay_bridged_when_the_keyframes_of_the_loops_retire():
    """Nine laps, then far loops: only the step in which the robot was carried is not bridged."""
    lap, carried, count = 24, 216, 246
    turn = se3.exp(np.array([0.0, 0.0, 2 * np.pi / lap, 0.5, 0.0, 0.0]))
    graph, rng = PoseGraph(PoseGraphConfig(window=20, growth=0.1, retire_above=60)), np.random.default_rng(3)
    for i in range(count):
        graph.add_keyframe(keyframe(rng, i, np.linalg.matrix_power(turn, i)))
        if lap <= i < carried:
            graph.add_loops([far_loop(i, i - lap, np.eye(4))])
        if i >= carried:
            graph.add_far_loops(i, [], [far_loop(i, i % lap, np.linalg.matrix_power(turn, 8))])
        graph.optimise_if_due()
    assert len(graph.retired) > 50
    for each in (graph, replayed(graph)):
        found = find_kidnapping(each, 10, VerificationConfig())
        assert found is not None and found.step == carried and found.is_only_step


def replayed(graph):
    """A graph with the same keyframes, loops and far loops, in which the retired keyframes retired in an earlier run."""
    other = PoseGraph(PoseGraphConfig())
    for each in graph.keyframes:
        if each.anchor is None:
            other.add_keyframe(each)
        else:
            other.add_retired(each, se3.between(graph.T_W_B[each.anchor], graph.T_W_B[each.id]))
    other.add_loops(graph.loops)
    other.add_far_loops(len(graph.keyframes) - 1, [], graph.far_loops.kept)
    return other
