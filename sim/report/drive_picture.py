"""Draws one drive of the robot on the floor plans: the planned path, the driven path, and the end of the drive."""

import numpy as np
from jaxtyping import Float64, Int

from lexis.maths.stretches import stretches_of
from sim.render.image_files import encoded
from sim.report.drawing import Mark
from sim.report.house_plan import plan_image
from worlds.house import House
from worlds.truth import storey_of

_SAME_STOREY_M = 0.3
"""Points on stairs are drawn on the plan of the upper storey if they are at most this far below its floor [m]."""


def drive_png(
    house: House, planned: Float64[np.ndarray, "j 3"], path: Float64[np.ndarray, "k 3"], touched: tuple[str, ...] = ()
) -> bytes:
    """Draw a drive on the plans of all storeys, as a PNG file.

    The path `planned` is dashed and the driven path `path` is solid; both are in W [m]. A circle marks the end of the drive.
    The name of the first object in `touched`, with which the robot collided, stands beside the circle.
    """
    marks: dict[int, list[Mark]] = {level: [] for level in range(len(house.storeys))}
    for style, line in (("odometry", planned), ("path", path)):
        levels = _levels_of(line, house)
        for stretch in stretches_of(levels):
            if stretch.stop - stretch.start > 1:
                marks[int(levels[stretch.start])].append(Mark("line", style, line[stretch.slice, :2]))
    end, last_level = path[-1:, :2], int(_levels_of(path, house)[-1])
    marks[last_level] += [
        Mark("dot", "wrong", end),
        Mark("text", "name", end + [0.3, 0.0], text=", ".join(touched[:1]), size=0.3),
    ]
    return encoded(plan_image(house, marks=marks), ".png")


def _levels_of(line: Float64[np.ndarray, "k 3"], house: House) -> Int[np.ndarray, "k"]:
    """Return the storey on whose plan each point of a line is drawn."""
    return np.asarray(storey_of(line[:, 2] + _SAME_STOREY_M, [storey.floor_m for storey in house.storeys]))
