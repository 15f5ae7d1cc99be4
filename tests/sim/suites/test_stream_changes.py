"""Changes of the stream reach the SLAM, and its claims come back in terms of the unchanged stream."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.open_flat import OPEN_FLAT

from sim.harness import Estimate, Lexis, LoopClaims, run
from sim.harness.adapters import OdometryOnly
from sim.suites.agreement import agreement
from sim.suites.stream_changes import MoreNames, MovedOrigin, Nothing, OtherClock, Pause, PermutedNames, changed

CHANGES = (Nothing(), MovedOrigin(), OtherClock(), Pause(after=12, pauses=4), PermutedNames(), MoreNames())


class Listening:
    """Notes what it is given, and claims the first room name and one loop for every frame."""

    def start(self, camera, room_names):
        self.names, self.seen = tuple(room_names), []

    def process(self, observation):
        self.seen.append(observation)

    def finish(self):
        n = len(self.seen)
        loops = LoopClaims(np.array([n - 1]), np.array([0]), np.eye(4)[None], np.ones(1))
        poses = np.stack([seen.T_O_B for seen in self.seen])
        return Estimate(np.arange(n), T_W_B=poses, labels=np.zeros(n, int), rooms=np.zeros(n, int), loops=loops)


@pytest.fixture(scope="module")
def lexis():
    return run(OPEN_FLAT, Lexis("oracle"))


@pytest.mark.parametrize("change", CHANGES[:5], ids=lambda change: type(change).__name__)
def test_lexis_claims_the_same_behind_every_neutral_change(lexis, change):
    again = run(OPEN_FLAT, changed(Lexis("oracle"), change))
    found = agreement(lexis.estimate, again.estimate)
    assert (found.frames, found.labels, found.rooms, found.floors, found.loops) == (1.0, 1.0, 1.0, 1.0, 1.0)
    assert found.position_m < 1e-6


@pytest.mark.parametrize("change", CHANGES, ids=lambda change: type(change).__name__)
def test_claims_come_back_for_every_frame_in_the_unchanged_names(change):
    slam = Listening()
    finished = run(OPEN_FLAT, changed(slam, change))
    frames = finished.estimate.frames
    assert frames.tolist() == list(range(len(finished.session)))
    named = slam.names[0]
    assert {finished.room_names[label] for label in finished.estimate.labels} == {named}
    assert finished.estimate.loops.query.tolist() == [len(frames) - 1]


def test_every_observation_gets_a_new_index_from_zero():
    slam = Listening()
    run(OPEN_FLAT, changed(slam, Pause(after=3, pauses=2)))
    assert [seen.index for seen in slam.seen] == list(range(len(slam.seen)))
    stamps = [seen.stamp for seen in slam.seen]
    assert stamps == sorted(stamps) and len(set(stamps)) == len(stamps)
    np.testing.assert_array_equal(slam.seen[3].T_O_B, slam.seen[5].T_O_B)


def test_another_origin_moves_all_poses_by_one_motion():
    plain, moved = Listening(), Listening()
    run(OPEN_FLAT, plain)
    run(OPEN_FLAT, changed(moved, MovedOrigin()))
    motions = [b.T_O_B @ np.linalg.inv(a.T_O_B) for a, b in zip(plain.seen, moved.seen, strict=True)]
    np.testing.assert_allclose(motions, np.broadcast_to(MovedOrigin().T_new_old, (len(motions), 4, 4)), atol=1e-9)


def test_a_label_for_a_name_that_was_added_is_no_label():
    class Confused(Listening):
        def finish(self):
            claims = super().finish()
            return replace(claims, labels=np.full(len(self.seen), len(self.names) - 1))

    finished = run(OPEN_FLAT, changed(Confused(), MoreNames()))
    assert (finished.estimate.labels == -1).all()


def test_only_a_slam_that_accepts_features_accepts_them_behind_a_change():
    assert hasattr(changed(Lexis("oracle"), Nothing()), "start_on_features")
    assert not hasattr(changed(OdometryOnly(), Nothing()), "start_on_features")
