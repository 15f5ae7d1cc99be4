"""Paths begin well inside a room, wherever its images were taken."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.map_builder import CAMERA, build_map, corridor_with_offices, random_pose

from lexis.floors import NO_FLOOR
from lexis.planning import path_end


def test_a_path_begins_deep_in_the_room(rng):
    lexis_map = corridor_with_offices(rng)
    similarities = lexis_map.similarities.copy()
    similarities[30, 1] = 0.99  # looks most like an office, but lies at the door of the office
    similarities[34:38, 1] = 0.95
    lexis_map = replace(lexis_map, similarities=similarities)
    assert path_end(lexis_map, lexis_map.rooms[2]).keyframe in range(34, 38)


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


def test_rooms_of_one_label_side_by_side_have_ends_of_their_own(rng):
    """Images taken in one room look into the other, and the evidence is the same for both."""
    lexis_map = open_boundary(rng, and_back=True)
    x = lexis_map.T_W_B[:, 0, 3]
    halves = [np.flatnonzero(x < 0.0).tolist(), np.flatnonzero(x >= 0.0).tolist()]
    rooms = tuple(replace(lexis_map.rooms[1], id=i, keyframes=tuple(half)) for i, half in enumerate(halves))
    lexis_map = replace(lexis_map, rooms=rooms, labels=np.ones(len(x), int))
    assert all(path_end(lexis_map, room).keyframe in room.keyframes for room in rooms)
