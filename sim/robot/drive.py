"""`Robot.drive`: drives a robot through a plan's waypoints by its estimated pose, while MuJoCo checks for collisions."""

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from jaxtyping import Float64

from sim.errors import SimError
from sim.robot.body import Body
from sim.robot.controller import SPEED_M_S, STEP_S, Controller
from sim.robot.dead_reckoning import DeadReckoning
from sim.robot.route import legs
from sim.robot.scan import RangeScanner
from worlds.house import House
from worlds.truth import NOWHERE, room_at
from worlds.walkable import polyline_length

_LEAST_TIME_S = 60.0
_TIME_FACTOR = 4.0
"""The time limit of a drive is `_TIME_FACTOR` times the time of the route at full speed, plus `_LEAST_TIME_S` [s]."""
_LONGEST_M = 10_000.0
"""Longest route that is driven [m]. A SLAM whose estimate has diverged may plan a route that would take hours or days."""
_KNEE_M = 0.3
"""Height above the robot's foot of the point whose room is looked up [m], so that a floor's thickness does not matter."""
DROP = "drop"
"""Entry of `Drive.touched` if the robot came to a place without ground, such as the edge of stairs."""


@dataclass(frozen=True, eq=False)
class Drive:
    """Result of a drive: the path, where it ended, and what the robot touched."""

    path: Float64[np.ndarray, "n 3"]
    """True positions of the robot on the ground in W [m]: at the start, and after each step."""
    room: str | None
    """Id of the room in which the robot ended; None if it ended in no room."""
    length_m: float
    """Length of the path driven, in 3-D [m]."""
    touched: tuple[str, ...]
    """Names of the geoms that the robot touched, or `DROP`; empty if none. The first contact ends the drive."""


class Robot:
    """A robot with a range scanner in a house, which can drive any number of plans.

    If `blind`, the robot ignores the scanner, and uses only its estimated pose to follow the waypoints.
    """

    def __init__(self, house: House, blind: bool = False) -> None:
        self._house, self._blind = house, blind
        self._body = Body(house)
        self._scanner = RangeScanner(self._body)
        lifts = [house.room_by_id[flight.room] for flight in house.stairs if flight.kind == "lift"]
        self._lifts = frozenset(house.rooms.index(room) for room in lifts)

    def drive(self, start: Float64[np.ndarray, "3"], yaw: float, pose: DeadReckoning,
              waypoints: Float64[np.ndarray, "k 3"]) -> Drive:  # fmt: skip
        """Drive through the waypoints, from the true position `start` on the ground [m] and the true `yaw` [rad] in W.

        Where the waypoints rise or fall vertically, the robot rides the lift in which it stands. If it stands in no lift
        that goes there, the drive ends.

        The waypoints and the estimated `pose` are in the robot's own frame, which drifts. The drive updates `pose`. Raises
        `SimError` if there is no waypoint, if a waypoint is not finite, if the route through the waypoints is longer than
        10 km, or if there is no ground at `start`.
        """
        if len(waypoints) == 0 or not np.isfinite(waypoints).all():
            raise SimError(f"drive: waypoints are {waypoints.tolist()}; valid: at least one, all finite")
        if (length_m := polyline_length(waypoints)) > _LONGEST_M:
            raise SimError(f"drive: the route is {length_m:.6g} m long; valid: up to {_LONGEST_M:g} m")
        touched, path = self._body.stand(start), [self._body.position]
        parts = legs(waypoints)
        if not touched:
            touched, yaw = self._follow(parts[0], yaw, pose, path)
        for before, part in pairwise(parts):
            arrived = None if touched else self._ride(float(part[0, 2] - before[-1, 2]))
            if arrived is None:
                break
            touched = arrived
            path.append(self._body.position)
            if not touched:
                touched, yaw = self._follow(part, yaw, pose, path)
        return self._judged(np.array(path), touched)

    def _follow(self, waypoints: Float64[np.ndarray, "k 3"], yaw: float, pose: DeadReckoning,
                path: list[Float64[np.ndarray, "3"]]) -> tuple[tuple[str, ...], float]:  # fmt: skip
        """Drive through waypoints without a ride in a lift, and add the robot's positions to `path`.

        Return the names of what the robot touched, and its yaw in the end [rad].
        """
        controller = Controller(waypoints)
        first = path[-1][2]
        for _ in range(_most_steps(waypoints)):
            if not self._blind:
                controller.see(self._scanner.scan(yaw), pose, float(path[-1][2] - first))
            step = controller.step(pose)
            if step is None:
                break
            forward, turn = step
            touched = self._move(yaw + turn / 2, forward)
            yaw += turn
            pose.advance(forward, turn)
            path.append(self._body.position)
            if touched:
                return touched, yaw
        return (), yaw

    def _ride(self, climb_m: float) -> tuple[str, ...] | None:
        """Ride a lift to the storey nearest to a climb [m], and return the names of what the robot touches there.

        The result is None if the robot stands in no lift that goes there.
        """
        x, y, z = self._body.position
        room = int(room_at(self._house, np.array([[x, y, z + _KNEE_M]]))[0])
        floor = min((storey.floor_m for storey in self._house.storeys), key=lambda height: abs(height - z - climb_m))
        if room not in self._lifts or not self._house.rooms[room].floor_m <= floor < self._house.rooms[room].ceiling_m:
            return None
        return self._body.place(x, y, floor)

    def _move(self, heading: float, forward: float) -> tuple[str, ...]:
        x, y, z = self._body.position
        x, y = x + forward * math.cos(heading), y + forward * math.sin(heading)
        height = self._body.ground(x, y, z)
        return (DROP,) if height is None else self._body.place(x, y, height)

    def _judged(self, path: Float64[np.ndarray, "n 3"], touched: tuple[str, ...]) -> Drive:
        room = int(room_at(self._house, path[-1:] + [0.0, 0.0, _KNEE_M])[0])
        return Drive(path, None if room == NOWHERE else self._house.rooms[room].id, polyline_length(path), touched)


def _most_steps(waypoints: Float64[np.ndarray, "k 3"]) -> int:
    return math.ceil((_LEAST_TIME_S + _TIME_FACTOR * polyline_length(waypoints) / SPEED_M_S) / STEP_S)
