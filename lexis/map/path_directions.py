"""Directions in words for a planned path: the rooms that it passes through, its turns, and its stairs and lifts."""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import zip_longest
from typing import Any

import numpy as np
from jaxtyping import Float64, Int

from lexis.floors import NO_FLOOR
from lexis.maths.paths import arc_length
from lexis.maths.stretches import stretches_of
from lexis.planning.planner import Plan
from lexis.room_names import instance_names
from lexis.stairs import lift_rides
from lexis.types import LexisMap

TURN_RAD = np.radians(45.0)
"""Smallest change of heading that counts as a turn [rad]."""
AROUND_RAD = np.radians(135.0)
"""Smallest change of heading that counts as turning around [rad]."""
ALONG_M = 1.0
"""Length of path over which a heading is measured [m]. A turn at a point compares the heading before the point with the
heading after it."""
SAMPLE_M = 0.1
"""Spacing of the points on the path at which turns are sought [m]."""
MIN_CLIMB_M = 0.5
"""Smallest height difference over stairs or in a lift that counts as going up or down [m]."""


@dataclass(frozen=True)
class Step:
    """One of the directions for a path, and its position on the path."""

    at_m: float
    """Distance along the path from the start [m]."""
    text: str
    """The direction in words, for example "turn left" or "enter corridor 1 (floor 0)"."""


def directions(map: LexisMap, plan: Plan) -> tuple[Step, ...]:
    """Return the directions along the path, in order: start, rooms entered, turns, stairs and lifts, and arrival."""
    positions = map.T_W_B[list(plan.keyframes), :3, 3]
    path = arc_length(positions)
    steps = [*_rooms(map, plan, path), *_climbs(map, plan, path), *_turns(positions, path)]
    arrived = Step(float(path[-1]), f"arrive in {name_and_floor(map, plan.goal.id)}")
    return *sorted(steps, key=lambda step: step.at_m), arrived


def plan_summary(map: LexisMap, plan: Plan) -> dict[str, Any]:
    """A plan as plain data for JSON: rooms, length [m], directions, and keyframes with positions in W [m]."""
    names, room_of = (*instance_names(map.rooms), None), map.room_of
    keyframes = [
        {"id": i, "position_m": map.T_W_B[i, :3, 3].tolist(), "room": names[room_of[i]], "label": map.label_of(i)}
        for i in plan.keyframes
    ]
    return {
        "schema": 1,
        "from": names[plan.start.id],
        "to": names[plan.goal.id],
        "length_m": plan.length_m,
        "directions": [{"at_m": step.at_m, "text": step.text} for step in directions(map, plan)],
        "keyframes": keyframes,
    }


def name_and_floor(map: LexisMap, room: int) -> str:
    """Name and floor of the room with the id `room`: "office 2 (floor 1)", or "stairs (between floors)"."""
    floor = map.rooms[room].floor
    return f"{instance_names(map.rooms)[room]} ({'between floors' if floor is None else f'floor {floor}'})"


def _rooms(map: LexisMap, plan: Plan, path: Float64[np.ndarray, "n"]) -> list[Step]:
    """Return directions for the start, and for every room entered later.

    A keyframe that belongs to no room counts as part of the previous room.
    """
    rooms = map.room_of[list(plan.keyframes)]
    known = np.maximum.accumulate(np.where(rooms >= 0, np.arange(len(rooms)), 0))
    rooms = _from_start_to_goal(rooms[known], plan)
    begins = [run.start for run in stretches_of(rooms)[1:]]
    entered = [Step(float(path[i]), f"enter {name_and_floor(map, int(rooms[i]))}") for i in begins]
    return [Step(0.0, f"start in {name_and_floor(map, plan.start.id)}"), *entered]


