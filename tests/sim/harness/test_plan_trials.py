"""The judging of plans: the shortest path with which the length of a drive is compared."""

import numpy as np
import pytest

from sim.harness.planning import shortest_into
from worlds.house import build_house
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
