"""`ClosingDoors`: doors that are closed unless the body is near them."""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float64

from sim.render.actor import Actor
from worlds.house import House
from worlds.openings.doors import DoorLeaf, hang_leaves
from worlds.spec import LeafSpec, OpeningSpec
from worlds.visuals.meshes import Solid

_OPEN_WITHIN_M, _SHUT_BEYOND_M = 1.1, 1.9
"""Horizontal distances between the body and a doorway at which the door is fully open and fully closed [m]. The first
exceeds the width of a door leaf (the moving panel of a door), so that no leaf swings through the body."""
_REACH_M = 3.0
"""Largest height of the body above a door's lower end at which the body counts as on the storey of the door [m]."""


@dataclass(frozen=True, eq=False)
class ClosingDoors(Actor):
    """Door leaves (the moving panels of doors) that are open only while the body is near them."""

    leaves: Sequence[DoorLeaf]

    def solids_at(self, stamp: float, T_W_B: Float64[np.ndarray, "4 4"]) -> Sequence[Solid]:
        """Return all door leaves as solids for a body at `T_W_B`. The nearer the body, the wider a door is open."""
        return [_solid(_turned(leaf, _openness(leaf, T_W_B[:3, 3]))) for leaf in self.leaves]


def _openness(leaf: DoorLeaf, body: Float64[np.ndarray, "3"]) -> float:
    """Return how far a door leaf is open for a body at a position in W: 0 is closed, 1 fully open."""
    centre = _centre(leaf, 0.0)
    if not 0.0 <= body[2] - leaf.position[2] <= _REACH_M:
        return 0.0
    distance = math.hypot(body[0] - centre[0], body[1] - centre[1])
    return min(max((_SHUT_BEYOND_M - distance) / (_SHUT_BEYOND_M - _OPEN_WITHIN_M), 0.0), 1.0)


def _turned(leaf: DoorLeaf, openness: float) -> DoorLeaf:
    turn = math.copysign(openness * max(abs(leaf.turn), math.pi / 2), leaf.turn)
    return replace(leaf, turn=turn, position=(*_centre(leaf, turn), leaf.position[2]))


def _centre(leaf: DoorLeaf, turn: float) -> tuple[float, float]:
    (x, y), half, yaw = leaf.hinge, leaf.size[0] / 2, leaf.shut_yaw + turn
    return x + half * math.cos(yaw), y + half * math.sin(yaw)


def _solid(leaf: DoorLeaf) -> Solid:
    return Solid(leaf.parts, leaf.position, leaf.yaw)


def all_leaves(house: House) -> Iterator[DoorLeaf]:
    """Yield a door leaf (the moving panel of a door) for each doorway of a house.

    A doorway that has no leaf in the house gets a leaf that swings into the first of the doorway's two rooms.
    """
    return _hung(house, _with_leaf)


def built_leaves(house: House) -> Iterator[DoorLeaf]:
    """Yield the door leaves of the house's spec, also those that `ClosingDoors` has taken out of `House.leaves`."""
    return _hung(house, lambda opening: opening)


def _hung(house: House, change: Callable[[OpeningSpec], OpeningSpec]) -> Iterator[DoorLeaf]:
    """Yield the leaves of the doors that all openings of a house have after `change`."""
    style = house.spec.seed if house.spec.appearance.seed is None else house.spec.appearance.seed
    for level, (storey, pieces) in enumerate(zip(house.spec.storeys, house.boundaries, strict=True)):
        hung = [change(opening) for opening in storey.openings]
        own = {id(old): new for old, new in zip(storey.openings, hung, strict=True)}
        cut = [(boundary, own.get(id(opening), opening)) for boundary, opening in pieces]
        yield from hang_leaves(level, cut, hung, house.storeys[level].floor_m, style)


def _with_leaf(opening: OpeningSpec) -> OpeningSpec:
    if opening.kind != "door" or opening.leaf is not None:
        return opening
    return opening.model_copy(update={"leaf": LeafSpec(into=opening.rooms[0])})
