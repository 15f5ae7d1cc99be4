"""The first wrong frame is the first one at which what a figure measures is wrong."""

from dataclasses import replace

import numpy as np
import pytest

from sim.harness import Estimate, LoopClaims, Scenario, run
from sim.harness.first_wrong import first_wrong
from worlds.presets import sample_from_rooms

SCENARIO = Scenario(
    house=sample_from_rooms(("kitchen", "bedroom"), seed=21), seed=5, length_m=15.0, frame_rate_hz=4.0, fidelity="features"
)
WRONG = 7
"""The row that is wrong; row 9 is wrong, too."""


class Frames:
    """Takes every frame, and claims nothing."""

    def start(self, camera, room_names):
        self.frames = []

    def process(self, observation):
        self.frames.append(observation.index)

    def finish(self):
        return Estimate(np.array(self.frames))


@pytest.fixture(scope="module")
def silent():
    return run(SCENARIO, Frames())


@pytest.fixture(scope="module")
def true(silent):
    """A run that claims the truth."""
    loops = LoopClaims(np.array([5]), np.array([3]), np.eye(4)[None], np.ones(1))
    poses = silent.true_poses
    loops = replace(loops, T_match_query=np.linalg.inv(poses[3:4]) @ poses[5:6])
    claims = Estimate(
        silent.estimate.frames,
        T_W_B=poses,
        labels=silent.true_labels,
        rooms=silent.true_rooms,
        floors=silent.true_storeys,
        loops=loops,
        similarities=np.tile(np.linspace(0.3, 0.1, len(silent.room_names)), (len(poses), 1)),
    )
    return replace(silent, estimate=claims)


def spoilt(claim):
    """The claim with rows `WRONG` and 9 changed."""
    changed = claim.copy()
    if claim.ndim == 3:
        changed[[WRONG, 9], 0, 3] += 5.0
    else:
        changed[[WRONG, 9]] = (changed[[WRONG, 9]] + 1) % 2
    return changed


@pytest.mark.parametrize(
    ("name", "figure", "said"),
    [
        ("labels", "labels.accuracy", "labelled "),
        ("labels", "rooms.pq", "labelled "),
        ("labels", None, "labelled "),
        ("rooms", "rooms.pq", "in the claimed room "),
        ("floors", "floors.accuracy", "floor 1 claimed, is on floor 0"),
        ("T_W_B", "trajectory.ate_m", "the position is "),
    ],
)
def test_the_first_of_two_wrong_frames_is_found(true, name, figure, said):
    claims = replace(true.estimate, **{name: spoilt(getattr(true.estimate, name))})
    found = first_wrong(replace(true, estimate=claims), figure)
    assert found.frame == true.estimate.frames[WRONG] and found.what.startswith(said)
    assert found.time_s == pytest.approx(true.stamps[WRONG] - true.stamps[0])
    assert found.room == true.house.rooms[true.true_rooms[WRONG]].id
    assert bool(found.similarities) == (figure is None or figure.startswith(("labels", "rooms")))


def test_a_false_loop_is_found_at_its_query(true):
    assert first_wrong(true, "loops.precision") is None
    far = np.eye(4)[None].copy()
    far[0, 0, 3] = 9.0
    moved = replace(true.estimate.loops, T_match_query=far)
    found = first_wrong(replace(true, estimate=replace(true.estimate, loops=moved)), "loops.precision")
    assert found.frame == true.estimate.frames[5] and found.what.startswith("a false loop closure with the frame at 0.")


def test_the_truth_has_no_wrong_frame(true):
    for figure in ("labels.accuracy", "rooms.pq", "floors.accuracy", "loops.precision"):
        assert first_wrong(true, figure) is None
    assert "no label is wrong, the largest position error is 0.00 m" in str(first_wrong(true))


def test_where_nothing_is_claimed_nothing_is_wrong(silent):
    for figure in (None, "labels.accuracy", "rooms.pq", "floors.accuracy", "loops.precision", "trajectory.ate_m"):
        assert first_wrong(silent, figure) is None


def test_a_frame_in_no_claimed_room_is_said_to_be_in_none(true):
    rooms = true.true_rooms.copy()
    rooms[WRONG] = -1
    found = first_wrong(replace(true, estimate=replace(true.estimate, rooms=rooms)), "rooms.pq")
    assert (found.frame, found.what) == (true.estimate.frames[WRONG], "in no claimed room")


def test_a_frame_without_a_label_is_said_to_have_none(true):
    labels = true.true_labels.copy()
    labels[WRONG] = -1
    found = first_wrong(replace(true, estimate=replace(true.estimate, labels=labels)))
    assert found.what == f"no label, is {true.room_names[true.true_labels[WRONG]]}"
