"""Plans: truly shortest, over edges that a robot can follow, and ending inside the room."""

from dataclasses import replace
from itertools import product

import networkx as nx
import numpy as np
import pytest
from helpers.map_builder import CAMERA, build_map, corridor_with_offices, random_pose

from lexis.config import PlannerConfig
from lexis.errors import PlanError
from lexis.floors import NO_FLOOR
from lexis.planning import adjacency, path_end, plan
from lexis.room_names import instance_names


def test_a_plan_goes_from_room_to_room_along_edges_of_the_graph(rng):
    lexis_map = corridor_with_offices(rng)
    result = plan(lexis_map, "office 1", "office 2")
    graph = adjacency(lexis_map, PlannerConfig())
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


def test_a_path_and_its_reverse_are_equally_long(rng):
    lexis_map = corridor_with_offices(rng)
    there, back = plan(lexis_map, "office 1", "corridor"), plan(lexis_map, "corridor", "office 1")
    assert back.length_m == pytest.approx(there.length_m) and back.keyframes == there.keyframes[::-1]


def test_rooms_are_joined_where_the_robot_walked_and_not_through_a_wall(rng):
    """The paths in two rooms run 0.4 m apart, with a wall between them; the door is at the far end."""
    x = np.arange(0, 5, 0.5)
    positions = np.concatenate([np.stack([x, 0 * x, 0 * x], 1), np.stack([x[::-1], 0 * x + 0.4, 0 * x], 1)])
    rooms = [("office", range(10)), ("kitchen", range(10, 20))]
    lexis_map = build_map(positions, np.repeat([0, 1], 10), rooms, ("office", "kitchen"), rng)
    assert adjacency(lexis_map, PlannerConfig())[0, 19] == 0.0
    assert adjacency(replace(lexis_map, rooms=()), PlannerConfig())[9, 10] > 0.0


@pytest.mark.parametrize(("weight", "joined"), [(1.0, True), (0.1, False)])
def test_only_trusted_loops_join_rooms(rng, weight, joined):
    lexis_map = corridor_with_offices(rng, loops=[(20, 10)], weights=[weight])
    assert (adjacency(lexis_map, PlannerConfig())[20, 10] > 0) == joined


def test_a_path_ends_deep_in_the_room(rng):
    lexis_map = corridor_with_offices(rng)
    similarities = lexis_map.similarities.copy()
    similarities[30, 1] = 0.99  # looks most like an office, but lies at the door of the office
    similarities[34:38, 1] = 0.95
    lexis_map = replace(lexis_map, similarities=similarities)
    assert path_end(lexis_map, lexis_map.rooms[2]).keyframe in range(34, 38)
    assert plan(lexis_map, "corridor", "office 2").keyframes[-1] in range(34, 38)


def open_boundary(rng, and_back=False):
    """A walk along x through an office into a kitchen, optionally there and back. The rooms meet at x = 0 without a wall.

    The camera looks ahead. Its image shows the room that lies 1.5 m ahead: best from a viewpoint in front of the room, and
    only little from deep inside, where the camera faces a wall. As in LEXIS, a keyframe has the label that its image
    resembles most.
    """
    x = np.arange(-4.0, 4.1, 0.2)
    forward = np.ones(len(x))
    if and_back:
        x, forward = np.concatenate([x, x[::-1]]), np.concatenate([forward, -forward])
    shown = (x + 1.5 * forward > 0.0).astype(int)
    names = ("office", "kitchen")
    rooms = [(name, np.flatnonzero(shown == i).tolist()) for i, name in enumerate(names)]
    lexis_map = build_map(x[:, None] * [1.0, 0.0, 0.0], shown, rooms, names, rng)
    similarities = np.zeros((len(x), 2))
    similarities[np.arange(len(x)), shown] = 0.5 - 0.08 * np.abs(x + 0.75 * forward)
    return looking_ahead(replace(lexis_map, similarities=similarities), forward)


def looking_ahead(lexis_map, forward):
    """A map with a camera that looks along x, or in the opposite direction where `forward` (n,) is -1."""
    T_B_C, poses = np.eye(4), np.tile(np.eye(4), (len(forward), 1, 1))
    T_B_C[:3, :3] = [[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]]  # the optical axis along the x axis of the body
    poses[:, 0, 0] = poses[:, 1, 1] = forward
    poses[:, :3, 3] = lexis_map.T_W_B[:, :3, 3]
    return replace(lexis_map, camera=replace(CAMERA, T_B_C=T_B_C), T_W_B=poses)


