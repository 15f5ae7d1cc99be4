"""Plans: truly shortest, over edges that a robot can follow, and ending as soon as the robot is surely inside the room."""

from dataclasses import replace
from itertools import combinations, product

import networkx as nx
import numpy as np
import pytest
from helpers.map_builder import build_map, corridor_with_offices
from helpers.two_rooms import two_rooms, walked_again
from hypothesis import given
from hypothesis import strategies as st
from scipy.sparse.csgraph import connected_components

from lexis.config import SightConfig
from lexis.errors import PlanError
from lexis.planning import PathPlanner, path_end, plan
from lexis.planning import planner as module
from lexis.planning import shortcuts as shortcuts_module
from lexis.planning.arrivals import surely_inside
from lexis.planning.planner import shortest_path
from lexis.room_names import instance_names, numbered
from lexis.sight.passages import passages_in


def test_a_plan_goes_from_room_to_room_along_edges_of_the_graph(rng):
    lexis_map = corridor_with_offices(rng)
    result = plan(lexis_map, "office 1", "office 2")
    graph = PathPlanner(lexis_map).graph
    assert lexis_map.rooms[1].keyframes.count(result.keyframes[0]) == 1
    assert lexis_map.rooms[2].keyframes.count(result.keyframes[-1]) == 1
    steps = [graph[a, b] for a, b in zip(result.keyframes, result.keyframes[1:], strict=False)]
    assert min(steps) > 0 and sum(steps) == pytest.approx(result.length_m)


def test_paths_are_shortest(rng):
    """Compares with another implementation of Dijkstra, on a graph built by comparing all pairs of keyframes."""
    lexis_map = corridor_with_offices(rng, loops=[(12, 17), (39, 0), (25, 8)], weights=[1.0, 1.0, 0.1])
    positions = lexis_map.T_W_B[:, :3, 3]
    graph = nx.Graph()
    for a in range(40):
        for b in range(a):
            length = np.linalg.norm(positions[a] - positions[b])
            same_room = any(a in room.keyframes and b in room.keyframes for room in lexis_map.rooms)
            if a - b == 1 or (length <= 0.6 and (same_room or (a, b) == (17, 12))):
                graph.add_edge(a, b, weight=length)
    result = plan(lexis_map, "corridor", "office 2")
    assert result.length_m == pytest.approx(nx.dijkstra_path_length(graph, result.keyframes[0], result.keyframes[-1]))


def test_a_path_between_two_keyframes_is_the_same_in_both_directions(rng):
    """A path between two rooms is not, because it begins deep in one room and ends where the other is surely reached."""
    graph = PathPlanner(corridor_with_offices(rng, loops=[(12, 17), (39, 0)], weights=[1.0, 1.0])).graph
    for a, b in combinations(range(0, 40, 3), 2):
        assert shortest_path(graph, a, b) == shortest_path(graph, b, a)[::-1]


@pytest.mark.parametrize(("start", "goal"), [("corridor", "office 2"), ("office 1", "office 2"), ("office 2", "corridor")])
def test_a_path_ends_at_the_first_keyframe_that_is_surely_inside_the_goal(rng, start, goal):
    lexis_map = corridor_with_offices(rng)
    result = plan(lexis_map, start, goal)
    clear = max(path_end(lexis_map, room).evidence for room in lexis_map.rooms if room.label == result.goal.label)
    inside = surely_inside(lexis_map, result.goal, clear, passages_in(lexis_map, SightConfig()))
    ends = {path_end(lexis_map, result.goal).keyframe, *inside.tolist()}
    assert result.keyframes[0] == path_end(lexis_map, result.start).keyframe
    assert [keyframe in ends for keyframe in result.keyframes] == [False] * (len(result.keyframes) - 1) + [True]
    assert result.keyframes[-1] != path_end(lexis_map, result.goal).keyframe


def test_a_path_to_a_room_in_which_nothing_is_sure_ends_at_its_innermost_keyframe(rng):
    """All images show two rooms equally well, but for the kitchen, which has one keyframe of its own."""
    lexis_map = build_map(np.arange(9)[:, None] * [0.5, 0.0, 0.0], [0] * 4 + [1] + [0] * 4,
                          [("office", [0, 1, 2, 3, 5, 6, 7, 8]), ("kitchen", [4])], ("office", "kitchen"), rng)  # fmt: skip
    kitchen = lexis_map.rooms[1]
    assert plan(lexis_map, "office", "kitchen").keyframes[-1] == path_end(lexis_map, kitchen).keyframe


