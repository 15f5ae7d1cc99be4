"""A picture of a map as SVG: the plans of all floors side by side, with keyframes in the colours of their rooms."""

import colorsys
from html import escape

import numpy as np
from jaxtyping import Bool, Float64

from lexis.floors import NO_FLOOR, floor_numbers
from lexis.graph.trusted_loops import is_trusted
from lexis.graph.walked_steps import walked_steps
from lexis.room_names import instance_names
from lexis.types import LexisMap

MARGIN_M = 1.5
"""Width of the empty border around the keyframes in every plan [m]."""
TITLE_M = 1.0
"""Height of the title above every plan [m]."""
_GREY = "#8a8a8a"
_STYLE = """text{font-family:sans-serif;text-anchor:middle}.name{font-size:.5px;paint-order:stroke;stroke:#fff;\
stroke-width:.08px}.title{font-size:.6px;fill:#555}path{fill:none;stroke-linecap:round}.walk{stroke:#ccc;stroke-width:.06px}\
.loop{stroke:#d22;stroke-width:.04px}.doubted{stroke:#d22;stroke-width:.03px;stroke-dasharray:.12 .12;opacity:.6}"""


def map_svg(map: LexisMap) -> str:
    """Return the picture as the text of an SVG file: one plan per floor, at one scale, with x to the right and y up.

    Each plan has a scale bar of one metre. Keyframes on stairs are drawn on every floor as small dots. Red lines are loop
    edges: solid if the edge is trusted, dashed if not.
    """
    low = map.T_W_B[:, :2, 3].min(axis=0) - MARGIN_M
    size = map.T_W_B[:, :2, 3].max(axis=0) + MARGIN_M - low
    floors = floor_numbers(map.floors) or [NO_FLOOR]
    # SVG coordinates: the origin is the upper left corner of each plan, and y points down.
    points = (map.T_W_B[:, :2, 3] - low) * [1, -1] + [0, size[1] + TITLE_M]
    plans = [
        f'<g transform="translate({i * size[0]:.2f} 0)">\n{_plan(map, points, f, size)}\n</g>' for i, f in enumerate(floors)
    ]
    width, height = size[0] * len(floors), size[1] + TITLE_M
    return "\n".join([
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{40 * width:.0f}" height="{40 * height:.0f}" '
        f'viewBox="0 0 {width:.2f} {height:.2f}">',
        f'<style>{_STYLE}</style>\n<rect width="100%" height="100%" fill="#fff"/>',
        *plans,
        "</svg>",
    ])  # fmt: skip


def _plan(map: LexisMap, points: Float64[np.ndarray, "n 2"], floor: int, size: Float64[np.ndarray, "2"]) -> str:
    """Return the SVG elements of one floor."""
    here = np.asarray((map.floors == floor) | (map.floors == NO_FLOOR))
    title = "stairs alone" if floor == NO_FLOOR else f"floor {floor}"
    bar = f'<path d="M.5 {size[1] + TITLE_M - 0.4:.2f}h1" stroke="#555" stroke-width=".08"/>'
    label = f'<text x="1" y="{size[1] + TITLE_M - 0.6:.2f}" class="title" style="font-size:.4px">1 m</text>'
    heading = f'<text x="{size[0] / 2:.2f}" y=".8" class="title">{title}</text>'
    return "\n".join(
        [heading, bar, label, *_edges(map, points, here), *_dots(map, points, here, floor), *_names(map, points, here)]
    )


def _edges(map: LexisMap, points: Float64[np.ndarray, "n 2"], here: Bool[np.ndarray, "n"]) -> list[str]:
    loops = [(loop.query, loop.match) for loop in map.loops]
    kinds = ["loop" if trusted else "doubted" for trusted in is_trusted(map.loop_weights)]
    edges = [*((step, "walk") for step in walked_steps(map).tolist()), *zip(loops, kinds, strict=True)]
    return [
        f'<path class="{kind}" d="M{_xy(points[a])}L{_xy(points[b])}"/>' for (a, b), kind in edges if here[a] and here[b]
    ]


def _dots(map: LexisMap, points: Float64[np.ndarray, "n 2"], here: Bool[np.ndarray, "n"], floor: int) -> list[str]:
    colours, names, room_of = _colours(map), (*instance_names(map.rooms), "no room"), map.room_of
    dots = []
    for i in np.flatnonzero(here):
        (x, y), room = points[i], room_of[i]
        radius = 0.16 if map.floors[i] == floor else 0.08
        title = f"<title>keyframe {i}: {escape(names[room])}</title>"
        dots.append(f'<circle cx="{x:.2f}" cy="{y:.2f}" r="{radius}" fill="{colours[room]}">{title}</circle>')
    return dots


def _names(map: LexisMap, points: Float64[np.ndarray, "n 2"], here: Bool[np.ndarray, "n"]) -> list[str]:
    """Return room names as SVG text, each at the mean of the room's keyframes and in the room's colour."""
    texts = []
    for room, name, colour in zip(map.rooms, instance_names(map.rooms), _colours(map), strict=False):
        members = [i for i in room.keyframes if here[i]]
        if members:
            x, y = points[members].mean(axis=0)
            texts.append(f'<text class="name" x="{x:.2f}" y="{y:.2f}" fill="{colour}">{escape(name)}</text>')
    return texts


def _colours(map: LexisMap) -> list[str]:
    """Return a colour for every room, followed by grey for keyframes that belong to no room.

    Hues are spaced by the golden ratio, so that rooms with consecutive ids get clearly different colours.
    """
    hues = [(0.6 + 0.618034 * i) % 1.0 for i in range(len(map.rooms))]
    rgb = [colorsys.hls_to_rgb(hue, (0.35, 0.45)[i % 2], 0.75) for i, hue in enumerate(hues)]
    return [*("#" + "".join(f"{round(255 * value):02x}" for value in colour) for colour in rgb), _GREY]


def _xy(point: Float64[np.ndarray, "2"]) -> str:
    return f"{point[0]:.2f} {point[1]:.2f}"