@pytest.mark.parametrize("and_back", [False, True])
def test_a_path_ends_behind_an_open_boundary_and_not_where_the_room_comes_into_view(rng, and_back):
    lexis_map = open_boundary(rng, and_back)
    end = path_end(lexis_map, lexis_map.rooms[1])
    assert end.keyframe in end.room.keyframes
    assert lexis_map.T_W_B[end.keyframe, 0, 3] >= 0.5


def test_a_path_ends_inside_a_room_that_is_recognised_from_in_front_of_it_alone(rng):
    """A bathroom at x > 0 fills the image on the way in until the camera faces its wall; on the way out it is behind."""
    there = np.arange(-3.0, 1.6, 0.2)
    x, forward = np.concatenate([there, there[::-1]]), np.repeat([1.0, -1.0], len(there))
    seen = (forward > 0.0) & (x > -1.5) & (x < 0.0)
    rooms = [("corridor", np.flatnonzero(~seen).tolist()), ("bathroom", np.flatnonzero(seen).tolist())]
    lexis_map = build_map(x[:, None] * [1.0, 0.0, 0.0], seen.astype(int), rooms, ("corridor", "bathroom"), rng)
    similarities = np.where(seen[:, None], [0.0, 0.5], [0.5, 0.0])
    similarities[(forward > 0.0) & (x >= 0.0)] = 0.1  # at the wall
    lexis_map = looking_ahead(replace(lexis_map, similarities=similarities), forward)
    end = path_end(lexis_map, lexis_map.rooms[1])
    assert end.evidence > 0.0
    assert lexis_map.T_W_B[end.keyframe, 0, 3] >= 0.3


def walk_along_x(rng, x, room_of, similarities):
    """A walk along x (n,) with the camera ahead, through rooms 0 and 1; `similarities` (n, 2) are those with their names."""
    names = ("corridor", "kitchen")
    rooms = [(name, np.flatnonzero(room_of == i).tolist()) for i, name in enumerate(names)]
    lexis_map = build_map(x[:, None] * [1.0, 0.0, 0.0], room_of, rooms, names, rng)
    return looking_ahead(replace(lexis_map, similarities=similarities), np.ones(len(x)))


def test_a_path_ends_a_metre_inside_a_room_that_shows_best_from_its_door(rng):
    """The kitchen at x > 0 fills the image from 2.2 m in front of it, and less and less so from 1.2 m on."""
    x = np.arange(-5.0, 4.1, 0.25)
    kitchen = np.where(x > -1.2, 0.3, 1.0) * (x > -2.2)
    similarities = np.stack([np.where(kitchen > 0.0, 0.0, 0.6), kitchen], axis=1)
    lexis_map = walk_along_x(rng, x, (kitchen > 0.0).astype(int), similarities)
    end = path_end(lexis_map, lexis_map.rooms[1])
    assert lexis_map.T_W_B[end.keyframe, 0, 3] >= 1.0


def test_a_path_ends_a_metre_away_from_stairs(rng):
    """The corridor at x < 0 shows best beside the stairs, and also on them: only the climb identifies stairs."""
    x = np.arange(-5.0, 3.1, 0.25)
    climbs = x >= 0.0
    similarities = np.stack([0.6 - 0.02 * np.abs(x + 1.5), np.zeros(len(x))], axis=1)
    lexis_map = walk_along_x(rng, x, climbs.astype(int), similarities)
    stairs = replace(lexis_map.rooms[1], floor=None)
    lexis_map = replace(lexis_map, rooms=(lexis_map.rooms[0], stairs), floors=np.where(climbs, NO_FLOOR, 0))
    end = path_end(lexis_map, lexis_map.rooms[0])
    assert lexis_map.T_W_B[end.keyframe, 0, 3] <= -1.0


def test_a_path_to_stairs_ends_on_them(rng):
    x = np.arange(-5.0, 3.1, 0.25)
    climbs = x >= 0.0
    similarities = np.stack([0.3 - 0.1 * x, 0.3 + 0.1 * x], axis=1)
    lexis_map = walk_along_x(rng, x, climbs.astype(int), similarities)
    stairs = replace(lexis_map.rooms[1], floor=None)
    lexis_map = replace(lexis_map, rooms=(lexis_map.rooms[0], stairs), floors=np.where(climbs, NO_FLOOR, 0))
    assert path_end(lexis_map, stairs).keyframe in stairs.keyframes
    assert path_end(lexis_map, stairs).evidence > 0.0


