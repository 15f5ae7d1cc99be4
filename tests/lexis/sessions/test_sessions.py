"""Sessions on a circle that is known exactly: a verifier that knows the truth stands in for PnP."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.box_room import FORWARD_CAMERA
from helpers.circle_encoder import CircleEncoder
from helpers.map_builder import keyframe, with_retired
from helpers.same_map import assert_same

from lexis.config import Config, LabelConfig, PlaceRecognitionConfig, SessionConfig
from lexis.errors import LexisError, MapError
from lexis.graph.components import component_of, sessions_apart, side_by_side
from lexis.graph.loop_record import accepted
from lexis.graph.pose_graph import PoseGraph
from lexis.map.folder import load_map, save_map
from lexis.map.interchange import read_spark_dsg, write_spark_dsg
from lexis.map.relabelling import relabel
from lexis.maths import se3
from lexis.merging import merge
from lexis.planning import PathPlanner
from lexis.sessions.relocalisation import at_any_distance
from lexis.slam import Slam
from lexis.types import EncoderId, Features, LoopDecision, LoopEdge, Observation, Percept
from lexis.verification import Verification, plausible

ROOMS = ("office", "kitchen")
COVARIANCE = np.diag(np.repeat([0.001, 0.003], 3) ** 2)
LOOP_COVARIANCE = np.diag(np.repeat([0.005, 0.02], 3) ** 2)
FIRST, SECOND = 60, 30
"""Keyframes of the two sessions."""
MOVED = se3.exp(np.array([0.0, 0.0, 1.0, 30.0, -20.0, 0.5]))
"""Where the odometry of the second session starts, in the frame of the first session."""


def circle(first, count):
    """True poses on a circle of 40 keyframes with radius 3.2 m."""
    step = se3.exp(np.array([0.0, 0.0, 2 * np.pi / 40, 0.501, 0.0, 0.0]))
    T = [np.linalg.matrix_power(step, first)]
    for _ in range(count - 1):
        T.append(T[-1] @ step)
    return np.stack(T)


TRUE = np.concatenate([circle(0, FIRST), circle(17, SECOND)])


def observation(index, T_O_B, rng):
    x, y = TRUE[index, :2, 3] / 3.2
    embedding = np.array([1.0, 0.0, x, y])
    percept = Percept(
        np.float32(embedding / np.linalg.norm(embedding)),
        Features(rng.uniform(0, 20, (3, 2)).astype(np.float32), rng.integers(0, 256, (3, 61), np.uint8)),
    )
    return Observation(index, 1.0 + index % FIRST, percept, T_O_B, COVARIANCE)


def true_edge(query, match, graph):
    ends = [graph.keyframes[i].observation_index for i in (match, query)]
    return LoopEdge(query, match, se3.between(*TRUE[ends]), LOOP_COVARIANCE, 50)


def verifier(wrong=frozenset(), shift=MOVED):
    """Confirms each candidate by the truth; the edges between sessions from the observations `wrong` are shifted."""

    def check(query, candidates, graph, camera, config):
        located = []
        for match in candidates:
            edge = true_edge(query.id, match, graph)
            if query.observation_index in wrong and graph.keyframes[match].session != query.session:
                turned = se3.exp(np.array([0.0, 0.0, 0.3 * query.id, 0.0, 2.0 * query.id, 0.0]))
                edge = replace(edge, T_match_query=edge.T_match_query @ turned)
            located.append((LoopDecision(query.id, match, "accepted"), edge))
        return plausible(located, graph, config)

    return check


def nothing(query, candidates, graph, camera, config):
    return Verification(())


def walk(indices, verify, config=None, map=None):
    rng = np.random.default_rng(2)
    start = np.eye(4) if indices[0] == 0 else se3.inverse(MOVED)
    slam = Slam(FORWARD_CAMERA, CircleEncoder(), ROOMS, config, verify, map=map)
    for i in indices:
        slam.process(observation(i, start @ TRUE[i], rng))
    return slam


@pytest.fixture(scope="module")
def first():
    return walk(range(FIRST), verifier()).finish()


def second(first, verify, config=None):
    return walk(range(FIRST, FIRST + SECOND), verify, config, first).finish()


def test_a_recognised_session_takes_the_frame_of_the_map(first):
    joined = second(first, verifier())
    assert sessions_apart(joined) == []
    np.testing.assert_allclose(joined.T_W_B, TRUE, atol=1e-3)


def test_a_map_that_the_user_has_moved_stays_there_when_it_is_continued_or_merged(first):
    moved = replace(first, T_W_B=MOVED @ first.T_W_B)
    other = walk(range(FIRST, FIRST + SECOND), verifier()).finish()
    for joined in (second(moved, verifier()), merge(moved, other, CircleEncoder(), verifier=verifier())):
        assert sessions_apart(joined) == []
        np.testing.assert_allclose(joined.T_W_B, MOVED @ TRUE, atol=1e-3)


def test_a_session_that_is_not_recognised_lies_beside_the_map(first):
    apart = second(first, nothing)
    assert sessions_apart(apart) == [1]
    np.testing.assert_array_equal(apart.T_W_B[:FIRST], first.T_W_B)
    gap = apart.T_W_B[FIRST:, 0, 3].min() - apart.T_W_B[:FIRST, 0, 3].max()
    assert gap == pytest.approx(10.0)
    np.testing.assert_allclose(
        se3.between(apart.T_W_B[FIRST], apart.T_W_B[-1]), se3.between(TRUE[FIRST], TRUE[-1]), atol=1e-9
    )


def test_rooms_and_ways_do_not_cross_components(first):
    apart = second(first, nothing)
    components = component_of(apart)
    assert all(len(set(components[list(room.keyframes)])) == 1 for room in apart.rooms)
    rows, columns = PathPlanner(apart).graph.nonzero()
    assert (components[rows] == components[columns]).all()
    assert_same(replace(relabel(apart, ROOMS, CircleEncoder()), stage_seconds={}), replace(apart, stage_seconds={}))


def assert_each_query_has_one_entry(lexis_map):
    queries = [query for query, _ in lexis_map.candidates]
    assert len(set(queries)) == len(queries)


def candidates_of(lexis_map):
    """The pairs of a query and a candidate, in the order of the map."""
    return [(query, match) for query, matches in lexis_map.candidates for match in matches]


def test_a_joined_map_tells_what_became_of_every_loop_candidate(first):
    joined = second(first, verifier())
    assert [(decision.query, decision.match) for decision in joined.decisions] == candidates_of(joined)
    assert_each_query_has_one_entry(joined)
    accepted = {(decision.query, decision.match) for decision in joined.decisions if decision.outcome == "accepted"}
    assert accepted == {(loop.query, loop.match) for loop in joined.loops}
    assert any(query >= FIRST > match for query, match in accepted)


def test_edges_that_contradict_each_other_never_join(first, tmp_path):
    apart = second(first, verifier(wrong=range(FIRST, FIRST + SECOND)))
    assert sessions_apart(apart) == [1]
    assert [(decision.query, decision.match) for decision in apart.decisions] == candidates_of(apart)
    across = [decision for decision in apart.decisions if decision.query >= FIRST > decision.match]
    assert {decision.outcome for decision in across} == {"unsupported"}
    assert {decision.misfit_m for decision in across} == {None}  # the poses share no frame
    save_map(apart, tmp_path / "map")
    assert_same(load_map(tmp_path / "map"), apart)


@pytest.mark.parametrize("off_m", [0.0, 0.01, 5.0])
def test_uncertain_edges_are_refused_where_no_estimate_relates_the_components(off_m, rng):
    """An uncertain edge may only confirm an estimate, and no estimate relates two components."""
    graph = PoseGraph(Config().pose_graph)
    for i in range(2):
        graph.add_keyframe(keyframe(rng, i, np.eye(4)))
    T = np.eye(4)
    T[0, 3] = off_m
    for sigma_m, outcome in ((0.01, "accepted"), (0.2, "uncertain pose")):
        edge = LoopEdge(1, 0, T, sigma_m**2 * np.eye(6), 50)
        verified = plausible([(LoopDecision(1, 0, "accepted"), edge)], graph, at_any_distance(Config().verification))
        assert verified.decisions[0].outcome == outcome


def test_wrong_edges_do_not_keep_a_session_from_being_joined(first):
    joined = second(first, verifier(wrong=range(FIRST, FIRST + 4)))
    np.testing.assert_allclose(joined.T_W_B[FIRST:], TRUE[FIRST:], atol=0.02)


def in_twin_rooms(ambiguous):
    """Confirms each candidate by the truth; every second one of the observations `ambiguous` is confirmed 3 m beside it."""

    def check(query, candidates, graph, camera, config):
        located = []
        for match in candidates:
            edge = true_edge(query.id, match, graph)
            if query.observation_index in ambiguous and graph.keyframes[match].session != query.session and match % 2:
                ends = [graph.keyframes[i].observation_index for i in (match, query.id)]
                beside = se3.exp(np.array([0.0, 0.0, 0.0, 3.0, 0.0, 0.0]))
                edge = replace(edge, T_match_query=se3.between(TRUE[ends[0]], beside @ TRUE[ends[1]]))
            located.append((LoopDecision(query.id, match, "accepted"), edge))
        return plausible(located, graph, config)

    return check


def test_a_session_in_one_of_two_rooms_that_look_alike_is_joined_once_it_shows_something_else(first):
    begins_there = second(first, in_twin_rooms(range(FIRST, FIRST + 10)))
    np.testing.assert_allclose(begins_there.T_W_B[FIRST:], TRUE[FIRST:], atol=0.02)
    assert sessions_apart(second(first, in_twin_rooms(range(FIRST, FIRST + SECOND)))) == [1]


def test_the_time_per_keyframe_of_a_split_map_does_not_grow_with_the_number_of_pairs_of_edges(first, monkeypatch):
    """The components are read three times for each keyframe, and twice for the finished map."""
    components, reads = PoseGraph.components.fget, []
    monkeypatch.setattr(PoseGraph, "components", property(lambda graph: reads.append(graph) or components(graph)))
    second(first, verifier(wrong=range(FIRST, FIRST + SECOND)))
    assert len(reads) == 3 * SECOND + 2


@pytest.mark.parametrize("few", [dict(agreeing=SECOND + 1), dict(span_m=20.0)])
def test_few_keyframes_or_a_short_path_are_not_enough(first, few):
    assert sessions_apart(second(first, verifier(), Config(sessions=SessionConfig(**few)))) == [1]


def test_rooms_by_which_loops_are_sought_are_derived_anew_when_a_session_is_joined(first):
    """Without other loops, and with labels that are refined rarely, joining is the only occasion."""
    config = Config(labels=LabelConfig(every=1000), place_recognition=PlaceRecognitionConfig(method="room"))
    given = []

    def recogniser(query, label, rooms, graph, config):
        given.append(({keyframe for room in rooms for keyframe in room.keyframes}, graph.is_split))
        return ()

    slam = Slam(FORWARD_CAMERA, CircleEncoder(), ROOMS, config, verifier(), recogniser, map=first)
    for i in range(FIRST, FIRST + SECOND):
        slam.process(observation(i, se3.inverse(MOVED) @ TRUE[i], np.random.default_rng(i)))
    slam.finish()
    assert given[0] == (set(), True) and given[-1][1] is False
    assert all(keyframes >= set(range(FIRST + 1)) for keyframes, is_split in given if not is_split)


def test_a_map_of_several_sessions_is_saved_and_continued(first, tmp_path):
    both = second(first, nothing)
    save_map(both, tmp_path / "map")
    assert_same(load_map(tmp_path / "map"), both)
    third = walk(range(FIRST, FIRST + SECOND), verifier(), map=load_map(tmp_path / "map"))
    assert sessions_apart(third.finish()) == []  # the third session recognises both


def test_a_map_that_was_saved_without_features_is_continued_and_merged_and_saved_again(first, tmp_path):
    save_map(first, tmp_path / "bare", features=False)
    bare = load_map(tmp_path / "bare")
    write_spark_dsg(first, tmp_path / "graph.json")
    for featureless in (bare, read_spark_dsg(tmp_path / "graph.json")):
        other = second(featureless, nothing)
        for both in (other, merge(other, featureless, CircleEncoder(), verifier=nothing)):
            save_map(both, tmp_path / "both")
            assert_same(load_map(tmp_path / "both"), both)


def test_two_maps_are_merged_like_a_second_session(first):
    other = walk(range(FIRST, FIRST + SECOND), verifier()).finish()
    merged = merge(first, other, CircleEncoder(), verifier=verifier())
    assert [keyframe.session for keyframe in merged.keyframes] == [0] * FIRST + [1] * SECOND
    np.testing.assert_allclose(merged.T_W_B, TRUE, atol=1e-3)


def without_second(query, candidates, graph, camera, config):
    """Confirms candidates by the truth, unless the query or the candidate was in the second session."""
    old = [match for match in candidates if graph.keyframes[match].observation_index < FIRST]
    return verifier()(query, old if query.observation_index < FIRST else [], graph, camera, config)


RETIRED = {FIRST + 5: 20, FIRST + 6: FIRST + 4}
"""Anchors of keyframes of the second session: one is in the first session."""


@pytest.mark.parametrize("anchors", [{}, RETIRED])
@pytest.mark.parametrize(("check", "apart"), [(without_second, []), (nothing, [1, 2])])
def test_sessions_that_the_second_map_has_joined_stay_joined_in_a_merged_map(first, anchors, check, apart):
    """The verifier does not find the loops between the sessions of the second map again."""
    joined = with_retired(second(first, verifier()), anchors)
    base = walk(range(30), verifier()).finish()
    merged = merge(base, joined, CircleEncoder(), verifier=check)
    assert sessions_apart(merged) == apart
    start = merged.T_W_B[30] if apart else TRUE[0]
    np.testing.assert_allclose(se3.between(start, merged.T_W_B[30:]), se3.between(TRUE[0], TRUE), atol=2e-3)
    across = {(30 + loop.query, 30 + loop.match) for loop in joined.loops if loop.query >= FIRST > loop.match}
    loops = {(loop.query, loop.match) for loop in merged.loops}
    assert across == {(query, match) for query, match in loops if query >= 30 + FIRST > match}
    assert {(decision.query, decision.match) for decision in merged.decisions if decision.outcome == "accepted"} == {
        (query, match) for query, match in loops if query - 30 not in anchors
    }
    assert {(decision.query, decision.match) for decision in merged.decisions} <= set(candidates_of(merged))
    assert_each_query_has_one_entry(merged)


def test_a_loop_of_a_replayed_keyframe_leaves_the_decisions_on_other_keyframes_alone(first, monkeypatch):
    """Going through all decisions for each loop would take a time that grows with the square of the map's length."""
    joined, looked_at = second(first, verifier()), []

    def recorded(decisions, edges):
        looked_at.append(({decision.query for decision in decisions}, {edge.query for edge in edges}))
        return accepted(decisions, edges)

    monkeypatch.setattr("lexis.graph.loop_record.accepted", recorded)
    merge(walk(range(30), verifier()).finish(), joined, CircleEncoder(), verifier=without_second)
    kept = [queries for _, queries in looked_at if len(queries) == 1]
    assert len(kept) >= 2
    assert all(judged <= queries for judged, queries in looked_at if len(queries) == 1)


