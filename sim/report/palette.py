"""Assigns one colour to each room label, and to each estimated and true room, for all pictures of a report."""

from collections.abc import Iterable

import numpy as np

from lexis.evaluation.partitions import overlap
from sim.report.data import NO_LABEL, KeyframeTable
from sim.report.room_errors import numbered_rooms

_LABELS = {
    "kitchen": "#e8891c",
    "dining room": "#c9485b",
    "living room": "#3f9b4a",
    "bedroom": "#6a5acd",
    "children's room": "#e56db1",
    "bathroom": "#1f9fc4",
    "toilet": "#0e6f8f",
    "corridor": "#8c7b6b",
    "entrance hall": "#b8a13a",
    "stairs": "#34609b",
    "office": "#2f6fd0",
    "meeting room": "#9b4dca",
    "open-plan office": "#63a0f4",
    "garden": "#86b817",
    "lobby": "#00a39a",
    "laundry room": "#a65628",
    "storage room": "#d81b78",
    "pantry": "#7a9a01",
    "garage": "#4b3f9e",
    "balcony": "#ff6f4d",
    "gym": "#577590",
    "library": "#b07aa1",
    "classroom": "#2a7f3f",
    "laboratory": "#94672a",
    "print room": "#c14d9b",
    NO_LABEL: "#a3a8ad",
}
"""The colour of each label, which is the same in all pictures: a dot has the colour of the floors with its label."""

_INSTANCES = (
    "#0072b2", "#e69f00", "#009e73", "#cc79a7", "#8a4b08", "#56b4e9", "#5e3c99", "#7a9a01", "#b0005e", "#00868b", "#a98f7a",
    "#303f9f",
)  # fmt: skip
"""Colours of room instances, in an order in which neighbours differ clearly. None is as red as marks of errors."""

_UNMATCHED = "#59626c"
"""Colour of a true room that no estimated room matches: a dark grey, because keyframes in no room are light grey."""


def label_colours(labels: Iterable[str]) -> dict[str, str]:
    """Map each label to a colour `#rrggbb`. Labels that no house has take the colours of room instances, in their order."""
    labels = tuple(dict.fromkeys(labels))
    others = instance_colours((label for label in labels if label not in _LABELS), NO_LABEL)
    return {label: _LABELS.get(label) or others[label] for label in labels}


def instance_colours(names: Iterable[str], none: str) -> dict[str, str]:
    """Map the name of each room instance to a colour `#rrggbb`, and the name `none`, for no room, to grey if it occurs.

    Colours repeat where there are many instances.
    """
    names = tuple(dict.fromkeys(names))
    numbers = {name: i for i, name in enumerate(name for name in names if name != none)}
    return {name: _INSTANCES[numbers[name] % len(_INSTANCES)] if name in numbers else _LABELS[NO_LABEL] for name in names}


def estimated_room_colours(table: KeyframeTable) -> dict[str, str]:
    """Map the name of each estimated room to its colour, and "", for keyframes in no room, to grey.

    The map is empty if no rooms are estimated.
    """
    return instance_colours(sorted(set(table.predicted_rooms), key=_number_first), "") if table.has_rooms else {}


def true_room_colours(table: KeyframeTable) -> dict[str, str]:
    """Map the name of each true room to the colour of the estimated room that matches it, or to dark grey if none does.

    Two rooms match if each shares more keyframes with the other than with any other room. Thus only one of the true rooms
    that are merged has a match. The map is empty if no rooms are estimated.
    """
    colours = estimated_room_colours(table)
    if not colours:
        return {}
    true_names, true_ids = numbered_rooms(table.true_rooms)
    names, ids = numbered_rooms(table.predicted_rooms)
    shared = overlap(true_ids, ids) * np.array([name != "" for name in names])
    best = shared.argmax(axis=1)
    rows = np.arange(len(best))
    matched = (shared[:, best].argmax(axis=0) == rows) & (shared[rows, best] > 0)
    return {true_names[i]: colours[names[best[i]]] if matched[i] else _UNMATCHED for i in rows}


def _number_first(name: str) -> tuple[bool, int, str]:
    """Return the sort key of an estimated room such as "room 4 (kitchen)": by its number; "" comes last."""
    return name == "", len(name.partition(" (")[0]), name
