"""`FeatureInput.verify` gives any SLAM the loop closures that a comparison of images would give."""

from dataclasses import replace

import numpy as np
import pytest

from lexis.maths.se3 import between, rotation_angle
from sim.errors import SimError
from sim.harness.estimate import Estimate
from sim.harness.runner import run
from sim.harness.scenario import Scenario
from sim.suites.changed_stream import changed
from sim.suites.stream_changes import Pause
from worlds.presets import sample_from_rooms

SCENARIO = Scenario(
    house=sample_from_rooms(("kitchen", "bedroom", "living room"), seed=3), fidelity="features", frame_rate_hz=2.0,
    length_m=60.0,
)  # fmt: skip


class Recorder:
    """A SLAM that stores what it gets, and estimates nothing."""

    def start(self, camera, room_names):
        """Unused, because all runs are on features."""

    def start_on_features(self, camera, room_names, features):
        self.features, self.indices = features, []

    def process(self, observation):
        self.indices.append(observation.index)

    def finish(self):
        return Estimate(np.array(self.indices))


@pytest.fixture(scope="module")
def ran():
    slam = Recorder()
    return run(SCENARIO, slam).true_poses, slam.features


def _edges(features, count):
    return [edge for query in range(20, count, 3) for edge in features.verify(query, range(0, query - 15, 2))]


def test_loops_join_the_given_observations_and_nearly_all_revisits_are_true(ran):
    truth, features = ran
    edges = _edges(features, len(truth))
    assert len(edges) > 20
    assert all(edge.match <= edge.query - 15 and edge.match % 2 == 0 for edge in edges)
    true = between(truth[[edge.match for edge in edges]], truth[[edge.query for edge in edges]])
    revisits = (np.linalg.norm(true[:, :3, 3], axis=1) < 1.0) & (rotation_angle(true) < 0.5)
    off = between(true, np.array([edge.T_match_query for edge in edges]))[revisits]
    assert len(off) > 10
    assert np.mean((np.linalg.norm(off[:, :3, 3], axis=1) < 0.5) & (rotation_angle(off) < 0.2)) > 0.9


def test_answers_depend_neither_on_the_run_nor_on_earlier_questions(ran):
    truth, features = ran
    again = Recorder()
    run(SCENARIO, again)
    first, second = _edges(features, len(truth)), _edges(again.features, len(truth))[:5]
    for one, other in zip(first, second, strict=False):
        assert (one.query, one.match, one.inliers) == (other.query, other.match, other.inliers)
        assert np.array_equal(one.T_match_query, other.T_match_query)


def test_a_slam_that_numbers_observations_anew_gets_the_same_loops(ran):
    truth, features = ran
    anew = features.renumbered(lambda index: index - 1000, lambda index: True)
    for query in {edge.query for edge in _edges(features, len(truth))}:
        matches = range(0, query - 15, 2)
        there, here = features.verify(query, matches), anew.verify(query + 1000, [match + 1000 for match in matches])
        assert [(edge.query + 1000, edge.match + 1000, edge.inliers) for edge in there] == [
            (edge.query, edge.match, edge.inliers) for edge in here
        ]
        for one, other in zip(there, here, strict=True):
            assert np.array_equal(one.T_match_query, other.T_match_query)


def test_two_frames_of_one_observation_get_the_same_loops(ran):
    truth, features = ran
    edge = _edges(features, len(truth))[0]
    paused = features.renumbered(lambda index: index // 2, lambda index: True)  # every frame is given twice
    loops = paused.verify(2 * edge.query, [2 * edge.match + 1, 2 * edge.match])
    assert [loop.match for loop in loops] == [2 * edge.match + 1, 2 * edge.match]
    assert all(loop.query == 2 * edge.query and np.array_equal(loop.T_match_query, edge.T_match_query) for loop in loops)


@pytest.mark.parametrize("pause", [None, Pause()])
def test_no_question_tells_what_lies_ahead(pause):
    """The relative pose of a frame that the SLAM will get later would tell it the true path."""

    class Asking(Recorder):
        def process(self, observation):
            super().process(observation)
            now = observation.index
            for question in ((now, [now + 1]), (now + 1, [now])):
                with pytest.raises(SimError, match="valid: indices of different observations that were delivered"):
                    self.features.verify(*question)
            if now:
                self.features.verify(now, [0])

    run(replace(SCENARIO, length_m=None), Asking() if pause is None else changed(Asking(), pause))


@pytest.mark.parametrize(("query", "matches"), [(-1, [0]), (3, [-1]), (3, [1, 3])])
def test_indices_that_are_no_other_observations_are_refused(ran, query, matches):
    with pytest.raises(SimError, match="valid: indices of different observations that were delivered"):
        ran[1].verify(query, matches)