@pytest.mark.parametrize("way", [range(21, -1, -1), [21, 11, 0, 16, 4]])
def test_all_rooms_can_be_reached_and_left_after_keyframes_have_retired(rng, way):
    """Between the few keyframes of the second way are gaps in the recording."""
    longer = walked_again(two_rooms(rng, stairs=False), list(way))
    assert connected_components(PathPlanner(longer).graph, directed=False)[0] == 1
    active = replace(longer, keyframes=tuple(replace(keyframe, anchor=None) for keyframe in longer.keyframes))
    for start, goal in (("kitchen", "office"), ("office", "kitchen")):
        assert plan(longer, start, goal).length_m == pytest.approx(plan(active, start, goal).length_m, abs=0.3)


def test_one_planner_makes_the_same_plans_as_many(rng):
    lexis_map = ring_of_rooms(rng)
    planner = PathPlanner(lexis_map)
    asked = [("kitchen", "office", ()), ("kitchen", "office", ("bathroom",)), ("kitchen", "office", ())]
    assert [planner.plan(*one) for one in asked] == [plan(lexis_map, a, b, avoid=avoid) for a, b, avoid in asked]


@pytest.mark.parametrize(
    ("start", "goal", "chosen"),
    [
        ("kitchen", "office", ("kitchen", "office 1")),
        ("office", "kitchen", ("office 1", "kitchen")),
        ("office", "library", ("office 2", "library")),
        ("office 1", "library", ("office 1", "library")),
    ],
)
def test_a_label_alone_means_the_nearest_of_its_rooms(rng, start, goal, chosen):
    """All rooms lie along one line, and the office near the kitchen is the smaller one. Agrees with comparing all pairs."""
    members = [("kitchen", range(5)), ("office", range(5, 9)), ("corridor", range(9, 30)), ("office", range(30, 50))]
    members.append(("library", range(50, 55)))
    names = ("kitchen", "office", "corridor", "library")
    labels = np.concatenate([[names.index(label)] * len(keyframes) for label, keyframes in members])
    lexis_map = build_map(np.arange(55)[:, None] * [0.5, 0.0, 0.0], labels, members, names, rng)
    result = plan(lexis_map, start, goal)
    instances = instance_names(lexis_map.rooms)
    assert (instances[result.start.id], instances[result.goal.id]) == chosen
    pairs = product(*([name for name in instances if name.startswith(wanted)] for wanted in (start, goal)))
    assert result.length_m == min(plan(lexis_map, *pair).length_m for pair in pairs)


def test_a_doubtful_room_stands_for_its_label_only_where_there_is_no_other(rng):
    lexis_map = corridor_with_offices(rng)
    nearest = plan(lexis_map, "corridor", "office").goal
    other = lexis_map.rooms[3 - nearest.id]
    similarities = lexis_map.similarities.copy()
    similarities[list(nearest.keyframes), 2] = 0.9  # looks like a kitchen
    misread = replace(lexis_map, similarities=similarities)
    assert plan(misread, "corridor", "office").goal is other
    assert plan(misread, "corridor", f"office {nearest.id}").goal is nearest
    similarities[list(other.keyframes), 2] = 0.9
    assert plan(misread, "corridor", "office").goal is nearest


@pytest.mark.parametrize(
    ("share", "probability", "chosen"),
    [(0.4, 0.8, "other"), (0.6, 0.8, "nearest"), (0.4, 0.95, "nearest"), (0.4, 1.0, "other")],
)
def test_a_room_is_doubtful_beside_a_clearer_one_of_its_label_unless_its_label_is_certain(share, probability, chosen, rng):
    """A method that states no probability gives all labels the probability 1, which says nothing."""
    lexis_map = corridor_with_offices(rng)
    nearest = plan(lexis_map, "corridor", "office").goal
    other = lexis_map.rooms[3 - nearest.id]
    similarities = np.zeros_like(lexis_map.similarities)
    similarities[np.arange(len(lexis_map.labels)), lexis_map.labels] = 0.5
    similarities[list(nearest.keyframes)] *= share
    probabilities = lexis_map.probabilities.copy()
    probabilities[list(nearest.keyframes)] = (1.0 - probability) / (len(lexis_map.room_names) - 1)
    probabilities[list(nearest.keyframes), lexis_map.room_names.index("office")] = probability
    dimmed = replace(lexis_map, similarities=similarities, probabilities=probabilities)
    clear = path_end(dimmed, other).evidence
    assert path_end(dimmed, nearest).evidence == pytest.approx(share * clear)
    assert plan(dimmed, "corridor", "office").goal is {"other": other, "nearest": nearest}[chosen]


def test_rooms_go_by_label_or_number(rng):
    lexis_map = corridor_with_offices(rng)
    assert instance_names(lexis_map.rooms) == ("corridor", "office 1", "office 2")
    same = plan(lexis_map, " Office 1 ", "office 1")
    assert same.start is same.goal is lexis_map.rooms[1]
    assert len(same.keyframes) == 1 and same.length_m == 0.0


