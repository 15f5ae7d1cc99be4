"""What captions call things: synonyms of rooms, and the frames around them.

A third of each room's names is held out: never trained on, kept to measure how far the text tower generalises.
"""

import numpy as np

from lexis.prompts import with_article

TEMPLATES = (
    "{}", "a photo of {a}", "a picture of {a}", "{a} in a house", "a view of {a}", "inside {a}", "an image of {a}",
    "this is {a}", "a wide photo of {a}", "a photo taken in {a}",
)  # fmt: skip

ROOM_NAMES: dict[str, tuple[str, ...]] = {
    "kitchen": ("kitchen", "cooking area", "room for cooking"),
    "dining room": ("dining room", "dining area", "room with a dining table"),
    "living room": ("living room", "sitting room", "family room"),
    "bedroom": ("bedroom", "room for sleeping", "master bedroom"),
    "children's room": ("children's room", "kids room", "room for children"),
    "bathroom": ("bathroom", "room with a bathtub", "washroom with a shower"),
    "toilet": ("toilet", "restroom", "water closet"),
    "corridor": ("corridor", "hallway", "passage"),
    "entrance hall": ("entrance hall", "entry hall", "foyer"),
    "stairs": ("stairs", "staircase", "steps"),
    "office": ("office", "study with a desk", "work room"),
    "meeting room": ("meeting room", "conference room", "room for meetings"),
    "open-plan office": ("open-plan office", "shared office", "large office with many desks"),
    "lobby": ("lobby", "reception", "reception area"),
    "laundry room": ("laundry room", "room with a washing machine", "room for laundry"),
    "storage room": ("storage room", "store room", "box room"),
    "pantry": ("pantry", "larder", "food store"),
    "garage": ("garage", "car garage", "room for a car"),
    "garden": ("garden", "yard", "backyard"),
    "balcony": ("balcony", "terrace", "roof terrace"),
    "gym": ("gym", "fitness room", "exercise room"),
    "library": ("library", "reading room", "room full of books"),
    "classroom": ("classroom", "school room", "lecture room"),
    "laboratory": ("laboratory", "science lab", "lab"),
    "print room": ("print room", "copy room", "printer room"),
}
"""Trained names of every room label; the first is the label itself."""

HELD_OUT_NAMES: dict[str, str] = {
    "kitchen": "kitchenette", "dining room": "breakfast room", "living room": "lounge", "bedroom": "sleeping chamber",
    "bathroom": "bath", "toilet": "lavatory", "corridor": "aisle", "stairs": "stairway", "office": "home office",
    "garden": "lawn with flowers", "laundry room": "utility room", "garage": "parking space",
}  # fmt: skip
"""Names that never occur in training."""


def caption(name: str, rng: np.random.Generator) -> str:
    """A caption with `name` in a random frame."""
    return TEMPLATES[int(rng.integers(len(TEMPLATES)))].format(name, a=with_article(name))


def room_caption(label: str, rng: np.random.Generator) -> str:
    """A caption with one of the label's trained names; the label itself half of the time."""
    names = ROOM_NAMES[label]
    return caption(names[0] if rng.random() < 0.5 else names[int(rng.integers(len(names)))], rng)
