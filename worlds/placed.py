"""`Placed`: base class of the objects in a house: furniture, door leaves and windows."""

import math
from abc import ABC, abstractmethod
from functools import cached_property

from shapely.geometry import Polygon

from worlds.parts import Part, Vector


class Placed(ABC):
    """An object in a house, with a pose, a size, and parts in its own frame (see `Part`)."""

    id: str
    """Name of the object, unique in the house."""
    storey: int
    """Index of the storey that the object is on."""
    position: Vector
    """Centre of the object's underside in W [m]."""
    yaw: float
    """Rotation about z, counter-clockwise [rad]."""
    size: Vector
    """Width, depth and height of the object along its own axes [m]."""

    @cached_property
    @abstractmethod
    def parts(self) -> tuple[Part, ...]:
        """The parts in the object's own frame. They are built at the first access, because only rendering needs them."""

    @cached_property
    def footprint(self) -> Polygon:
        """The rectangle that the object covers in the plan, in W [m]."""
        (x, y, _), (w, d, _) = self.position, self.size
        cos, sin = math.cos(self.yaw), math.sin(self.yaw)
        signs = ((-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5))
        return Polygon([(x + cos * a * w - sin * b * d, y + sin * a * w + cos * b * d) for a, b in signs])
