"""`Trial`: the result of one plan of a SLAM that a simulated robot has driven; see `sim.harness.planning`."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64


@dataclass(frozen=True, eq=False)
class Trial:
    """The result of one plan that a robot has driven."""

    start: str
    goal: str
    success: bool
    """Whether the robot ended in a room of the goal's label without touching anything."""
    shortest_m: float
    """Length of the shortest walkable path from the start into a room of the goal's label [m]; see `planning.shortest_into`.
    0 without a plan, or if there is no such path."""
    travelled_m: float
    """Length of the robot's path [m]."""
    touched: tuple[str, ...]
    """Names of the objects that the robot collided with."""
    room: str | None
    """Id of the room in which the robot ended; None if it ended in no room, or did not drive."""
    path: Float64[np.ndarray, "k 3"]
    """Path of the robot, in W [m]."""
    planned: Float64[np.ndarray, "j 3"]
    """True positions of the plan's frames on the walked surface, in W [m]; empty if no plan was found."""
    refusal: str = ""
    """Why the robot did not drive; "" if it did."""

    @property
    def collisions(self) -> int:
        """Number of collisions: 1 if the robot touched something, which ends the drive, else 0."""
        return int(bool(self.touched))
