"""`rooms.json`: the ground truth of a recording, namely the rooms of the house and the room of every frame.

`lexis run --rooms rooms.json` reads only the list `labels`, as the names of rooms.
"""

import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

from sim.record.take import RecordedFrame
from worlds.house import House, Room

ROOMS = "rooms.json"
_DIGITS = 4


class FrameRooms:
    """Collects the true room, storey and faults of frames while they are being written."""

    def __init__(self, house: House) -> None:
        self._house = house
        self._stamps: list[int] = []
        self._rooms: list[str] = []
        self._storeys: list[int] = []
        self._faults: dict[int, list[str]] = {}

    def note(self, frames: Iterable[RecordedFrame]) -> Iterable[RecordedFrame]:
        """Yield the frames unchanged, and collect the ground truth of each frame."""
        for frame in frames:
            if frame.truth.faults:
                self._faults[len(self._stamps)] = list(frame.truth.faults)
            self._stamps.append(frame.stamp_ns)
            self._rooms.append(self._house.rooms[frame.truth.room].id)
            self._storeys.append(frame.truth.storey)
            yield frame

    def write(self, path: Path) -> None:
        """Write, as JSON, the rooms of the house and the ground truth collected from all frames."""
        labels = self._house.spec.room_labels
        data = {
            "schema": 1,
            "units": "m, ns; polygons are wall centre lines in W",
            "labels": labels,
            "rooms": [_room(room) for room in self._house.rooms],
            "frames": {
                "stamp_ns": self._stamps,
                "room": self._rooms,
                "storey": self._storeys,
                "faults": {str(frame): names for frame, names in self._faults.items()},
            },
        }
        path.write_text(json.dumps(data) + "\n", encoding="utf-8")


def write_labels(path: Path, house: House) -> None:
    """Write a `rooms.json` that lists only the labels that rooms may have, so that a SLAM learns nothing about the house."""
    path.write_text(json.dumps({"schema": 1, "labels": house.spec.room_labels}) + "\n", encoding="utf-8")


def _room(room: Room) -> dict[str, Any]:
    return {
        "id": room.id,
        "label": room.label,
        "storey": room.storey,
        "polygon_m": np.round(np.array(room.polygon.exterior.coords)[:-1], _DIGITS).tolist(),
        "floor_m": round(room.floor_m, _DIGITS),
        "ceiling_m": round(room.ceiling_m, _DIGITS),
        "outdoor": room.outdoor,
    }