class OtherWeights(CircleEncoder):
    name = fingerprint = "other weights"


def test_maps_of_different_encoders_are_not_merged(first):
    other = walk(range(FIRST, FIRST + SECOND), verifier()).finish()
    with pytest.raises(MapError, match="similarities across weights mean nothing"):
        merge(
            first, replace(other, encoder=EncoderId("other weights", "other weights")), CircleEncoder(), verifier=verifier()
        )
    with pytest.raises(MapError, match="similarities across weights mean nothing"):
        merge(first, other, OtherWeights(), verifier=verifier())


def test_replayed_maps_and_observations_after_them_are_sessions_of_their_own(first):
    other = walk(range(FIRST, FIRST + SECOND), verifier()).finish()
    slam = Slam(FORWARD_CAMERA, CircleEncoder(), ROOMS, verifier=verifier())
    slam.replay(first)
    slam.replay(other)
    rng = np.random.default_rng(2)
    for i in range(10):
        slam.process(observation(i, TRUE[i], rng))
    made = slam.finish()
    assert [keyframe.session for keyframe in made.keyframes] == [0] * FIRST + [1] * SECOND + [2] * 10
    assert [keyframe.id for keyframe in made.keyframes] == list(range(FIRST + SECOND + 10))
    np.testing.assert_allclose(made.T_W_B, np.concatenate([TRUE, TRUE[:10]]), atol=1e-3)


