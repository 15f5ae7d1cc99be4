"""Changes of the stream reach the SLAM, and its estimates come back in terms of the unchanged stream."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.box_room import FORWARD_CAMERA
from helpers.map_builder import keyframe
from helpers.open_flat import OPEN_FLAT

from lexis.config import PoseGraphConfig, VerificationConfig
from lexis.graph.pose_graph import PoseGraph
from lexis.maths.se3 import between, compose_covariance, exp, inverse, is_rigid
from lexis.types import LoopEdge
from lexis.verification import Verification
from sim.errors import EstimateError
from sim.harness import Estimate, EstimatedLoops, Lexis, run
from sim.harness.adapters import OdometryOnly
from sim.suites.agreement import agreement
from sim.suites.changed_stream import _moved, changed
from sim.suites.false_loops import FalseLoops
from sim.suites.frame_changes import MovedOrigin, TurnedBody, _BetweenOtherBodies
from sim.suites.stream_changes import (
    CapitalLetters,
    HeightDrift,
    MoreNames,
    NoChange,
    OtherClock,
    Pause,
    PermutedNames,
    ReusedArrays,
    Slip,
    StepsInTwoParts,
    Synonyms,
)

EXACT = (
    NoChange(),
    MovedOrigin(),
    OtherClock(),
    ReusedArrays(),
    TurnedBody(),
    Pause(every_s=6.0, repeats=4),
    PermutedNames(),
    StepsInTwoParts(),
)
CHANGES = (
    *EXACT,
    MoreNames(),
    CapitalLetters(),
    HeightDrift(),
    Synonyms(),
    Slip(first_s=3.0),
    Slip(first_s=3.0, every_s=2.0),
    FalseLoops(),
)
KEEPS_ARRAYS = [change for change in CHANGES if not isinstance(change, ReusedArrays)]
"""Changes behind which a SLAM may keep the arrays that it is given, as `Listening` does."""


class Listening:
    """Notes what it is given, and estimates the first room name and one loop for every frame."""

    def start(self, camera, room_names):
        self.camera, self.names, self.seen = camera, tuple(room_names), []

    def process(self, observation):
        self.seen.append(observation)

    def finish(self):
        n = len(self.seen)
        loops = EstimatedLoops(np.array([n - 1]), np.array([0]), np.eye(4)[None], np.ones(1))
        poses = np.stack([seen.T_O_B for seen in self.seen])
        return Estimate(np.arange(n), T_W_B=poses, labels=np.zeros(n, int), rooms=np.zeros(n, int), loops=loops)


@pytest.fixture(scope="module")
def lexis():
    return run(OPEN_FLAT, Lexis("oracle"))


@pytest.mark.parametrize("change", EXACT, ids=lambda change: type(change).__name__)
def test_lexis_estimates_the_same_behind_every_neutral_change(lexis, change):
    again = run(OPEN_FLAT, changed(Lexis("oracle"), change))
    found = agreement(lexis.estimate, again.estimate)
    assert (found.frames, found.labels, found.rooms, found.floors, found.loops) == (1.0, 1.0, 1.0, 1.0, 1.0)
    assert found.position_m < 1e-6


@pytest.mark.parametrize("change", KEEPS_ARRAYS, ids=lambda change: type(change).__name__)
def test_estimates_come_back_for_every_frame_in_the_unchanged_names(change):
    slam = Listening()
    finished = run(OPEN_FLAT, changed(slam, change))
    frames = finished.estimate.frames
    assert frames.tolist() == list(range(len(finished.session)))
    named = change.names(finished.room_names)[slam.names[0]]
    assert {finished.room_names[label] for label in finished.estimate.labels} == {named}
    assert finished.estimate.loops.query.tolist() == [len(frames) - 1]


def test_every_observation_gets_a_new_index_from_zero():
    slam = Listening()
    run(OPEN_FLAT, changed(slam, Pause(every_s=2.0, repeats=2)))
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
            estimates = super().finish()
            return replace(estimates, labels=np.full(len(self.seen), len(self.names) - 1))

    finished = run(OPEN_FLAT, changed(Confused(), MoreNames()))
    assert (finished.estimate.labels == -1).all()


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        (lambda estimate: replace(estimate, frames=estimate.frames + 1), r"frames has \d+ in row \d+; valid: 0 to"),
        (lambda estimate: replace(estimate, labels=estimate.labels + 99), "labels has 99 in row 0; valid: -1 to"),
        (lambda estimate: None, r"finish\(\) returned NoneType; valid: an Estimate"),
    ],
)
def test_an_invalid_estimate_gets_the_same_message_with_and_without_a_change(wrong, message):
    class Invalid(Listening):
        def finish(self):
            return wrong(super().finish())

    for slam in (Invalid(), changed(Invalid(), NoChange())):
        with pytest.raises(EstimateError, match=message):
            run(OPEN_FLAT, slam)


def test_only_a_slam_that_accepts_features_accepts_them_behind_a_change():
    assert hasattr(changed(Lexis("oracle"), NoChange()), "start_on_features")
    assert not hasattr(changed(OdometryOnly(), NoChange()), "start_on_features")


def test_arrays_are_overwritten_once_the_slam_has_processed_them():
    slam = Listening()
    with pytest.raises(EstimateError, match="T_W_B is no rigid motion"):
        run(OPEN_FLAT, changed(slam, ReusedArrays()))
    assert not any(seen.T_O_B.any() or seen.increment_covariance.any() for seen in slam.seen)


def test_a_turned_body_moves_as_the_body_does_and_its_estimates_come_back_as_those_of_the_body():
    plain, turned = Listening(), Listening()
    straight = run(OPEN_FLAT, plain)
    finished = run(OPEN_FLAT, changed(turned, TurnedBody()))
    assert not np.allclose(turned.seen[5].T_O_B, plain.seen[5].T_O_B)
    np.testing.assert_allclose(finished.estimate.T_W_B, straight.estimate.T_W_B, atol=1e-12)
    # The camera stays where it is in the world, and the variance of the motion along its axis stays with it.
    T_O_C = [slam.seen[5].T_O_B @ slam.camera.T_B_C for slam in (plain, turned)]
    np.testing.assert_allclose(*T_O_C, atol=1e-12)
    along = [
        (slam.seen[5].T_O_B[:3, :3] @ slam.seen[5].increment_covariance[3:, 3:] @ slam.seen[5].T_O_B[:3, :3].T)
        for slam in (plain, turned)
    ]
    np.testing.assert_allclose(*along, atol=1e-12)


def test_a_slip_displaces_all_later_poses_and_is_certain_of_nothing_else():
    plain, slipped = Listening(), Listening()
    run(OPEN_FLAT, plain)
    run(OPEN_FLAT, changed(slipped, Slip(first_s=3.0, shift_m=(0.3, 0.0, 0.0))))
    moved = np.array([b.T_O_B[:3, 3] - a.T_O_B[:3, 3] for a, b in zip(plain.seen, slipped.seen, strict=True)])
    np.testing.assert_allclose(moved[:6], 0.0)
    np.testing.assert_allclose(moved[6:], np.broadcast_to([0.3, 0.0, 0.0], moved[6:].shape), atol=1e-12)
    more = [b.increment_covariance - a.increment_covariance for a, b in zip(plain.seen, slipped.seen, strict=True)]
    assert [i for i, extra in enumerate(more) if extra.any()] == [6]
    np.testing.assert_allclose(np.diag(more[6]), [0, 0, 0, 0.09, 0.09, 0.09], atol=1e-12)


def test_slips_and_pauses_come_at_the_same_times_at_any_frame_rate():
    def slips_and_pauses(rate_hz):
        scenario, plain, slipped, paused = replace(OPEN_FLAT, frame_rate_hz=rate_hz), *(Listening() for _ in range(3))
        run(scenario, plain)
        run(scenario, changed(slipped, Slip(first_s=3.0, every_s=5.0)))
        run(scenario, changed(paused, Pause(every_s=5.0)))
        slips = [
            b.stamp
            for a, b in zip(plain.seen, slipped.seen, strict=True)
            if (b.increment_covariance - a.increment_covariance).any()
        ]
        return slips, len(paused.seen) - len(plain.seen), paused.seen[-1].stamp - plain.seen[-1].stamp

    assert slips_and_pauses(2.0) == slips_and_pauses(10.0)


def test_repeated_slips_add_up():
    plain, slipped = Listening(), Listening()
    run(OPEN_FLAT, plain)
    run(OPEN_FLAT, changed(slipped, Slip(first_s=3.0, every_s=2.0, shift_m=(0.3, 0.0, 0.0))))
    moved = np.array([b.T_O_B[0, 3] - a.T_O_B[0, 3] for a, b in zip(plain.seen, slipped.seen, strict=True)])
    np.testing.assert_allclose(moved[:15], 0.3 * np.array([0] * 6 + [1] * 4 + [2] * 4 + [3]), atol=1e-12)
    more = [b.increment_covariance - a.increment_covariance for a, b in zip(plain.seen, slipped.seen, strict=True)]
    assert [i for i, extra in enumerate(more) if extra.any()] == list(range(6, len(more), 4))


def test_a_drift_in_height_raises_every_step_and_is_uncertain_of_the_vertical_alone():
    plain, risen = Listening(), Listening()
    run(OPEN_FLAT, plain)
    run(OPEN_FLAT, changed(risen, HeightDrift(rate_m_s=0.1)))
    moved = np.array([b.T_O_B[:3, 3] - a.T_O_B[:3, 3] for a, b in zip(plain.seen, risen.seen, strict=True)])
    np.testing.assert_allclose(moved, np.outer([seen.stamp for seen in plain.seen], [0.0, 0.0, 0.1]), atol=1e-12)
    for a, b in zip(plain.seen[1:], risen.seen[1:], strict=True):
        more = b.T_O_B[:3, :3] @ (b.increment_covariance - a.increment_covariance)[3:, 3:] @ b.T_O_B[:3, :3].T
        np.testing.assert_allclose(more, np.diag([0.0, 0.0, (0.1 * 0.5) ** 2]), atol=1e-12)


def test_the_two_parts_of_a_step_have_its_motion_and_its_whole_covariance():
    plain, parted = Listening(), Listening()
    run(OPEN_FLAT, plain)
    run(OPEN_FLAT, changed(parted, StepsInTwoParts()))
    assert len(parted.seen) == 2 * len(plain.seen) - 1
    for still, moved, whole in zip(parted.seen[1::2], parted.seen[2::2], plain.seen[1:], strict=True):
        step = between(still.T_O_B, moved.T_O_B)
        both = compose_covariance(still.increment_covariance, step, moved.increment_covariance)
        np.testing.assert_allclose(both, whole.increment_covariance, atol=1e-15)
    np.testing.assert_array_equal(parted.seen[1].T_O_B, plain.seen[0].T_O_B)
    stamps = [seen.stamp for seen in parted.seen]
    assert stamps == sorted(stamps) and len(set(stamps)) == len(stamps)


def test_room_names_come_in_an_order_that_is_not_the_reverse():
    names = tuple("abcdefg")
    permuted = tuple(PermutedNames().names(names))
    assert sorted(permuted) == list(names) and permuted not in (names, names[::-1])
    middle = len(names) // 2
    assert permuted[middle] != names[middle]


def test_stairs_keep_their_name_in_small_letters():
    assert dict(CapitalLetters().names(("kitchen", "stairs"))) == {"KITCHEN": "kitchen", "stairs": "stairs"}


def test_a_synonym_that_is_a_room_name_already_is_not_used():
    assert dict(Synonyms().names(("kitchen", "corridor", "hallway"))) == {
        "cooking area": "kitchen", "corridor": "corridor", "hallway": "hallway",
    }  # fmt: skip


@pytest.mark.parametrize("change", [MovedOrigin(), TurnedBody()], ids=lambda change: type(change).__name__)
def test_other_frames_give_rigid_poses_and_the_same_distances(change):
    plain, moved = Listening(), Listening()
    straight = run(OPEN_FLAT, plain)
    finished = run(OPEN_FLAT, changed(moved, change))
    np.testing.assert_allclose(finished.estimate.T_W_B, straight.estimate.T_W_B, atol=1e-9)
    assert is_rigid(np.stack([seen.T_O_B for seen in moved.seen])).all() and is_rigid(moved.camera.T_B_C)
    for a, b in zip(plain.seen, moved.seen, strict=True):
        same = np.linalg.eigvalsh(a.increment_covariance), np.linalg.eigvalsh(b.increment_covariance)
        np.testing.assert_allclose(*same, rtol=1e-6, atol=1e-15)


def test_loops_far_from_the_estimate_are_converted_like_all_others():
    """LEXIS may correct its map by loops that were refused because they are far from its estimate."""
    loop = LoopEdge(1, 0, exp(np.array([0.1, 0.2, 0.3, 1.0, 2.0, 3.0])), np.diag(np.arange(1.0, 7.0)), 50)
    far = replace(loop, match=2)
    verifier = _BetweenOtherBodies(lambda *_: Verification((loop,), (), (far,)), TurnedBody())
    query = keyframe(np.random.default_rng(1), 1, np.eye(4))
    found = verifier(query, [0, 2], PoseGraph(PoseGraphConfig()), FORWARD_CAMERA, VerificationConfig())
    (edge,), (other,) = found.edges, found.far
    assert (edge.match, other.match) == (0, 2)
    np.testing.assert_array_equal(edge.T_match_query, other.T_match_query)
    np.testing.assert_array_equal(edge.covariance, other.covariance)
    assert not np.allclose(edge.T_match_query, loop.T_match_query)


def test_copies_of_an_observation_that_close_the_same_loop_close_it_once():
    motions = np.tile(np.eye(4), (3, 1, 1))
    motions[:, 0, 3] = 1.0, 2.0, 3.0
    loops = EstimatedLoops(np.array([2, 3, 4]), np.array([0, 0, 0]), motions, np.array([0.7, 0.8, 0.9]))
    found = _moved(loops, np.array([0, 1, 2, 2, 3]), np.eye(4))
    assert found.query.tolist() == [2, 3] and found.match.tolist() == [0, 0] and found.weights.tolist() == [0.8, 0.9]
    np.testing.assert_array_equal(found.T_match_query, motions[1:])


def test_a_loop_between_observations_that_came_in_the_other_order_is_turned_around():
    """The SLAM got the observations 0, 2 and 1, and closes a loop from the third that it got to the second."""
    motion = np.eye(4)
    motion[:3, 3] = 1.0, 2.0, 3.0
    loops = EstimatedLoops(np.array([2, 2]), np.array([1, 0]), np.stack([motion, motion]), np.array([0.9, 0.8]))
    found = _moved(loops, np.array([0, 2, 1]), np.eye(4))
    assert found.query.tolist() == [2, 1] and found.match.tolist() == [1, 0] and found.weights.tolist() == [0.9, 0.8]
    np.testing.assert_allclose(found.T_match_query, [inverse(motion), motion])
