"""Draws one drive of the robot on the floor plans: the planned path, the driven path, and the end of the drive."""

import numpy as np
from jaxtyping import Float64

from lexis.maths.stretches import stretches_of
from sim.render.image_files import encoded
from sim.report.drawing import Mark
from sim.report.house_plan import floor_plans
from sim.report.palette import label_colours
from sim.report.plan import plan_drawing
from sim.report.png import joined_pictures, to_image
from worlds.house import House
from worlds.truth import storey_of

_PIXELS_PER_METRE = 60
_SAME_STOREY_M = 0.3
"""Points on stairs are drawn on the plan of the upper storey if they are at most this far below its floor [m]."""


def drive_png(
    house: House, planned: Float64[np.ndarray, "j 3"], path: Float64[np.ndarray, "k 3"], touched: tuple[str, ...] = ()
) -> bytes:
    """Draw a drive on the plans of all storeys, as a PNG file.

    The path `planned` is dashed and the driven path `path` is solid; both are in W [m]. A circle marks the end of the drive.
    The name of the first object in `touched`, with which the robot collided, stands beside the circle.
    """
    plans = floor_plans(house)
    floors = [plan.floor_m for plan in plans]
    colours = label_colours(room.label for plan in plans for room in plan.rooms)
    lines = {"odometry": planned, "path": path}
    levels = {style: storey_of(line[:, 2] + _SAME_STOREY_M, floors) for style, line in lines.items()}
    pictures = []
    for plan in plans:
        marks = [
            Mark("line", style, line[stretch.slice, :2])
            for style, line in lines.items()
            for stretch in stretches_of(levels[style])
            if levels[style][stretch.start] == plan.level and stretch.stop - stretch.start > 1
        ]
        if levels["path"][-1] == plan.level:
            end = path[-1:, :2]
            marks += [
                Mark("dot", "wrong", end),
                Mark("text", "name", end + [0.3, 0.0], text=", ".join(touched[:1]), size=0.3),
            ]
        pictures.append(to_image(plan_drawing(plan, colours).with_marks(marks), pixels_per_metre=_PIXELS_PER_METRE))
    return encoded(joined_pictures(pictures), ".png")