@given(st.lists(st.sampled_from(["office", "Office 1", "office 2", "office 1 1", "hall", "lab {x}"]), max_size=9))
def test_every_room_has_a_name_of_its_own(labels):
    names = numbered(labels)
    assert len({name.lower() for name in names}) == len(labels)
    assert all(name == label or labels.count(label) > 1 for name, label in zip(names, labels, strict=True))


def test_unknown_rooms_and_missing_paths_are_named(rng):
    lexis_map = corridor_with_offices(rng)
    with pytest.raises(PlanError, match=r"no room 'garage'.*corridor, office 1, office 2"):
        plan(lexis_map, "garage", "office")
    torn = lexis_map.T_W_B.copy()
    torn[30:, 0, 3] += 100.0
    with pytest.raises(PlanError, match="no path from corridor to office 2"):
        plan(replace(lexis_map, T_W_B=torn), "corridor", "office 2")


def ring_of_rooms(rng):
    """A square walk through four rooms, which ends where it began: two ways lead from any room to the opposite one."""
    side = np.arange(0, 5, 0.5)
    corners = [(side, 0 * side), (0 * side + 5, side), (5 - side, 0 * side + 5), (0 * side, 5 - side)]
    positions = np.concatenate([np.stack([x, y, 0 * x], 1) for x, y in corners] + [np.zeros((1, 3))])
    names = ("kitchen", "bathroom", "office", "corridor")
    rooms = [(name, range(10 * i, 10 * i + 10 + (i == 3))) for i, name in enumerate(names)]
    return build_map(positions, np.append(np.repeat(range(4), 10), 3), rooms, names, rng, loops=[(40, 0)], weights=[1.0])


def test_a_path_leads_around_the_rooms_to_avoid(rng):
    lexis_map = ring_of_rooms(rng)
    for closed, other in (("bathroom", 3), ("corridor", 1)):
        keyframes = plan(lexis_map, "kitchen", "office", avoid=[closed]).keyframes
        labels = set(lexis_map.room_of[list(keyframes)])
        assert other in labels and lexis_map.room_names.index(closed) not in labels


def test_rooms_are_avoided_alike_when_the_steps_are_checked_in_parts(rng, monkeypatch):
    lexis_map, sizes = ring_of_rooms(rng), []

    def points_between(positions, steps, metres):
        points = shortcuts_module.points_between(positions, steps, metres)
        sizes.append(points.shape[0] * points.shape[1])
        return points

    whole = plan(lexis_map, "kitchen", "office", avoid=["bathroom"])
    monkeypatch.setattr(module, "points_between", points_between)
    monkeypatch.setattr(shortcuts_module, "_CHUNK", 200)
    assert plan(lexis_map, "kitchen", "office", avoid=["bathroom"]) == whole
    assert len(sizes) > 1 and max(sizes) <= 200


@pytest.mark.parametrize(
    ("avoid", "message"),
    [
        (["bathroom", "corridor"], "no path from kitchen to office without bathroom, corridor; valid: fewer"),
        (["office"], "every place where the path could begin or end in 'office' is in a room to avoid; valid: "),
        (["garage"], "no room 'garage'.*valid: kitchen, bathroom, office, corridor"),
    ],
)
def test_rooms_to_avoid_that_leave_no_path_are_named(rng, avoid, message):
    with pytest.raises(PlanError, match=message):
        plan(ring_of_rooms(rng), "kitchen", "office", avoid=avoid)


def test_no_shortcut_leads_through_a_room_to_avoid(rng):
    """The walk from the kitchen to the office makes a bend through a closet, which the shortcuts cut off."""
    lexis_map = two_rooms(rng, stairs=False)
    bend = range(4, 9)
    kitchen, office = (set(room.keyframes) - set(bend) for room in lexis_map.rooms)
    members = [("kitchen", sorted(kitchen)), ("office", sorted(office)), ("closet", bend)]
    rooms = tuple(
        replace(lexis_map.rooms[0], id=i, label=name, keyframes=tuple(ids)) for i, (name, ids) in enumerate(members)
    )
    labels = np.where(np.isin(np.arange(len(lexis_map.labels)), bend), 2, lexis_map.labels)
    similarities = np.full((len(labels), 3), 0.1)
    similarities[np.arange(len(labels)), labels] = 0.6
    names = ("kitchen", "office", "closet")
    lexis_map = replace(lexis_map, rooms=rooms, labels=labels, similarities=similarities, room_names=names)
    straight = plan(lexis_map, "kitchen", "office").keyframes
    assert len(straight) < len(lexis_map.keyframes) / 3
    with pytest.raises(PlanError, match="no path from kitchen to office without closet"):
        plan(lexis_map, "kitchen", "office", avoid=["closet"])
