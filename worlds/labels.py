"""The labels that rooms can have; the order is that in which lists of labels are shown."""

STAIRS = "stairs"

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
