"""Marks (polygons, lines, dots, texts) from which floor plans are drawn, and styles that SVG and PNG output share."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from jaxtyping import Float

GLYPH_ASPECT = 0.58
"""Width of an average letter, relative to its height."""


@dataclass(frozen=True, eq=False)
class Mark:
    """A polygon, line, dot or text in plan coordinates (x to the right, y up, in metres)."""

    kind: Literal["polygon", "line", "dot", "text"]
    style: str
    """A key of `STYLES`; in SVG also the class of the element."""
    points: Float[np.ndarray, "k 2"]
    """Vertices in metres. Dots and texts have a single point; a text starts at its point."""
    colour: str | None = None
    """Colour `#rrggbb` in place of the style's: the fill of polygons, dots and texts, or the stroke of lines."""
    text: str = ""
    """Content of a text mark; tooltip of any other mark."""
    size: float = 0.3
    """Height of the letters of a text [m]."""
    room_colour: str | None = None
    """Colour `#rrggbb` of the estimated room, which a page may show in place of `colour`; in SVG the variable `--room`."""
    keyframe: int | None = None
    """Index of the keyframe that the mark represents; None for other marks."""


@dataclass(frozen=True)
class Style:
    """Style of marks on a white background: colours, strokes and sizes."""

    fill: str | None = None
    fill_opacity: float = 1.0
    stroke: str | None = None
    width: float = 1.0
    """Width of the stroke [cm]."""
    dash: tuple[float, float] | None = None
    """Lengths of a dash and of the gap after a dash [cm], for lines; None: a solid line."""
    radius: float = 0.0
    """Radius of a dot [m]."""
    opacity: float = 1.0


STYLES: dict[str, Style] = {
    "room": Style(fill="#cccccc", fill_opacity=0.24),
    "tread": Style(stroke="#8a929c", width=0.9),
    "climb": Style(stroke="#59626c", width=1.8),
    "furniture": Style(fill="#7a828c", fill_opacity=0.13, stroke="#7a828c", width=0.8),
    "fence": Style(fill="#9aa2ab"),
    "wall": Style(fill="#2b3138"),
    "low-wall": Style(fill="#ffffff", stroke="#2b3138", width=1.2),
    "door": Style(stroke="#8a929c", width=1.0),
    "overhead": Style(stroke="#59626c", width=1.4, dash=(11.0, 7.0)),
    "open": Style(stroke="#59626c", width=1.8, dash=(2.5, 6.0)),
    "window": Style(fill="#ffffff", stroke="#2b3138", width=1.2),
    "pane": Style(stroke="#2f7fb5", width=1.8),
    "swing": Style(stroke="#59626c", width=1.0),
    "leaf": Style(fill="#ffffff", stroke="#2b3138", width=1.2),
    "scale": Style(stroke="#59626c", width=3.0),
    "sight": Style(fill="#ffee00", fill_opacity=0.45, stroke="#111111", width=1.4),
    "walk": Style(stroke="#a7adb4", width=4.5),
    "walked": Style(stroke="#a7adb4", width=10.0),
    "belief": Style(stroke="#6aa0f2", width=1.3),
    "odometry": Style(stroke="#c77700", width=2.5, dash=(14.0, 8.0)),
    "true": Style(stroke="#2b3138", width=2.5, opacity=0.5),
    "estimated": Style(stroke="#1f6feb", width=2.5),
    "loop-true": Style(stroke="#12866b", width=1.8, opacity=0.6),
    "plan": Style(stroke="#8b3fd1", width=3.0, opacity=0.3),
    "path": Style(stroke="#8b3fd1", width=5.0, opacity=0.75),
    "camera": Style(fill="#ffee00", stroke="#111111", width=3.0, radius=0.18),
    "wrong-estimate": Style(fill="#ffffff", stroke="#111111", width=4.0, radius=0.115),
    "estimate": Style(fill="#ffffff", radius=0.08),
    "later-wrong-estimate": Style(fill="#ffffff", stroke="#111111", width=2.5, radius=0.075),
    "later-estimate": Style(fill="#ffffff", radius=0.05),
    "name": Style(fill="#3a4149"),
    "note": Style(fill="#3a4149"),
    "heading": Style(stroke="#2b3138", width=2.2),
    "view": Style(stroke="#1f6feb", width=4.0),
    "right": Style(fill="#ffffff", stroke="#ffffff", width=1.6, radius=0.085),
    "loop-false": Style(stroke="#d5202a", width=4.5, dash=(14.0, 8.0)),
    "plan-failed": Style(stroke="#d5202a", width=5.5, dash=(5.0, 5.0)),
    "plan-end": Style(stroke="#d5202a", width=6.0),
    "plan-number": Style(fill="#d5202a"),
    "error": Style(stroke="#d5202a", width=4.0),
    "wrong": Style(fill="#ffffff", stroke="#d5202a", width=4.0, radius=0.115),
}
"""Styles by name, in painting order. For readers who cannot tell green from red, marks of errors are not only red, but also
larger, dashed or with a thick outline. The camera lies beneath the dot that shows what is estimated there, and the line of
an error above both, because errors are often smaller than the dots. Estimates for many frames lie beneath the names of
rooms: rings of wrong estimates beneath all dots, so that the dots of neighbouring frames, which overlap, can still be
seen."""


def arrow(start: Float[np.ndarray, "2"], tip: Float[np.ndarray, "2"], head_m: float) -> Float[np.ndarray, "5 2"]:
    """Return the vertices of one line that draws an arrow between two different points, with a head `head_m` long [m]."""
    back = (start - tip) * (head_m / np.linalg.norm(start - tip))
    across = np.array([-back[1], back[0]]) * 0.7
    return np.stack([start, tip, tip + back + across, tip, tip + back - across])


@dataclass(frozen=True, eq=False)
class Drawing:
    """Marks, and the rectangle of the floor plan to show. Marks are painted in the order of their styles in `STYLES`."""

    marks: Sequence[Mark]
    low: Float[np.ndarray, "2"]
    """Lower left corner of the shown rectangle [m]."""
    high: Float[np.ndarray, "2"]
    """Upper right corner of the shown rectangle [m]."""
    title: str = field(default="plan", kw_only=True)

    @property
    def layers(self) -> list[Mark]:
        """The marks in painting order."""
        order = {style: i for i, style in enumerate(STYLES)}
        return sorted(self.marks, key=lambda mark: order[mark.style])

    def with_marks(self, more: Sequence[Mark], reach_m: float = 1.5) -> "Drawing":
        """Return the drawing with more marks. The rectangle is extended to show them, by at most `reach_m` on each side.

        The limit keeps the plan large when a trajectory has drifted far away.
        """
        points = np.concatenate([mark.points for mark in more]) if more else np.array([self.low, self.high])
        low = np.minimum(self.low, np.maximum(points.min(axis=0), self.low - reach_m))
        high = np.maximum(self.high, np.minimum(points.max(axis=0), self.high + reach_m))
        return Drawing([*self.marks, *more], low, high, title=self.title)
