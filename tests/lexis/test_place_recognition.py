from dataclasses import replace

import numpy as np
import pytest
from helpers.box_room import FRONT_REAR

from lexis.config import PlaceRecognitionConfig, PoseGraphConfig, SessionConfig
from lexis.graph.pose_graph import PoseGraph
from lexis.graph.thinning import as_retired
from lexis.maths import se3
from lexis.place_recognition import propose, revisit_log_odds
from lexis.sessions.relocalisation import candidates_elsewhere
from lexis.types import NO_FEATURES, NO_LANDMARKS, CameraView, Keyframe, LoopEdge, RoomInstance

CONFIG = PlaceRecognitionConfig(method="room", candidates=3, min_gap_s=10.0, min_gap_m=5.0)


def keyframe(i, x, embedding):
    T = se3.exp(np.array([0.0, 0.0, 0.0, x, 0.0, 0.0]))
    unit = np.asarray(embedding, np.float32) / np.float32(np.linalg.norm(embedding))
    return Keyframe(i, i, float(i), T, np.eye(6), unit, NO_FEATURES, NO_LANDMARKS)


def room(i, label, ids, graph):
    return RoomInstance(i, label, tuple(ids), graph.T_W_B[list(ids), :3, 3].mean(axis=0), 0)


@pytest.fixture
def graph(rng):
    """Keyframes one second and one metre apart: 0-9 go out, 10-19 come back, 20 is at the start."""
    graph = PoseGraph(PoseGraphConfig())
    for i, x in enumerate([*range(10), *range(9, -1, -1), 0]):
        graph.add_keyframe(keyframe(i, float(x), rng.normal(size=8)))
    return graph


def test_candidates_are_the_most_similar_of_the_closest_room_of_the_label(graph):
    rooms = [room(0, "office", range(5), graph), room(1, "office", range(5, 10), graph), room(2, "lab", range(3), graph)]
    query = graph.keyframes[20]
    found = propose(query, "office", rooms, graph, CONFIG)
    similarity = graph.embeddings[:5, 0] @ query.embedding
    assert list(found) == np.argsort(-similarity)[:3].tolist()


def test_no_room_of_the_label_gives_no_candidates(graph):
    assert propose(graph.keyframes[20], "kitchen", [room(0, "office", range(5), graph)], graph, CONFIG) == ()
    assert propose(graph.keyframes[20], "kitchen", [], graph, CONFIG) == ()


def test_recent_keyframes_are_not_candidates(graph):
    everything = [room(0, "office", range(21), graph)]
    proposed = [(query, propose(query, "office", everything, graph, CONFIG)) for query in graph.keyframes]
    assert any(matches for _, matches in proposed)
    for query, matches in proposed:
        for match in matches:
            assert query.stamp - graph.keyframes[match].stamp >= CONFIG.min_gap_s
            assert graph.path_m[query.id] - graph.path_m[match] >= CONFIG.min_gap_m


def test_a_room_of_recent_keyframes_does_not_hide_the_older_one_behind_it(graph):
    rooms = [room(0, "office", range(16, 21), graph), room(1, "office", range(4, 9), graph)]
    similarity = graph.embeddings[4:9, 0] @ graph.keyframes[20].embedding
    expected = 4 + np.argsort(-similarity)[:3]
    assert list(propose(graph.keyframes[20], "office", rooms, graph, CONFIG)) == expected.tolist()


@pytest.mark.parametrize("method", ["probability", "room", "similarity"])
def test_asking_for_no_candidates_switches_loops_off(method, graph):
    everything = [room(0, "office", range(21), graph)]
    config = PlaceRecognitionConfig(method=method, candidates=0)
    assert propose(graph.keyframes[20], "office", everything, graph, config) == ()


@pytest.mark.parametrize("method", ["probability", "similarity"])
def test_other_methods_than_the_paper_s_need_no_room(method, graph):
    config = PlaceRecognitionConfig(method=method, candidates=3, min_gap_s=10.0, min_gap_m=5.0)
    query = replace(graph.keyframes[20], embedding=graph.embeddings[0, 0])
    assert propose(query, "kitchen", [], graph, config)[0] == 0


def test_similarity_alone_ranks_all_older_keyframes(graph):
    query, config = graph.keyframes[20], replace(CONFIG, method="similarity")
    ranked = np.argsort(-(graph.embeddings[:11, 0] @ query.embedding))  # ten seconds before the query at the latest
    assert list(propose(query, "office", [], graph, config)) == ranked[:3].tolist()


def test_a_new_place_is_not_a_revisit_unless_its_image_is_known(rng):
    graph = PoseGraph(PoseGraphConfig())
    for i in range(40):
        graph.add_keyframe(keyframe(i, float(i), rng.normal(size=64)))
    by_probability = replace(CONFIG, method="probability")
    query = graph.keyframes[39]
    assert propose(query, "office", [], graph, by_probability) == ()
    kidnapped = replace(query, embedding=graph.embeddings[7, 0])
    assert propose(kidnapped, "office", [], graph, by_probability) == (7,)


def test_a_carried_robot_is_searched_where_far_loops_see_it(rng):
    """The image at the revisited place is less similar than an image far from all possible poses must be."""
    by_probability, graph = replace(CONFIG, method="probability"), PoseGraph(PoseGraphConfig())
    for i in range(40):
        graph.add_keyframe(keyframe(i, float(i), rng.normal(size=64)))
    known = graph.embeddings[7, 0]
    query = replace(graph.keyframes[39], embedding=0.8 * known + 0.6 * np.roll(known, 1))
    assert propose(query, "", [], graph, by_probability) == ()
    far_loop = LoopEdge(38, 6, np.eye(4), 1e-4 * np.eye(6), 50)  # the next keyframe is then at the place of keyframe 7
    graph.add_far_loops(38, [], [far_loop])
    assert propose(query, "", [], graph, by_probability)[0] == 7


