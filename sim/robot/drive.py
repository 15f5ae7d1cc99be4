"""`Robot.drive`: a body goes through the waypoints of a plan by what it believes of its pose, and MuJoCo judges."""

import math
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from sim.errors import SimError
from sim.robot.body import Body
from sim.robot.controller import SPEED_M_S, STEP_S, Controller
from sim.robot.dead_reckoning import DeadReckoning
from sim.robot.scan import RangeScanner
from worlds.house import House
from worlds.truth import NOWHERE, room_at

_SCAN_EVERY_M = 0.1
_SCAN_EVERY_S = 0.5
_LEAST_TIME_S = 60.0
_TIME_FACTOR = 4.0
"""A drive may take this many times as long as its line at full speed, and the least time more."""
_KNEE_M = 0.3
"""Above the foot: where one is asked for the room, so that a floor's thickness does not matter."""
DROP = "drop"
"""Name of what it touches where there is no ground."""


@dataclass(frozen=True, eq=False)
class Drive:
    """How a drive went."""

    path: Float64[np.ndarray, "n 3"]
    """Of the foot's centre in W, where it truly was after every step [m]."""
    room: str | None
    """Id of the room that the robot ended in."""
    length_m: float
    """Driven, in the plan and up or down."""
    touched: tuple[str, ...]
    """Names of what it touched, or `DROP`; the first contact ends the drive."""

    @property
    def collisions(self) -> int:
        """Whether it touched anything."""
        return int(bool(self.touched))


class Robot:
    """A body with a scanner in a house; drives any number of plans.

    With `blind`, it follows its waypoints by its pose alone.
    """

    def __init__(self, house: House, blind: bool = False) -> None:
        self._house, self._blind = house, blind
        self._body = Body(house)
        self._scanner = RangeScanner(self._body)

    def drive(self, start: Float64[np.ndarray, "3"], yaw: float, pose: DeadReckoning,
              waypoints: Float64[np.ndarray, "k 3"]) -> Drive:  # fmt: skip
        """Drive from where the robot truly is, `start` on the walked surface and `yaw` in W, through the waypoints.

        These, and the `pose` that it believes in and that this call moves on, are in a frame of its own. Raises `SimError`
        where there is no waypoint, one is not finite, or `start` has no ground.
        """
        if len(waypoints) == 0 or not np.isfinite(waypoints).all():
            raise SimError(f"drive: waypoints must be at least one and finite; got {waypoints.tolist()}")
        controller = Controller(waypoints)
        touched = self._body.stand(start)
        path, unseen = [self._body.position], math.inf
        for _ in range(_most_steps(waypoints)):
            if touched:
                break
            if not self._blind and unseen >= _SCAN_EVERY_M:
                controller.see(self._scanner.scan(yaw), pose, float(path[-1][2] - path[0][2]))
                unseen = 0.0
            step = controller.step(pose)
            if step is None:
                break
            forward, turn = step
            touched = self._move(yaw + turn / 2, forward)
            yaw += turn
            pose.advance(forward, turn)
            path.append(self._body.position)
            unseen += max(forward, _SCAN_EVERY_M * STEP_S / _SCAN_EVERY_S)
        return self._judged(np.array(path), touched)

    def _move(self, heading: float, forward: float) -> tuple[str, ...]:
        x, y, z = self._body.position
        x, y = x + forward * math.cos(heading), y + forward * math.sin(heading)
        height = self._body.ground(x, y, z)
        return (DROP,) if height is None else self._body.place(x, y, height)

    def _judged(self, path: Float64[np.ndarray, "n 3"], touched: tuple[str, ...]) -> Drive:
        room = int(room_at(self._house, path[-1:] + [0.0, 0.0, _KNEE_M])[0])
        length = float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum())
        return Drive(path, None if room == NOWHERE else self._house.rooms[room].id, length, touched)


def _most_steps(waypoints: Float64[np.ndarray, "k 3"]) -> int:
    length = float(np.linalg.norm(np.diff(waypoints, axis=0), axis=1).sum())
    return math.ceil((_LEAST_TIME_S + _TIME_FACTOR * length / SPEED_M_S) / STEP_S)
