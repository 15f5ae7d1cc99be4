"""Makes the floor plans of a house, as data for reports and as pictures."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType

import numpy as np
from jaxtyping import Float64, UInt8
from shapely.affinity import rotate
from shapely.geometry import LineString, Point, Polygon, box

from sim.render.image_files import encoded
from sim.report.data import FloorPlan, PlannedLeaf, PlannedOpening, PlannedRoom
from sim.report.drawing import Drawing, Mark
from sim.report.legend import LegendEntry, with_legend
from sim.report.palette import label_colours
from sim.report.plan import plan_drawing, titled
from sim.report.png import joined_pictures, to_image
from sim.report.rulers import with_rulers
from sim.report.svg import side_by_side
from worlds.house import House
from worlds.parts import Part
from worlds.rectangles import grown
from worlds.spec import RoomSpec
from worlds.walls import HALF_WALL_M

_PIXELS_PER_METRE = 60
_PLAN_PX = (480, 640)
"""Usual width and height of the plan of one storey with a legend, without the legend [px]."""
_LEGIBLE, _LARGEST = 45, 100
"""Smallest and largest usual scale of these plans [px/m]. At the smallest one, names of rooms can still be read."""
_WIDEST_PX = 1000
"""Largest width of these plans [px]; the scale of very wide ones is therefore smaller."""
_LETTER_PX = 13
"""Height of the letters in the legend of these plans [px]."""
_OVERHEAD_M = 1.9
"""Height above the floor from which pieces are not drawn [m], such as lamps under the ceiling."""
_SHORT_M = 1e-6
"""Length of a step on the path up the stairs below which it has no direction [m]."""
_MOST_PIXELS = 12e6
"""Largest number of pixels of one storey's picture; larger plans are drawn at a smaller scale."""


def floor_plans(house: House) -> tuple[FloorPlan, ...]:
    """Return the floor plan of each storey, lowest first."""
    return tuple(_plan(house, level) for level in range(len(house.storeys)))


def plan_png(house: House) -> bytes:
    """Draw the plans of all storeys with rulers, side by side, the lowest on the left. Return the bytes of a PNG file."""
    return encoded(_joined(_drawings(house, has_rulers=True), _PIXELS_PER_METRE), ".png")


def plan_svg(house: House) -> str:
    """Draw the plans of all storeys with rulers, side by side, the lowest on the left. Return the text of an SVG file."""
    return side_by_side(_drawings(house, has_rulers=True))


def plan_image(
    house: House, pixels_per_metre: int = _PIXELS_PER_METRE, marks: Mapping[int, Sequence[Mark]] = MappingProxyType({})
) -> UInt8[np.ndarray, "h w 3"]:
    """Draw the plans of all storeys side by side, the lowest on the left. Large houses are drawn at a smaller scale.

    `marks` are further marks by the level of the storey on whose plan they are drawn.
    """
    return _joined([plan.with_marks(marks.get(level, ())) for level, plan in enumerate(_drawings(house))], pixels_per_metre)


def _joined(drawings: Sequence[Drawing], pixels_per_metre: int) -> UInt8[np.ndarray, "h w 3"]:
    scale = min(_scale(drawing, pixels_per_metre) for drawing in drawings)
    return joined_pictures([to_image(drawing, pixels_per_metre=scale) for drawing in drawings])


def marked_plan_image(
    house: House, level: int, marks: Sequence[Mark], legend: Sequence[LegendEntry] = (), names_labels: bool = True
) -> UInt8[np.ndarray, "h w 3"]:
    """Draw the plan of one storey with further marks, and with a legend of these marks below the plan.

    The picture is at least about 480 pixels wide, which is enough for the legend, and up to 1000 in wide houses. The letters
    of the legend have the same size in all pictures. `names_labels` says whether labels stand beside the ids of rooms.
    """
    drawing = _drawings(house, names_labels)[level].with_marks(marks)
    width_m, height_m = (float(side) for side in drawing.high - drawing.low)
    fitting = min(_PLAN_PX[0] / width_m, _PLAN_PX[1] / height_m, _LARGEST)
    scale = _scale(drawing, max(1, round(min(max(fitting, _LEGIBLE), _WIDEST_PX / width_m))))
    drawing = replace(drawing, high=np.array([drawing.low[0] + max(width_m, _PLAN_PX[0] / scale), drawing.high[1]]))
    return to_image(with_legend(drawing, legend, _LETTER_PX / scale), pixels_per_metre=scale)


