"""Draws the symbols of openings, doors and windows in a floor plan, as architects draw them."""

from collections.abc import Iterator

import numpy as np
from jaxtyping import Float64

from sim.report.data import PlannedLeaf, PlannedOpening
from sim.report.drawing import Mark
from worlds.arches import arch_drop, arch_rise
from worlds.spec import OpeningKind
from worlds.walls import HALF_WALL_M

NAMES: dict[OpeningKind, str] = {
    "door": "doorway",
    "cased": "cased opening",
    "arch": "arch",
    "half wall": "half wall",
    "counter": "counter",
    "open": "open boundary, no wall",
}
"""Name of each kind of opening in the legend and in tooltips."""
WINDOW, WITH_LEAF = "window", "door with a leaf"
"""Further names in the legend."""
_HEAD_M = 0.18
"""Length of the head of an arrow [m]."""


def opening_marks(opening: PlannedOpening) -> Iterator[Mark]:
    """Yield the marks of an opening between two rooms."""
    ends, text = opening.ends, NAMES[opening.kind]
    match opening.kind:
        case "open":
            yield Mark("line", "open", ends, text=text)
        case "door":
            for side in (-HALF_WALL_M, HALF_WALL_M):
                yield Mark("line", "door", _beside(ends, side), text=text)
        case "half wall":
            yield Mark("polygon", "low-wall", _band(ends, HALF_WALL_M), text=text)
        case "counter":
            yield Mark("polygon", "low-wall", _band(ends, 2 * HALF_WALL_M), text=text)
            for side in (-HALF_WALL_M, HALF_WALL_M):
                yield Mark("line", "overhead", _beside(ends, side), text=text)
        case _:
            for side in (-HALF_WALL_M, HALF_WALL_M):
                yield Mark("line", "overhead", _beside(ends, side), text=text)
            if opening.kind == "arch":
                yield Mark("line", "overhead", _turned_down(ends), text=text)


def leaf_marks(leaf: PlannedLeaf) -> Iterator[Mark]:
    """Yield the marks of a door leaf (the moving panel) at its opening angle, and of the arc on which its free end moves."""
    yield Mark("line", "swing", leaf.arc)
    yield Mark("polygon", "leaf", leaf.outline, text="door leaf")


def climb_marks(path: Float64[np.ndarray, "k 2"]) -> Iterator[Mark]:
    """Yield an arrow along the path up a flight of stairs."""
    yield Mark("line", "climb", path, text="stairs, upwards")
    back = path[-2] - path[-1]
    back *= _HEAD_M / np.linalg.norm(back)
    across = np.array([-back[1], back[0]]) / 2
    yield Mark("line", "climb", path[-1] + np.stack([back + across, np.zeros(2), back - across]), text="stairs, upwards")


def sample_marks(name: str, ends: Float64[np.ndarray, "2 2"]) -> Iterator[Mark]:
    """Yield the symbol that has this name in the legend, from `ends[0]` to `ends[1]`, two points on a line along x."""
    if name == WINDOW:
        return window_marks(ends)
    if name == WITH_LEAF:
        return leaf_marks(_sample_leaf(ends))
    return opening_marks(PlannedOpening(next(kind for kind in NAMES if NAMES[kind] == name), ends))


def _sample_leaf(ends: Float64[np.ndarray, "2 2"]) -> PlannedLeaf:
    """Return a small open leaf in the middle of a symbol, and the quarter circle on which it moves."""
    length, hinge = 0.3, ends.mean(axis=0) - 0.15
    angle = np.linspace(0.0, np.pi / 2, 9)
    arc = hinge + length * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return PlannedLeaf(_band(np.array([hinge, arc[-1]]), HALF_WALL_M / 2), arc)


def window_marks(ends: Float64[np.ndarray, "2 2"]) -> Iterator[Mark]:
    """Yield the marks of a window: a rectangle as thick as the wall, and a line for the pane."""
    yield Mark("polygon", "window", _band(ends, HALF_WALL_M), text=WINDOW)
    yield Mark("line", "pane", ends, text=WINDOW)


def _across(ends: Float64[np.ndarray, "2 2"]) -> Float64[np.ndarray, "2"]:
    along = (ends[1] - ends[0]) / np.linalg.norm(ends[1] - ends[0])
    return np.array([-along[1], along[0]])


def _beside(ends: Float64[np.ndarray, "2 2"], offset: float) -> Float64[np.ndarray, "2 2"]:
    return np.asarray(ends + offset * _across(ends))


def _band(ends: Float64[np.ndarray, "2 2"], half: float) -> Float64[np.ndarray, "4 2"]:
    return np.concatenate([_beside(ends, -half), _beside(ends, half)[::-1]])


def _turned_down(ends: Float64[np.ndarray, "2 2"]) -> Float64[np.ndarray, "k 2"]:
    """Return the curve of an arch, folded from its vertical plane into the floor plan."""
    width = float(np.linalg.norm(ends[1] - ends[0]))
    shares = (1.0 - np.cos(np.linspace(0.0, np.pi, 17))) / 2
    height = [arch_rise(width) - arch_drop(width, (share - 0.5) * width) for share in shares]
    return np.asarray(
        ends[0] + np.outer(shares, ends[1] - ends[0]) + np.outer(HALF_WALL_M + np.array(height), _across(ends))
    )
