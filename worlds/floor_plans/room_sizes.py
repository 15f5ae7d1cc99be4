"""Sizes of rooms by label, and the rooms from which small rooms are preferably carved."""

from dataclasses import dataclass


@dataclass(frozen=True)
class RoomSize:
    """Size of the rooms with one label."""

    usual: tuple[float, float]
    """Range from which the area of a room is drawn [m²]."""
    side_m: float = 2.4
    """Least width of a room [m]."""
    beside: tuple[str, ...] = ()
    """Labels of the rooms from which a room of this label is preferably carved."""


_QUIET = ("bedroom", "children's room")
_WORK = ("office", "open-plan office", "meeting room")

SIZES: dict[str, RoomSize] = {
    "kitchen": RoomSize((10.0, 17.0), 2.6),
    "dining room": RoomSize((11.0, 17.0), 2.8),
    "living room": RoomSize((18.0, 30.0), 3.6),
    "bedroom": RoomSize((11.0, 19.0), 2.8),
    "children's room": RoomSize((9.5, 15.0), 2.6),
    "bathroom": RoomSize((5.0, 9.0), 1.9, _QUIET),
    "toilet": RoomSize((2.2, 3.6), 1.3, ("living room", "meeting room", "lobby", *_WORK, "classroom")),
    "office": RoomSize((10.0, 17.0), 2.6),
    "meeting room": RoomSize((14.0, 26.0), 3.2),
    "open-plan office": RoomSize((30.0, 55.0), 4.6),
    "laundry room": RoomSize((4.0, 7.0), 1.7, ("kitchen", "bedroom", "garage")),
    "storage room": RoomSize((3.0, 7.0), 1.5, ("garage", "classroom", "laboratory", "gym", "kitchen", "office")),
    "pantry": RoomSize((2.4, 4.2), 1.4, ("kitchen",)),
    "garage": RoomSize((18.0, 28.0), 3.2),
    "gym": RoomSize((22.0, 45.0), 4.0),
    "library": RoomSize((20.0, 42.0), 3.8),
    "classroom": RoomSize((36.0, 58.0), 5.2),
    "laboratory": RoomSize((26.0, 46.0), 4.4),
    "print room": RoomSize((5.0, 9.0), 1.9, _WORK),
    "lobby": RoomSize((20.0, 40.0), 3.8),
    "entrance hall": RoomSize((8.0, 16.0), 2.4),
    "corridor": RoomSize((8.0, 16.0), 2.0),
}
"""Sizes of the indoor rooms by label, except stairs, whose size `worlds.stairs` computes."""
