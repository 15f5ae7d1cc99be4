"""Converts drawings to raster images, for viewers that cannot show SVG."""

from collections.abc import Iterator, Sequence

import numpy as np
from jaxtyping import Float, UInt8
from PIL import Image, ImageColor, ImageDraw, ImageFont

from lexis.maths.paths import arc_length
from sim.report.drawing import STYLES, Drawing, Mark

_OVERSAMPLING = 3
_OUTLINE = 0.1
"""Width of the white outline around letters, relative to their height."""


def to_image(drawing: Drawing, *, pixels_per_metre: int = 60) -> UInt8[np.ndarray, "h w 3"]:
    """Paint a drawing on a white background, at three times the size. It is then scaled down, which smooths edges."""
    painter = _Painter(drawing, pixels_per_metre * _OVERSAMPLING)
    for mark in drawing.layers:
        painter.paint(mark)
    return np.asarray(painter.picture.reduce(_OVERSAMPLING))


def joined_pictures(pictures: Sequence[UInt8[np.ndarray, "_ _ 3"]]) -> UInt8[np.ndarray, "h w 3"]:
    """Join pictures side by side, the first on the left. Lower ones stand at the bottom, below white."""
    height = max(map(len, pictures))
    return np.hstack([np.pad(p, ((height - len(p), 0), (0, 0), (0, 0)), constant_values=255) for p in pictures])


class _Painter:
    def __init__(self, drawing: Drawing, scale: int) -> None:
        self._scale, self._corner = scale, np.array([drawing.low[0], drawing.high[1]])
        width, height = np.ceil((drawing.high - drawing.low) * scale / _OVERSAMPLING).astype(int) * _OVERSAMPLING
        self.picture = Image.new("RGB", (int(width), int(height)), "white")

    def paint(self, mark: Mark) -> None:
        style = STYLES[mark.style]
        # Drawing in mode "RGBA" on an "RGB" picture blends translucent colours instead of overwriting.
        draw = ImageDraw.Draw(self.picture, "RGBA")
        fill = _colour(style.fill if mark.kind == "line" else mark.colour or style.fill, style.fill_opacity * style.opacity)
        stroke = _colour(mark.colour if mark.kind == "line" and mark.colour else style.stroke, style.opacity)
        width = max(1, round(style.width / 100 * self._scale))
        points = self._pixels(mark.points)
        if mark.kind == "text":
            letter = mark.size * self._scale
            font, outline = ImageFont.load_default(letter), round(_OUTLINE * letter)
            draw.text(points[0], mark.text, fill, font, anchor="lm", stroke_width=outline, stroke_fill="white")
        elif mark.kind == "line":
            for stretch in [points] if style.dash is None else _dashes(points, style.dash, self._scale / 100):
                draw.line(stretch, stroke, width, joint="curve")
        elif mark.kind == "dot":
            draw.circle(points[0], style.radius * self._scale, fill, stroke, width if stroke else 0)
        else:
            draw.polygon(points, fill, stroke, width if stroke else 0)

    def _pixels(self, points: Float[np.ndarray, "k 2"]) -> list[tuple[float, float]]:
        return [(float(x), float(y)) for x, y in (points - self._corner) * [self._scale, -self._scale]]


def _colour(name: str | None, opacity: float) -> tuple[int, ...] | None:
    return None if name is None else (*ImageColor.getrgb(name)[:3], round(255 * opacity))


def _dashes(
    points: list[tuple[float, float]], dash: tuple[float, float], scale: float
) -> Iterator[list[tuple[float, float]]]:
    """Yield the dashes of a line, each as a list of points. `scale` is in pixels per unit of `dash`."""
    line = np.array(points)
    along = arc_length(line)
    drawn, left_out = (length * scale for length in dash)
    for start in np.arange(0.0, along[-1], drawn + left_out):
        stop = min(start + drawn, along[-1])
        between = line[(along > start) & (along < stop)]
        ends = [[np.interp(at, along, line[:, axis]) for axis in (0, 1)] for at in (start, stop)]
        yield [(float(x), float(y)) for x, y in [ends[0], *between, ends[1]]]
