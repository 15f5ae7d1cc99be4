"""Assigns one colour to each room label, and to each estimated room, for all pictures of a report."""

from collections.abc import Iterable

from sim.report.data import NO_LABEL, KeyframeTable

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
    """Map the name of each estimated room to the colour of its keyframes, and "" to the colour of keyframes in no room.

    Empty if keyframes have the colours of their labels, because there are labels, or if no rooms are estimated.
    """
    if table.is_labelled or not table.has_rooms:
        return {}
    return instance_colours(sorted(set(table.predicted_rooms), key=lambda name: (name == "", len(name), name)), "")