def _scale(drawing: Drawing, pixels_per_metre: int) -> int:
    """Return `pixels_per_metre`, or less if the picture would otherwise have more than `_MOST_PIXELS`."""
    area = float(np.prod(drawing.high - drawing.low))
    return int(min(pixels_per_metre, np.sqrt(_MOST_PIXELS / area)))


def _drawings(house: House, names_labels: bool = True, has_rulers: bool = False) -> list[Drawing]:
    plans = floor_plans(house)
    colours = label_colours(room.label for plan in plans for room in plan.rooms)
    drawings = [plan_drawing(plan, colours, names_labels) for plan in plans]
    if has_rulers:
        drawings = [with_rulers(drawing, plan) for drawing, plan in zip(drawings, plans, strict=True)]
    return [titled(drawing) for drawing in drawings] if len(drawings) > 1 else drawings


def _plan(house: House, level: int) -> FloorPlan:
    storey, floor_m = house.spec.storeys[level], house.storeys[level].floor_m
    # A wall that starts above the floor is a lintel over an opening. A wall that ends below the ceiling is a fence, or the
    # low part of an opening such as a counter.
    standing = [wall for wall in house.walls if wall.storey == level and wall.bottom_m <= floor_m]
    high = [wall for wall in standing if wall.top_m >= house.storeys[level].ceiling_m]
    below = {boundary for boundary, opening in house.boundaries[level] if opening is not None}
    fences = [wall for wall in standing if wall not in high and wall.boundary not in below]
    return FloorPlan(
        level,
        floor_m,
        rooms=tuple(PlannedRoom(room.id, room.label, np.array(room.polygon_m)) for room in storey.rooms),
        walls=tuple(_outline(wall.footprint) for wall in high),
        fences=tuple(_outline(wall.footprint) for wall in fences),
        openings=tuple(PlannedOpening(o.kind, np.array([o.start_m, o.end_m]), o.leaf is not None) for o in storey.openings),
        furniture=tuple(
            _outline(piece.footprint)
            for piece in house.furniture
            if piece.storey == level and piece.position[2] < floor_m + _OVERHEAD_M
        ),
        treads=(
            *(_tread(part) for stairs in house.stairs if level - stairs.storey in (0, 1) for part in stairs.treads),
            *(triangle for room in storey.rooms if room.climb == "lift" for triangle in _cabin(room)),
        ),
        climbs=tuple(_climbs(house, level)),
        leaves=tuple(
            PlannedLeaf(_outline(leaf.footprint), np.array(leaf.arc(leaf.turn)))
            for leaf in house.leaves
            if leaf.storey == level
        ),
        windows=tuple(np.array([window.start, window.end]) for window in house.windows if window.storey == level),
        house=house.spec.name,
    )


def _climbs(house: House, level: int) -> Iterator[Float64[np.ndarray, "k 2"]]:
    """Yield the part inside the stairs' room of the path up each flight whose direction a plan shows."""
    cells = {stairs: house.room_by_id[stairs.room] for stairs in house.stairs if stairs.kind != "lift"}
    begin_here = {cell for stairs, cell in cells.items() if stairs.storey == level}
    for stairs, cell in cells.items():
        if stairs.storey == level or (stairs.storey == level - 1 and cell not in begin_here):
            yield _between_borders(stairs.walking_line[:, :2], cell.polygon)


def _between_borders(path: Float64[np.ndarray, "k 2"], room: Polygon) -> Float64[np.ndarray, "m 2"]:
    """Return a path whose ends lie in front of a room, cut off at the border of the room."""
    path = path.copy()
    for end, inner in ((0, 1), (-1, -2)):
        border = LineString(path[[end, inner]]).intersection(room.exterior)
        path[end] = border.coords[0] if isinstance(border, Point) else path[end]
    moves = np.linalg.norm(np.diff(path, axis=0), axis=1) > _SHORT_M
    return np.asarray(path[np.append(True, moves)])


def _outline(polygon: Polygon) -> Float64[np.ndarray, "corners 2"]:
    return np.array(polygon.exterior.coords[:-1])


def _cabin(room: RoomSpec) -> list[Float64[np.ndarray, "3 2"]]:
    """Return the usual symbol of a lift, a rectangle with both diagonals, as four triangles that fill the shaft."""
    x0, y0, x1, y1 = Polygon(room.polygon_m).bounds
    corners = _outline(box(*grown((x0, y0, x1, y1), -HALF_WALL_M)))
    return [np.array([a, b, corners.mean(axis=0)]) for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True)]


def _tread(part: Part) -> Float64[np.ndarray, "corners 2"]:
    (x, y, _), (w, d, _) = part.centre, part.size
    return _outline(rotate(box(x - w / 2, y - d / 2, x + w / 2, y + d / 2), part.yaw, use_radians=True))
