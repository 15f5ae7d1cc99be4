"""Room instances: names and frames do not matter, no room spans floors, and rooms merge only with nothing between them."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lexis.config import SegmentationConfig
from lexis.room_segmentation import segment

NAMES = ("office", "corridor", "stairs")
OFFICE, CORRIDOR, STAIRS = range(3)


def line(start, stop, spacing=0.5):
    """Positions along a straight line [m]."""
    start, stop = np.array(start, float), np.array(stop, float)
    count = max(int(np.linalg.norm(stop - start) / spacing), 1)
    return start + np.linspace(0.0, 1.0, count, endpoint=False)[:, None] * (stop - start)


def walk(*legs):
    """Labels and positions along legs (label, start, stop)."""
    parts = [(label, line(start, stop)) for label, start, stop in legs]
    return np.concatenate([np.full(len(p), label) for label, p in parts]), np.concatenate([p for _, p in parts])


TWO_OFFICES = walk(
    (CORRIDOR, (0, 0, 0), (4, 0, 0)),
    (OFFICE, (4, 0, 0), (4, 4, 0)),
    (OFFICE, (4, 4, 0), (4, 0, 0)),
    (CORRIDOR, (4, 0, 0), (12, 0, 0)),
    (OFFICE, (12, 0, 0), (12, 4, 0)),
    (OFFICE, (12, 4, 0), (12, 0, 0)),
    (CORRIDOR, (12, 0, 0), (0, 0, 0)),
    (OFFICE, (4, 1, 0), (4, 4, 0)),
)


def test_offices_off_one_corridor_are_two_and_a_second_visit_is_no_third():
    labels, positions = TWO_OFFICES
    rooms = segment(labels, positions, NAMES, SegmentationConfig()).rooms
    assert [room.label for room in rooms] == ["corridor", "office", "office"]
    assert max(rooms[1].keyframes) == len(labels) - 1


def test_stairs_are_told_by_their_name_without_regard_to_case():
    labels, positions = walk((OFFICE, (0, 0, 0), (4, 0, 0)), (STAIRS, (4, 0, 0), (8, 0, 3)), (OFFICE, (8, 0, 3), (12, 0, 3)))
    small, capital = (segment(labels, positions, (*NAMES[:2], name), SegmentationConfig()) for name in ("stairs", "Stairs"))
    np.testing.assert_array_equal(small.floors, capital.floors)
    assert set(small.floors.tolist()) == {-1, 0, 1}


def test_a_long_room_is_one_although_its_clusters_are_several():
    labels, positions = walk((OFFICE, (0, 0, 0), (30, 0, 0)))
    assert len(segment(labels, positions, NAMES, SegmentationConfig()).rooms) == 1


@pytest.mark.parametrize(("gap_m", "rooms"), [(2.9, 1), (3.1, 2)])
def test_offices_on_both_sides_of_a_gap_in_the_recording_are_two(gap_m, rooms):
    labels, positions = walk((OFFICE, (0, 0, 0), (4, 0, 0)), (OFFICE, (3.5 + gap_m, 0, 0), (8, 0, 0)))
    assert len(segment(labels, positions, NAMES, SegmentationConfig()).rooms) == rooms


def test_two_visits_merge_only_with_nothing_in_between():
    """The paths in two offices run 1.2 m apart; with the path of a corridor between them they stay two rooms."""
    far = 40.0
    apart = [(OFFICE, (0, 0, 0), (16, 0, 0)), (CORRIDOR, (16, far, 0), (0, far, 0)), (OFFICE, (0, 1.2, 0), (16, 1.2, 0))]
    config = SegmentationConfig(adjacency_m=1.5)
    assert sum(room.label == "office" for room in segment(*walk(*apart), NAMES, config).rooms) == 1
    between = walk(*apart[:1], (CORRIDOR, (16, 0.6, 0), (-1, 0.6, 0)), *apart[2:])
    narrow = SegmentationConfig(adjacency_m=1.5, distance_m=0.7)
    assert sum(room.label == "office" for room in segment(*between, NAMES, narrow).rooms) == 2


HOUSE = walk(
    (OFFICE, (0, 0, 0), (4, 0, 0)),
    (STAIRS, (4, 0, 0), (8, 0, 2.9)),
    (OFFICE, (8, 0, 2.9), (0, 0, 2.9)),
    (OFFICE, (0, 0, 2.9), (8, 0, 2.9)),
    (STAIRS, (8, 0, 2.9), (4, 0, 0)),
    (OFFICE, (4, 0, 0), (0, 0, 0)),
)


def test_floors_part_at_the_stairs_and_no_room_spans_them():
    labels, positions = HOUSE
    result = segment(labels, positions, NAMES, SegmentationConfig())
    np.testing.assert_array_equal(result.floors, np.where(labels == STAIRS, -1, (positions[:, 2] > 1.4).astype(int)))
    assert [(room.label, room.floor) for room in result.rooms] == [("office", 0), ("stairs", None), ("office", 1)]


def test_drift_of_height_between_stairs_makes_no_floor():
    labels, positions = walk(*[leg for _ in range(4) for leg in _lap()])
    drifted = positions + np.linspace(0.0, 4.0, len(labels))[:, None] * [0.0, 0.0, 1.0] * (len(labels) > 0)
    floors = segment(labels, drifted, NAMES, SegmentationConfig()).floors
    np.testing.assert_array_equal(floors, np.where(labels == STAIRS, -1, (positions[:, 2] > 1.4).astype(int)))


def _lap():
    return [
        (CORRIDOR, (0, 0, 0), (20, 0, 0)), (CORRIDOR, (20, 0, 0), (0, 0, 0)), (STAIRS, (0, 0, 0), (0, 4, 2.9)),
        (CORRIDOR, (0, 4, 2.9), (20, 4, 2.9)), (CORRIDOR, (20, 4, 2.9), (0, 4, 2.9)), (STAIRS, (0, 4, 2.9), (0, 0, 0)),
    ]  # fmt: skip


def test_flights_above_one_another_are_one_staircase():
    flights = [
        leg
        for z in (0.0, 3.0, 6.0, 9.0)
        for leg in [
            (CORRIDOR, (10, 4, z), (6, 0, z)),
            (STAIRS, (6, 0, z), (10, 0, z + 3)),
            (CORRIDOR, (10, 0, z + 3), (10, 4, z + 3)),
        ]
    ]
    result = segment(*walk(*flights), NAMES, SegmentationConfig())
    assert sum(room.label == "stairs" for room in result.rooms) == 1
    assert set(result.floors.tolist()) == {-1, 0, 1, 2, 3, 4}


@st.composite
def scattered(draw):
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    n = draw(st.integers(0, 60))
    return rng.integers(0, 3, n), rng.uniform(0.0, 12.0, (n, 3)) * [1.0, 1.0, 0.3], rng


@given(scattered())
def test_rooms_partition_the_keyframes_and_agree_with_labels_and_floors(drawn):
    labels, positions, _ = drawn
    result = segment(labels, positions, NAMES, SegmentationConfig())
    assert sorted(i for room in result.rooms for i in room.keyframes) == list(range(len(labels)))
    assert [room.keyframes[0] for room in result.rooms] == sorted(room.keyframes[0] for room in result.rooms)
    for k, room in enumerate(result.rooms):
        members = list(room.keyframes)
        assert room.id == k
        assert {NAMES[i] for i in labels[members]} == {room.label}
        assert set(result.floors[members].tolist()) == {-1 if room.floor is None else room.floor}
        np.testing.assert_allclose(room.mean, positions[members].mean(axis=0))


@given(scattered())
def test_rooms_do_not_depend_on_the_world_frame_or_the_order_of_names(drawn):
    labels, positions, rng = drawn
    expected = segment(labels, positions, NAMES, SegmentationConfig())
    yaw, order = rng.uniform(-np.pi, np.pi), rng.permutation(3)
    turn = np.array([[np.cos(yaw), -np.sin(yaw), 0.0], [np.sin(yaw), np.cos(yaw), 0.0], [0.0, 0.0, 1.0]])
    renamed = np.argsort(order)[labels] if len(labels) else labels
    moved = segment(renamed, positions @ turn.T + [5.0, -2.0, 1.0], tuple(NAMES[i] for i in order), SegmentationConfig())
    assert [room.keyframes for room in moved.rooms] == [room.keyframes for room in expected.rooms]
    np.testing.assert_array_equal(moved.floors, expected.floors)


@pytest.mark.parametrize("label", [OFFICE, STAIRS])
def test_one_keyframe_is_one_room(label):
    result = segment(np.array([label]), np.zeros((1, 3)), NAMES, SegmentationConfig())
    assert len(result.rooms) == 1 and result.rooms[0].keyframes == (0,)
