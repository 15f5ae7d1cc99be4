"""A summary of a map, as plain data and as text."""

from collections import Counter
from collections.abc import Sequence
from typing import Any

import numpy as np

from lexis.floors import floor_numbers
from lexis.graph.components import sessions_apart
from lexis.graph.trusted_loops import TRUSTED_WEIGHT, is_trusted
from lexis.graph.walked_steps import carried_before
from lexis.room_names import instance_names, unused_names
from lexis.types import LexisMap


def map_info(map: LexisMap) -> dict[str, Any]:
    """Return a summary of a map as plain data for JSON.

    It has rooms, floors, counts of keyframes and loops, path length [m] and duration [s]. The path is without the steps in
    which the robot was carried elsewhere.
    """
    steps = np.linalg.norm(np.diff(map.T_W_B[:, :3, 3], axis=0), axis=1)
    same = np.diff([keyframe.session for keyframe in map.keyframes]) == 0
    carried = carried_before(map)
    size = map.camera.intrinsics
    rooms = [
        {
            "name": name,
            "label": room.label,
            "probability": map.probability_of(room),
            "floor": room.floor,
            "keyframes": len(room.keyframes),
        }
        for room, name in zip(map.rooms, instance_names(map.rooms), strict=True)
    ]
    return {
        "schema": 1,
        "keyframes": len(map.keyframes),
        "sessions": map.keyframes[-1].session + 1,
        "sessions_apart": sessions_apart(map),
        "carried_before": carried.tolist(),
        "path_m": float(np.delete(steps, carried - 1)[np.delete(same, carried - 1)].sum()),
        "duration_s": float(np.diff([keyframe.stamp for keyframe in map.keyframes])[same].sum()),
        "floors": floor_numbers(map.floors),
        "rooms": rooms,
        "loops": len(map.loops),
        "trusted_loops": int(is_trusted(map.loop_weights).sum()),
        "candidates": dict(Counter(decision.outcome for decision in map.decisions).most_common()),
        "room_names": list(map.room_names),
        "unused_room_names": list(unused_names(map.room_names, map.rooms)),
        "encoder": {"name": map.encoder.name, "fingerprint": map.encoder.fingerprint},
        "image_px": [size.width, size.height],
    }


def info_text(info: dict[str, Any]) -> str:
    """Return the data of `map_info` as lines of text."""
    width = max([4, *(len(room["name"]) for room in info["rooms"])])
    floors = ["stairs" if room["floor"] is None else room["floor"] for room in info["rooms"]]
    rooms = [
        f"{room['name']:{width}s}  {floor:>6}  {room['keyframes']:9d}  {room['probability']:8.0%}"
        for room, floor in zip(info["rooms"], floors, strict=True)
    ]
    return "\n".join([
        f"keyframes   {info['keyframes']}",
        *([f"sessions    {info['sessions']}{_apart(info['sessions_apart'])}"] if info["sessions"] > 1 else []),
        *([f"carried     {carried_text(info['carried_before'])}"] if info["carried_before"] else []),
        f"path        {info['path_m']:.1f} m between keyframes",
        f"duration    {info['duration_s']:.1f} s",
        f"floors      {len(info['floors'])}",
        f"loop edges  {info['loops']}, of which {info['trusted_loops']} trusted (weight at least {TRUSTED_WEIGHT:g})",
        f"candidates  {', '.join(f'{count} {outcome}' for outcome, count in info['candidates'].items()) or 'none'}",
        f"encoder     {info['encoder']['name']} ({info['encoder']['fingerprint'][:12]})",
        f"images      {info['image_px'][0]}x{info['image_px'][1]} px",
        f"room names  {', '.join(info['room_names'])}",
        *([f"unused      {', '.join(info['unused_room_names'])}"] if info["unused_room_names"] else []),
        "",
        f"{'room':{width}s}  {'floor':>6s}  keyframes  probable",
        *rooms,
    ])  # fmt: skip


def carried_text(keyframes: Sequence[int]) -> str:
    """Return a note about the keyframes before which the robot was carried."""
    return f"elsewhere before keyframe{'s' if len(keyframes) > 1 else ''} {', '.join(map(str, keyframes))}"


def _apart(sessions: Sequence[int]) -> str:
    """Return a note about the sessions that are not connected with the first session."""
    return f", not connected with session 0: {', '.join(map(str, sessions))}" if sessions else ""
