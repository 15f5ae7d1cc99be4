"""`Placed`: what stands or hangs somewhere in a house and is built from parts: furniture, door leaves, windows."""

import math
from abc import ABC, abstractmethod
from functools import cached_property

from shapely.geometry import Polygon

from worlds.parts import Part, Vector


class Placed(ABC):
    """An object with a place, a size and parts in its own frame (see `Part`)."""

    id: str
    """Unique in the house."""
    storey: int
    position: Vector
    """Centre of the underside in W [m]."""
    yaw: float
    """[rad]"""
    size: Vector
    """Width, depth, height [m]."""

    @cached_property
    @abstractmethod
    def parts(self) -> tuple[Part, ...]:
        """In the object's own frame. Made when first asked for: only pictures need them."""

    @cached_property
    def footprint(self) -> Polygon:
        """What it covers of the plan [m]."""
        (x, y, _), (w, d, _) = self.position, self.size
        cos, sin = math.cos(self.yaw), math.sin(self.yaw)
        signs = ((-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5))
        return Polygon([(x + cos * a * w - sin * b * d, y + sin * a * w + cos * b * d) for a, b in signs])
