"""`Part`: the primitive shape from which furniture, door leaves, windows and stairs are built."""

from dataclasses import dataclass
from typing import Literal

Vector = tuple[float, float, float]
Colour = tuple[float, float, float]
Shape = Literal["box", "cylinder", "cone", "ball"]


@dataclass(frozen=True)
class Part:
    """A primitive shape in the frame of the object to which it belongs.

    That frame has its origin at the centre of the object's underside; x runs along the width, y to the front, z up.
    """

    shape: Shape
    centre: Vector
    """Centre of the shape in the object's frame [m]."""
    size: Vector
    """Extents along x, y and z before the rotation by `yaw` [m]; the axis of cylinders and cones is z."""
    colour: Colour
    """RGB in [0, 1]; the pattern of the material is multiplied by this colour."""
    material: str = "plain"
    """Name of a pattern in `worlds.visuals.materials.PATTERNS`."""
    yaw: float = 0.0
    """Rotation about the vertical axis through the centre, counter-clockwise [rad]."""
