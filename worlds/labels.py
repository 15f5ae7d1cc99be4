"""The labels that rooms can have. CONTRIBUTING.md lists what else a new label needs.

Lists of labels shown to users have the order of `ROOM_LABELS`.
"""

STAIRS = "stairs"
"""The label of stairs, which are one room through all the storeys that they join."""

ROOM_LABELS = (
    "kitchen",
    "dining room",
    "living room",
    "bedroom",
    "children's room",
    "bathroom",
    "toilet",
    "corridor",
    "entrance hall",
    STAIRS,
    "office",
    "meeting room",
    "open-plan office",
    "lobby",
    "laundry room",
    "storage room",
    "pantry",
    "garage",
    "garden",
    "balcony",
    "gym",
    "library",
    "classroom",
    "laboratory",
    "print room",
)

OUTDOOR_LABELS = ("garden", "balcony")
"""Labels of outdoor rooms, which have no ceiling, and fences instead of outer walls."""

LIVED_IN_LABELS = ("living room", "dining room", "bedroom", "children's room", "library")
"""Labels of rooms that people furnish for living, with pictures, plants and loose things."""

CIRCULATION_LABELS = ("corridor", "entrance hall", "lobby")
"""Labels of rooms that people walk along to reach other rooms."""
