"""Converts drawings to SVG elements and files."""

from collections.abc import Sequence
from html import escape

import numpy as np
from jaxtyping import Float

from sim.report.drawing import STYLES, Drawing, Mark, Style


def to_svg(drawing: Drawing) -> str:
    """Return a drawing as an `<svg>` element. The page around the element has to include the rules of `styles_css`."""
    width, height = drawing.high - drawing.low
    body = "\n".join(map(_element, drawing.layers))
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" role="img" aria-label="{escape(drawing.title)}" '
        f'viewBox="{drawing.low[0]:.2f} {-drawing.high[1]:.2f} {width:.2f} {height:.2f}">\n{body}\n</svg>'
    )


def side_by_side(drawings: Sequence[Drawing]) -> str:
    """Return drawings as the text of one SVG file: at one scale, from left to right, aligned at the bottom."""
    sizes = [drawing.high - drawing.low for drawing in drawings]
    total, height, x, elements = sum(size[0] for size in sizes), max(size[1] for size in sizes), 0.0, []
    for drawing, (w, h) in zip(drawings, sizes, strict=True):
        place = f'<svg x="{x:.2f}" y="{height - h:.2f}" width="{w:.2f}" height="{h:.2f}" '
        elements.append(to_svg(drawing).replace("<svg ", place, 1))
        x += w
    css = "text{font-family:sans-serif}" + styles_css("svg")
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {total:.2f} {height:.2f}">\n'
        f'<style>{css}</style>\n<rect width="100%" height="100%" fill="#ffffff"/>\n' + "\n".join(elements) + "\n</svg>\n"
    )


def styles_css(scope: str) -> str:
    """Return the CSS rules of all styles, for elements inside the selector `scope`. SVG user units are metres."""
    return "".join(f"{scope} .{name}{{{_declarations(style)}}}" for name, style in STYLES.items())


def _declarations(style: Style) -> str:
    rules = [f"fill:{style.fill or 'none'}"]
    if style.fill_opacity != 1:
        rules.append(f"fill-opacity:{style.fill_opacity}")
    if style.stroke:
        rules.append(f"stroke:{style.stroke};stroke-width:{style.width / 100:g};stroke-linejoin:round;stroke-linecap:round")
    if style.dash:
        rules.append(f"stroke-dasharray:{style.dash[0] / 100:g} {style.dash[1] / 100:g};stroke-linecap:butt")
    if style.opacity != 1:
        rules.append(f"opacity:{style.opacity}")
    return ";".join(rules)


def _element(mark: Mark) -> str:
    attributes = f'class="{mark.style}"'
    if mark.colour:
        room = f";--room:{mark.room_colour}" if mark.room_colour else ""
        attributes += f' style="{"stroke" if mark.kind == "line" else "fill"}:{mark.colour}{room}"'
    if mark.keyframe is not None:
        attributes += f' data-k="{mark.keyframe}"'
    x, y = mark.points[0] * [1, -1]
    if mark.kind == "text":
        place = f'x="{x:.3f}" y="{y + 0.35 * mark.size:.3f}" font-size="{mark.size:.3f}"'
        return f"<text {place} {attributes}>{escape(mark.text)}</text>"
    if mark.kind == "dot":
        shape = f'circle cx="{x:.3f}" cy="{y:.3f}" r="{STYLES[mark.style].radius}"'
    else:
        shape = f'path d="M{_coordinates(mark.points)}{"Z" if mark.kind == "polygon" else ""}"'
    title = f"><title>{escape(mark.text)}</title></{shape.split()[0]}>" if mark.text else "/>"
    return f"<{shape} {attributes}{title}"


def _coordinates(points: Float[np.ndarray, "k 2"]) -> str:
    return "L".join(f"{x:.3f} {-y:.3f}" for x, y in points)
