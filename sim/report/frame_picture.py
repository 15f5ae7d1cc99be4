"""Pictures of one frame of a session: the image of the camera, and what was true and estimated there on the floor plan."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

import numpy as np
import shapely
from jaxtyping import Bool, Float64, Int
from shapely.geometry import LineString, Point, Polygon
from shapely.geometry.base import BaseGeometry

from lexis.maths.stretches import true_stretches
from lexis.types import Image, Pose, Poses
from sim.report.drawing import Mark, arrow
from sim.report.house_plan import marked_plan_image
from sim.report.legend import LegendEntry
from sim.session import Session
from worlds.house import House

_SIGHT_M, _RAYS = 1.5, 33
"""Length of the sector that shows the field of view [m], and number of directions in which walls may cut it off."""
_VIEW_M, _HEAD_M = 0.6, 0.14
"""Length of the arrow that shows where the estimated camera looks, and length of its head [m]."""
_BLUE = "#1f6feb"
_LISTED = 12
"""Largest number of estimates in the legend."""


@dataclass(frozen=True, eq=False)
class FrameEstimates:
    """What a SLAM estimates for its frames, to be drawn on a plan. Arrays have one row for each frame."""

    frames: Int[np.ndarray, "n"]
    """Indices of the frames in the tour, ascending."""
    T_W_B: Poses | None = None
    """Estimated poses, moved as a whole into the true world frame; None if they are not estimated."""
    groups: tuple[str, ...] = ()
    """What is estimated for each frame, in words, such as "estimated room 2"; empty if the plan shows none."""
    wrong: Bool[np.ndarray, "n"] | None = None
    """For each frame, whether the estimate in `groups` is wrong; None if no estimate is."""
    colours: Mapping[str, str] = field(default_factory=dict)
    """Colour `#rrggbb` of each estimate in `groups`. The legend lists the estimates in this order."""
    names_labels: bool = False
    """Whether the plan names the rooms by their true labels, too, and not by their ids alone."""


def place_image(session: Session, frame: int, estimates: FrameEstimates | None = None) -> Image:
    """Draw the plan of the frame's storey with the true path, the camera's place, the estimates and a legend."""
    named = estimates is not None and estimates.names_labels
    return marked_plan_image(session.house, session.truths[frame].storey, *frame_marks(session, frame, estimates), named)


def frame_marks(
    session: Session, frame: int, estimates: FrameEstimates | None = None
) -> tuple[list[Mark], list[LegendEntry]]:
    """Return the marks of a frame on the plan of its storey, and the entries of their legend.

    The true path on this storey is grey, the estimated path above it is blue, and both are thick up to the frame. The
    camera's place and what it sees of the floor nearby are yellow. With `estimates.groups`, dots at the true positions of
    the frames show these estimates; the dots of later frames are smaller. Otherwise, a line leads from the true to the
    estimated position of the frame.
    """
    storeys = np.array([truth.storey for truth in session.truths])
    here, positions = storeys == storeys[frame], session.tour.T_W_B[:, :2, 3]
    so_far = here & (np.arange(len(here)) <= frame)
    marks = [Mark("line", "walk", positions[part]) for part in true_stretches(here)]
    marks += [Mark("line", "walked", positions[part]) for part in true_stretches(so_far)]
    legend = [LegendEntry("line", "walked", "true path, thick up to this frame")]
    more: list[LegendEntry] = []
    if estimates is not None:
        shown = here[estimates.frames]
        marks += _estimate(estimates, shown, so_far[estimates.frames])
        legend += [] if estimates.T_W_B is None else [LegendEntry("line", "estimated", "estimated path")]
        if estimates.groups:
            now = so_far[estimates.frames]
            marks += _dots(estimates, positions[estimates.frames], shown & ~now, "later-")
            marks += _dots(estimates, positions[estimates.frames], now)
            more = list(_dot_entries(estimates, shown))
        elif estimates.T_W_B is not None and (estimates.frames == frame).any():
            marks += _error(session, frame, estimates.T_W_B[estimates.frames == frame][0])
            more = [
                LegendEntry("dot", "right", "the estimated position", _BLUE),
                LegendEntry("arrow", "view", "the estimated direction of view"),
                LegendEntry("line", "error", "from the true to the estimated position"),
            ]
    marks += _sight(session, frame)
    return marks, [*legend, LegendEntry("dot", "camera", "the camera and its field of view at this frame"), *more]


def _estimate(estimates: FrameEstimates, shown: Bool[np.ndarray, "n"], so_far: Bool[np.ndarray, "n"]) -> Iterator[Mark]:
    if estimates.T_W_B is not None:
        yield from (Mark("line", "belief", estimates.T_W_B[part, :2, 3]) for part in true_stretches(shown))
        yield from (Mark("line", "estimated", estimates.T_W_B[part, :2, 3]) for part in true_stretches(so_far))


def _dots(
    estimates: FrameEstimates, positions: Float64[np.ndarray, "n 2"], shown: Bool[np.ndarray, "n"], when: str = ""
) -> Iterator[Mark]:
    """Yield the dots of the frames that are `shown`, and rings around the wrong ones; `when` is "later-" for small dots."""
    for k in np.flatnonzero(shown).tolist():
        if estimates.wrong is not None and estimates.wrong[k]:
            yield Mark("dot", f"{when}wrong-estimate", positions[k : k + 1])
        yield Mark(
            "dot", f"{when}estimate", positions[k : k + 1], estimates.colours[estimates.groups[k]], estimates.groups[k]
        )


def _dot_entries(estimates: FrameEstimates, shown: Bool[np.ndarray, "n"]) -> Iterator[LegendEntry]:
    present = {estimates.groups[k] for k in np.flatnonzero(shown)}
    listed = [
        LegendEntry("dot", "estimate", group, colour) for group, colour in estimates.colours.items() if group in present
    ]
    yield from listed[:_LISTED]
    if len(listed) > _LISTED:
        yield LegendEntry("dot", "estimate", f"and {len(listed) - _LISTED} more", "#ffffff")
    if estimates.wrong is not None and (estimates.wrong & shown).any():
        yield LegendEntry("dot", "wrong-estimate", "ringed: wrong")


def _error(session: Session, frame: int, T_W_B: Pose) -> Iterator[Mark]:
    """Yield a line from the true to the estimated position, and the estimated position and direction of view in blue."""
    yield Mark("line", "error", np.stack([session.tour.T_W_B[frame, :2, 3], T_W_B[:2, 3]]))
    ahead = _ahead(T_W_B @ session.camera.T_B_C)
    if ahead.any():
        yield Mark("line", "view", arrow(T_W_B[:2, 3], T_W_B[:2, 3] + _VIEW_M * ahead, _HEAD_M))
    yield Mark("dot", "right", T_W_B[None, :2, 3], _BLUE)


def _ahead(T_W_C: Pose) -> Float64[np.ndarray, "2"]:
    """Return the horizontal direction in which a camera looks, as a vector of length 1 (0 if it looks up or down)."""
    ahead = T_W_C[:2, 2]
    return np.asarray(ahead / max(float(np.linalg.norm(ahead)), 1e-9))


def _sight(session: Session, frame: int) -> Iterator[Mark]:
    """Yield the camera's place, and the part of its field of view that is near and neither behind a wall nor outdoors."""
    k = session.camera.intrinsics
    T_W_B = session.tour.T_W_B[frame]
    T_W_C = T_W_B @ session.camera.T_B_C
    forward, half = _ahead(T_W_C), np.arctan(k.width / 2 / k.fx)
    angles = np.arctan2(forward[1], forward[0]) + np.linspace(-half, half, _RAYS)
    directions = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    eye, solid = T_W_C[:2, 3], _solid(session.house, session.truths[frame].storey, float(T_W_C[2, 3]))
    reach = [_reach_m(eye, direction, solid) for direction in directions]
    yield Mark("polygon", "sight", np.concatenate([eye[None], eye + np.array(reach)[:, None] * directions]))
    yield Mark("dot", "camera", T_W_B[None, :2, 3])


def _solid(house: House, level: int, eye_m: float) -> BaseGeometry:
    """Return the walls of a storey at the height `eye_m` in the world [m], and the outline of all its rooms."""
    walls = [wall.footprint for wall in house.walls if wall.storey == level and wall.bottom_m <= eye_m <= wall.top_m]
    rooms = shapely.union_all([Polygon(room.polygon_m) for room in house.spec.storeys[level].rooms])
    return shapely.union_all([*walls, rooms.boundary])


def _reach_m(eye: Float64[np.ndarray, "2"], direction: Float64[np.ndarray, "2"], solid: BaseGeometry) -> float:
    """Return the distance to the first solid point in a direction, at most `_SIGHT_M` [m]."""
    end = eye + _SIGHT_M * direction
    return Point(eye).distance(LineString([eye, end]).intersection(solid).union(Point(end)))