def test_a_map_that_is_replayed_after_finish_is_a_session_of_its_own(first, tmp_path):
    slam = walk(range(10), verifier())
    recorded = slam.finish()
    slam.replay(first)
    made = slam.finish()
    assert [keyframe.session for keyframe in made.keyframes] == [0] * len(recorded.keyframes) + [1] * FIRST
    save_map(made, tmp_path / "map")
    assert_same(load_map(tmp_path / "map"), made)


def test_a_map_is_not_replayed_between_the_observations_of_a_session(first):
    slam = walk(range(10), verifier())
    with pytest.raises(LexisError, match=r"still wait for later observations; valid: finish\(\) first, or replay\(\)"):
        slam.replay(first)


def test_loops_that_a_merged_map_finds_again_are_in_it_once(first):
    joined = second(first, verifier())
    merged = merge(walk(range(30), verifier()).finish(), joined, CircleEncoder(), verifier=verifier())
    pairs = [(loop.query, loop.match) for loop in merged.loops]
    assert len(set(pairs)) == len(pairs)
    np.testing.assert_allclose(merged.T_W_B, np.concatenate([TRUE[:30], TRUE]), atol=2e-3)


def test_a_snapshot_does_not_change_the_run(first):
    slam = walk(range(30), verifier())
    early = slam.snapshot()
    assert len(early.keyframes) == slam.keyframe_count > 20
    for i in range(30, FIRST):
        slam.process(observation(i, TRUE[i], np.random.default_rng(i)))
        slam.snapshot()
    np.testing.assert_array_equal(slam.finish().T_W_B, first.T_W_B)


def test_another_camera_or_other_names_are_refused(first):
    with pytest.raises(MapError, match="room names"):
        Slam(FORWARD_CAMERA, CircleEncoder(), ("office",), map=first)
    turned = replace(FORWARD_CAMERA, T_B_C=FORWARD_CAMERA.T_B_C @ se3.exp(np.array([0, 0.1, 0, 0, 0, 0])))
    with pytest.raises(MapError, match="same camera"):
        Slam(turned, CircleEncoder(), ROOMS, map=first)


def test_components_side_by_side_keep_their_shape(rng):
    T = se3.exp(rng.normal(size=(9, 6)))
    components = np.array([0, 0, 0, 1, 1, 1, 0, 2, 2])
    laid = side_by_side(T, components)
    for name in range(3):
        ids = components == name
        np.testing.assert_allclose(se3.between(laid[ids][0], laid[ids]), se3.between(T[ids][0], T[ids]), atol=1e-12)
    assert laid[components == 1, 0, 3].min() == pytest.approx(laid[components == 0, 0, 3].max() + 10.0)