def test_the_log_odds_of_a_revisit_rise_with_similarity_and_fall_with_distance_and_angle(rng):
    config = PlaceRecognitionConfig()
    similarity, distance, angle = rng.uniform(-1, 1, 500), rng.uniform(0, 20, 500), rng.uniform(0, np.pi, 500)
    odds = revisit_log_odds(similarity, distance, angle, config)
    assert (revisit_log_odds(similarity + 0.1, distance, angle, config) > odds).all()
    assert (revisit_log_odds(similarity, distance + 0.1, angle, config) <= odds).all()
    assert (revisit_log_odds(similarity, distance, angle + 0.1, config) <= odds).all()
    certain = revisit_log_odds(similarity, 0 * distance, 0 * angle, config)
    assert (certain - odds <= config.lost_log_odds + 1e-9).all() and (odds <= certain).all()


def test_proposals_do_not_depend_on_the_frame_of_the_map(rng):
    moved, config = se3.exp(np.array([0.0, 0.0, 2.0, 30.0, -7.0, 1.0])), replace(CONFIG, method="probability")
    here, there = PoseGraph(PoseGraphConfig()), PoseGraph(PoseGraphConfig())
    for i, x in enumerate([*range(10), *range(9, -1, -1), 0]):
        added = keyframe(i, float(x), rng.normal(size=8) + 3)
        here.add_keyframe(added)
        there.add_keyframe(replace(added, T_O_B=moved @ added.T_O_B))
    for a, b in zip(here.keyframes, there.keyframes, strict=True):
        assert propose(a, "", [], here, config) == propose(b, "", [], there, config)
    assert propose(here.keyframes[20], "", [], here, config)


def test_the_bound_hides_no_likely_revisit(rng):
    graph = PoseGraph(PoseGraphConfig())
    base = rng.normal(size=32)
    for i in range(200):
        graph.add_keyframe(keyframe(i, float(i % 9), base + 0.6 * rng.normal(size=32)))
    config = PlaceRecognitionConfig(candidates=200, min_gap_s=10.0, min_gap_m=5.0)
    query = graph.keyframes[199]
    old = np.arange(190)
    T = se3.between(graph.T_W_B[old], graph.T_W_B[199])
    similarity = graph.embeddings[old, 0].astype(float) @ query.embedding
    odds = revisit_log_odds(similarity, np.linalg.norm(T[:, :3, 3], axis=1), se3.rotation_angle(T), config)
    likely = odds >= np.log(config.least_probability / (1 - config.least_probability))
    assert 3 < likely.sum() < 180
    found = propose(query, "", [], graph, config)
    assert set(old[likely].tolist()) <= set(found) and set(found) - set(old[likely].tolist())
    assert list(found) == sorted(found, key=lambda k: -round(odds[k], 6))
    assert propose(query, "", [], graph, replace(config, candidates=3)) == found[:3]


def there_and_back(rng, camera):
    """A graph of ten keyframes along x and of their ten successors, which look back at the same places; and the images.

    The front camera sees on the way back what the rear camera saw before. The two directions look completely different.
    """
    graph, ahead, behind = PoseGraph(PoseGraphConfig(), camera), rng.normal(size=(10, 32)), rng.normal(size=(10, 32))
    turned = se3.exp(np.array([0.0, 0.0, np.pi, 0.0, 0.0, 0.0]))
    for i, x in enumerate([*range(10), *range(9, -1, -1)]):
        seen = (ahead[x], behind[x]) if i < 10 else (behind[x], ahead[x])
        first, second = (keyframe(i, float(x), embedding) for embedding in seen)
        others = (CameraView(second.embedding, NO_FEATURES, second.landmarks),) if camera is not None else ()
        graph.add_keyframe(replace(first, T_O_B=first.T_O_B @ (np.eye(4) if i < 10 else turned), others=others))
    return graph


@pytest.mark.parametrize("method", ["probability", "similarity"])
def test_a_rear_camera_recognises_the_way_back(method, rng):
    config = replace(CONFIG, method=method, candidates=1)
    graph, alone = there_and_back(rng, FRONT_REAR), there_and_back(rng, None)
    for query in range(15, 20):
        assert propose(graph.keyframes[query], "", [], graph, config) == (19 - query,)
        assert method == "similarity" or propose(alone.keyframes[query], "", [], alone, config) == ()


def test_retired_keyframes_are_no_candidates_in_their_own_session_and_in_others():
    graph = PoseGraph(PoseGraphConfig())
    for i in range(20):
        one = keyframe(i, float(i), np.ones(8))
        if i in (3, 5):
            graph.add_retired(as_retired(one, graph.keyframes[2]), se3.between(graph.keyframes[2].T_O_B, one.T_O_B))
        else:
            graph.add_keyframe(one)
    everything = [room(0, "office", range(20), graph)]
    for method in ("probability", "similarity", "room"):
        config = replace(CONFIG, method=method, candidates=20)
        assert set(propose(graph.keyframes[19], "office", everything, graph, config)) == set(range(10)) - {3, 5}
    graph.add_keyframe(replace(keyframe(20, 0.0, np.ones(8)), session=1))
    elsewhere = candidates_elsewhere(graph.keyframes[20], graph, SessionConfig(candidates=20))
    assert set(elsewhere) == set(range(20)) - {3, 5}
