"""`Part`: the primitive that furniture, stairs and fences are built from."""

from dataclasses import dataclass
from typing import Literal

Vector = tuple[float, float, float]
Colour = tuple[float, float, float]
Shape = Literal["box", "cylinder", "cone", "ball"]


@dataclass(frozen=True)
class Part:
    """A primitive in the frame of the object it belongs to.

    That frame has its origin at the centre of the foot print on the underside: x along the width, y to the front, z up.
    """

    shape: Shape
    centre: Vector
    """[m]"""
    size: Vector
    """Full extents along x, y, z [m]; cylinders and cones stand along z."""
    colour: Colour
    """RGB in [0, 1]; tints the material."""
    material: str = "plain"
    """A pattern of `worlds.visuals.materials.PATTERNS`."""
    yaw: float = 0.0
    """About z through the centre [rad]."""
