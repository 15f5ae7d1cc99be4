import numpy as np
import pytest

from lexis.config import PlaceRecognitionConfig, PoseGraphConfig
from lexis.maths import se3
from lexis.place_recognition import propose
from lexis.pose_graph import PoseGraph
from lexis.types import Features, Keyframe, Landmarks, RoomInstance

NOTHING = Features(np.zeros((0, 2), np.float32), np.zeros((0, 61), np.uint8))
CONFIG = PlaceRecognitionConfig(candidates=3, min_gap_s=10.0, min_gap_m=5.0)


def keyframe(i, x, embedding):
    T = se3.exp(np.array([0.0, 0.0, 0.0, x, 0.0, 0.0]))
    unit = np.asarray(embedding, np.float32) / np.float32(np.linalg.norm(embedding))
    return Keyframe(i, i, float(i), T, np.eye(6), unit, NOTHING, Landmarks(np.zeros((0, 3)), np.zeros(0, int)))


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
    similarity = graph.embeddings[:5] @ query.embedding
    assert list(found) == np.argsort(-similarity)[:3].tolist()


def test_no_room_of_the_label_gives_no_candidates(graph):
    assert propose(graph.keyframes[20], "kitchen", [room(0, "office", range(5), graph)], graph, CONFIG) == ()
    assert propose(graph.keyframes[20], "kitchen", [], graph, CONFIG) == ()


def test_recent_keyframes_are_not_candidates(graph):
    everything = [room(0, "office", range(21), graph)]
    for query in graph.keyframes:
        for match in propose(query, "office", everything, graph, CONFIG):
            assert query.stamp - graph.keyframes[match].stamp >= CONFIG.min_gap_s
            assert graph.path_m[query.id] - graph.path_m[match] >= CONFIG.min_gap_m


def test_a_room_of_recent_keyframes_does_not_hide_the_older_one_behind_it(graph):
    rooms = [room(0, "office", range(16, 21), graph), room(1, "office", range(4, 9), graph)]
    assert set(propose(graph.keyframes[20], "office", rooms, graph, CONFIG)) <= set(range(4, 9))


def test_asking_for_no_candidates_switches_loops_off(graph):
    everything = [room(0, "office", range(21), graph)]
    assert propose(graph.keyframes[20], "office", everything, graph, PlaceRecognitionConfig(candidates=0)) == ()