def _from_start_to_goal(rooms: Int[np.ndarray, "n"], plan: Plan) -> Int[np.ndarray, "n"]:
    """Return the rooms along a path, changed so that they begin with the start of the plan and end with its goal.

    This is necessary because the first and last keyframes of a plan may belong to neighbouring rooms; see `path_end`.
    """
    rooms = rooms.copy()
    runs = stretches_of(rooms)
    if len(runs) == 1:  # the start, the goal or both have no keyframe on the path
        entered = 1 if rooms[0] == plan.goal.id else max(len(rooms) - 1, 1)
        return np.where(np.arange(len(rooms)) < entered, plan.start.id, plan.goal.id)
    starts = np.flatnonzero(rooms == plan.start.id)
    rooms[: starts[0] if len(starts) else runs[0].stop] = plan.start.id
    goals = np.flatnonzero(rooms == plan.goal.id)
    rooms[goals[-1] + 1 if len(goals) else runs[-1].start :] = plan.goal.id
    return rooms


def _climbs(map: LexisMap, plan: Plan, path: Float64[np.ndarray, "n"]) -> list[Step]:
    """Return a direction for every change of floor that goes up or down by at least `MIN_CLIMB_M`.

    If the path continues on a floor after stairs or a ride in a lift, the direction names the floor.
    """
    floors, positions = map.floors[list(plan.keyframes)], map.T_W_B[list(plan.keyframes), :3, 3]
    steps = []
    for at, before, after in _changes_of_floor(floors):
        climb = positions[after, 2] - positions[before, 2]
        if abs(climb) >= MIN_CLIMB_M:
            way = "lift" if lift_rides(positions[before : after + 1]) else "stairs"
            leads = "" if floors[after] == NO_FLOOR else f" to floor {floors[after]}"
            steps.append(Step(float(path[at]), f"take the {way} {'up' if climb > 0 else 'down'}{leads}"))
    return steps


def _changes_of_floor(floors: Int[np.ndarray, "n"]) -> Iterator[tuple[int, int, int]]:
    """Yield where each change of floor begins, and the keyframes before and after it, as indices into the path.

    A change is a stretch of keyframes between floors, or a step from one floor to another, as in a lift without images.
    """
    runs = stretches_of(floors)
    for run, following in zip_longest(runs, runs[1:]):
        if floors[run.start] == NO_FLOOR:
            yield run.start, max(run.start - 1, 0), min(run.stop, len(floors) - 1)
        elif following is not None and floors[following.start] != NO_FLOOR:
            yield run.stop - 1, run.stop - 1, following.start


def _turns(positions: Float64[np.ndarray, "n 3"], path: Float64[np.ndarray, "n"]) -> list[Step]:
    """Return a direction for every turn.

    A turn changes the heading at all samples around it, but must be announced once. Therefore, the sharpest turn is
    announced first, then the sharpest turn that does not overlap it, and so on.
    """
    at = np.arange(ALONG_M / 2, path[-1] - ALONG_M / 2, SAMPLE_M)
    change = _heading_changes(positions, path, at)
    steps = []
    while len(at) and np.abs(change).max() > TURN_RAD:
        i = int(np.abs(change).argmax())
        side = "around" if abs(change[i]) > AROUND_RAD else "left" if change[i] > 0 else "right"
        steps.append(Step(float(at[i]), f"turn {side}"))
        change[np.abs(at - at[i]) <= ALONG_M] = 0.0
    return steps


def _heading_changes(
    positions: Float64[np.ndarray, "n 3"], path: Float64[np.ndarray, "n"], at: Float64[np.ndarray, "k"]
) -> Float64[np.ndarray, "k"]:
    """Return the change of heading at the distances `at` along the path, positive to the left [rad].

    This is the angle from the heading before the point to the heading after it, each over `ALONG_M`.
    """
    before, here, after = (
        np.stack([np.interp(at + offset, path, positions[:, axis]) for axis in (0, 1)], axis=1)
        for offset in (-ALONG_M, 0.0, ALONG_M)
    )
    (x, y), (u, v) = (here - before).T, (after - here).T
    return np.asarray(np.arctan2(x * v - y * u, x * u + y * v))
