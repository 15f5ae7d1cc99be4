"""The judging of plans: the shortest path with which the length of a drive is compared."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform

from sim.harness import Estimate, Scenario, evaluate, run, try_plans
from sim.harness.planning import ask_plan, shortest_into
from worlds.house import build_house
from worlds.presets import sample_from_rooms
from worlds.spec import HouseSpec, OpeningSpec, RoomSpec, StoreySpec
from worlds.walkable import UnreachableError, Walkable


def office_beside(width_m, opening="open"):
    """An office of 4 x 3 m and, at x = 4, a kitchen of `width_m` x 3 m; between them nothing, or a wall without a door."""
    spans = {"office": (0.0, 4.0), "kitchen": (4.0, 4.0 + width_m)}
    rooms = tuple(
        RoomSpec(id=name, label=name, polygon_m=((low, 0.0), (high, 0.0), (high, 3.0), (low, 3.0)))
        for name, (low, high) in spans.items()
    )
    between = OpeningSpec(rooms=("office", "kitchen"), kind="open", start_m=(4.0, 0.0), end_m=(4.0, 3.0))
    openings = (between,) if opening == "open" else ()
    return Walkable(build_house(HouseSpec(storeys=(StoreySpec(rooms=rooms, openings=openings, furniture=()),))))


@pytest.mark.parametrize("x", [1.0, 2.5, 3.9])
def test_the_shortest_path_ends_half_a_metre_inside_the_room(x):
    walkable = office_beside(4.0)
    start = walkable.nodes[walkable.snap(np.array([x, 1.5, 0.0]))]
    assert shortest_into(walkable, start, "kitchen") == pytest.approx(4.5 - start[0], abs=walkable.resolution_m)
    assert shortest_into(walkable, start, "kitchen") >= 4.5 - start[0] - 1e-6


def test_the_shortest_path_from_far_inside_the_room_is_none_and_from_its_edge_leads_inwards():
    walkable = office_beside(4.0)
    far, edge = np.array([6.0, 1.5, 0.0]), np.array([4.1, 1.5, 0.0])
    assert shortest_into(walkable, far, "kitchen") == 0.0
    assert shortest_into(walkable, edge, "kitchen") == pytest.approx(0.4, abs=walkable.resolution_m)


def test_the_shortest_path_into_a_narrow_room_ends_where_it_is_deepest():
    """No place in a kitchen of 0.9 m width is half a metre away from its walls."""
    walkable = office_beside(0.9)
    start = walkable.nodes[walkable.snap(np.array([2.0, 1.5, 0.0]))]
    assert shortest_into(walkable, start, "kitchen") == pytest.approx(4.45 - start[0], abs=walkable.resolution_m)


def test_a_room_that_cannot_be_reached_is_named():
    with pytest.raises(UnreachableError, match="no way into any kitchen"):
        shortest_into(office_beside(4.0, "wall"), np.array([2.0, 1.5, 0.0]), "kitchen")


class Planner:
    """Knows the labels of its frames, takes poses by odometry in a world frame of its own, and plans along its walk."""

    def __init__(self, T_mine_O, labels=None):
        self.T_mine_O, self.labels = T_mine_O, labels

    def start(self, camera, room_names):
        self.room_names, self.frames, self.poses = room_names, [], []

    def process(self, observation):
        self.frames.append(observation.index)
        self.poses.append(self.T_mine_O @ observation.T_O_B)

    def finish(self):
        return Estimate(np.array(self.frames), T_W_B=np.array(self.poses), labels=self.labels, rooms=self.labels)

    def plan(self, start, goal):
        first, last = (np.flatnonzero(self.labels == self.room_names.index(name)) for name in (start, goal))
        pairs = ((abs(a - b), a, b) for a in first for b in last)
        _, a, b = min(pairs)
        step = 1 if a < b else -1
        inside = np.clip(b + 8 * step, 0, len(self.labels) - 1)  # two seconds further into the goal
        return list(range(a, inside, step))


SCENARIO = Scenario(
    house=sample_from_rooms(("kitchen", "bedroom"), seed=21), seed=5, length_m=15.0, frame_rate_hz=4.0, fidelity="features"
)


@pytest.fixture(scope="module")
def labels():
    return run(SCENARIO, Planner(np.eye(4))).true_labels


def planned(labels, T_mine_O):
    return try_plans(run(SCENARIO, Planner(T_mine_O, labels)))


def test_drives_do_not_depend_on_the_world_frame_of_the_slam(labels):
    """The world frame may be that of a camera, in which the z axis does not point up."""
    turned = RigidTransform.from_exp_coords([0.9, -1.2, 2.0, 3.0, 4.0, -5.0]).as_matrix()
    upright, oblique = planned(labels, np.eye(4)), planned(labels, turned)
    assert len(upright) == 6 and sum(trial.success for trial in upright) >= 4
    label_of = {room.id: room.label for storey in SCENARIO.house.storeys for room in storey.rooms}
    for trial in upright:
        assert trial.success == (label_of.get(trial.room) == trial.goal and not trial.touched)
    for a, b in zip(upright, oblique, strict=True):
        assert a.success == b.success and a.travelled_m == pytest.approx(b.travelled_m, abs=1e-3)


def test_a_plan_into_a_room_that_cannot_be_reached_fails_alone(labels, monkeypatch):
    def closed(walkable, start, goal):
        if goal == "kitchen":
            raise UnreachableError("no way into any kitchen; valid: a label of a room that can be reached from the start")
        return shortest_into(walkable, start, goal)

    monkeypatch.setattr("sim.harness.planning.shortest_into", closed)
    trials = planned(labels, np.eye(4))
    into = [trial for trial in trials if trial.goal == "kitchen"]
    assert not any(trial.success or trial.travelled_m for trial in into)
    assert all("no way into any kitchen" in trial.refusal for trial in into)
    assert any(trial.success for trial in trials)


@pytest.mark.parametrize("left", [1, 10])
def test_a_plan_that_does_not_begin_in_its_start_fails(labels, left):
    """Otherwise, a plan that consists of one frame in the goal would be a success without a step."""

    class Teleport(Planner):
        def plan(self, start, goal):
            return super().plan(start, goal)[-left:]

    finished = run(SCENARIO, Teleport(np.eye(4), labels))
    for trial in try_plans(finished):
        begins = finished.room_names[labels[ask_plan(finished, finished.slam, trial.start, trial.goal)[0]]]
        if begins != trial.start:
            assert not trial.success and not trial.travelled_m
            assert trial.refusal.endswith(f"it begins in a {begins} labelled {begins}, and not in a {trial.start}")
        assert begins != trial.start or left > 1


def test_a_plan_may_begin_in_a_room_that_only_the_slam_or_only_the_truth_calls_its_start(labels):
    """A plan does not fail for wrong labels alone, which lower the figures of labels."""
    wrong = np.where(labels == labels[0], labels.max(), labels)
    trials = try_plans(run(SCENARIO, Planner(np.eye(4), wrong)))
    assert trials and not [trial for trial in trials if "it begins in" in trial.refusal]


def test_a_map_that_has_diverged_gives_plans_that_nobody_drives_and_says_so(labels):
    class Diverged(Planner):
        def finish(self):
            estimate = super().finish()
            poses = estimate.T_W_B.copy()
            poses[::2, 0, 3] += 1e5
            return replace(estimate, T_W_B=poses)

    trials = try_plans(run(SCENARIO, Diverged(np.eye(4), labels)))
    assert trials and not any(trial.success for trial in trials)
    assert all("the route is" in trial.refusal and "valid: up to 10000 m" in trial.refusal for trial in trials)


def test_a_slam_that_writes_into_its_estimate_while_it_plans_does_not_change_its_figures(labels):
    class Reuses(Planner):
        def finish(self):
            self.estimate = super().finish()
            return self.estimate

        def plan(self, start, goal):
            self.estimate.T_W_B[:] = self.poses[0]
            return super().plan(start, goal)

    careless, careful = run(SCENARIO, Reuses(np.eye(4), labels)), run(SCENARIO, Planner(np.eye(4), labels))
    assert [trial.travelled_m for trial in try_plans(careless)] == [trial.travelled_m for trial in try_plans(careful)]
    assert evaluate(careless).trajectory == evaluate(careful).trajectory