def test_where_a_path_ends_does_not_depend_on_the_frame_of_the_map(rng):
    lexis_map = open_boundary(rng, and_back=True)
    moved = replace(lexis_map, T_W_B=random_pose(rng, (3.0, -7.0, 1.0)) @ lexis_map.T_W_B)
    for room in lexis_map.rooms:
        assert path_end(moved, room).keyframe == path_end(lexis_map, room).keyframe


def test_a_path_ends_at_the_first_of_keyframes_equally_far_inside(rng):
    """Two keyframes are at the same position: one on the way out, one on the way back."""
    lexis_map = open_boundary(rng, and_back=True)
    for room in lexis_map.rooms:
        end = path_end(lexis_map, room).keyframe
        same = np.flatnonzero(lexis_map.T_W_B[:, 0, 3] == lexis_map.T_W_B[end, 0, 3])
        assert end == min(set(same.tolist()) & set(room.keyframes))


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


@pytest.mark.parametrize(("share", "chosen"), [(0.4, "other"), (0.6, "nearest")])
def test_a_room_is_doubtful_beside_a_clearer_one_of_its_label(share, chosen, rng):
    lexis_map = corridor_with_offices(rng)
    nearest = plan(lexis_map, "corridor", "office").goal
    other = lexis_map.rooms[3 - nearest.id]
    similarities = np.zeros_like(lexis_map.similarities)
    similarities[np.arange(len(lexis_map.labels)), lexis_map.labels] = 0.5
    similarities[list(nearest.keyframes)] *= share
    dimmed = replace(lexis_map, similarities=similarities)
    clear = path_end(dimmed, other).evidence
    assert path_end(dimmed, nearest).evidence == pytest.approx(share * clear)
    assert plan(dimmed, "corridor", "office").goal is {"other": other, "nearest": nearest}[chosen]


def test_rooms_go_by_label_or_number(rng):
    lexis_map = corridor_with_offices(rng)
    assert instance_names(lexis_map.rooms) == ("corridor", "office 1", "office 2")
    same = plan(lexis_map, " Office 1 ", "office 1")
    assert same.start is same.goal is lexis_map.rooms[1]
    assert len(same.keyframes) == 1 and same.length_m == 0.0


def test_unknown_rooms_and_missing_paths_are_named(rng):
    lexis_map = corridor_with_offices(rng)
    with pytest.raises(PlanError, match=r"no room 'garage'.*corridor, office 1, office 2"):
        plan(lexis_map, "garage", "office")
    torn = lexis_map.T_W_B.copy()
    torn[30:, 0, 3] += 100.0
    with pytest.raises(PlanError, match="no path from corridor to office 2"):
        plan(replace(lexis_map, T_W_B=torn), "corridor", "office 2")


def test_rooms_of_one_label_side_by_side_have_ends_of_their_own(rng):
    """Images taken in one room look into the other, and the evidence is the same for both."""
    lexis_map = open_boundary(rng, and_back=True)
    x = lexis_map.T_W_B[:, 0, 3]
    halves = [np.flatnonzero(x < 0.0).tolist(), np.flatnonzero(x >= 0.0).tolist()]
    rooms = tuple(replace(lexis_map.rooms[1], id=i, keyframes=tuple(half)) for i, half in enumerate(halves))
    lexis_map = replace(lexis_map, rooms=rooms, labels=np.ones(len(x), int))
    assert all(path_end(lexis_map, room).keyframe in room.keyframes for room in rooms)


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


@pytest.mark.parametrize(
    ("avoid", "message"),
    [
        (["bathroom", "corridor"], "no path from kitchen to office without bathroom, corridor; valid: fewer"),
        (["office"], "would begin or end in 'office'"),
        (["garage"], "no room 'garage'.*valid: kitchen, bathroom, office, corridor"),
    ],
)
def test_rooms_to_avoid_that_leave_no_path_are_named(rng, avoid, message):
    with pytest.raises(PlanError, match=message):
        plan(ring_of_rooms(rng), "kitchen", "office", avoid=avoid)
