"""Pictures of one frame of a session: the image of the camera, and the place of the camera on the floor plan."""

from collections.abc import Iterator

import numpy as np

from lexis.types import Image
from sim.report.drawing import Mark
from sim.report.house_plan import marked_plan_image
from sim.session import Session

_SIGHT_M = 1.2
"""Length of the sector that shows the field of view [m]."""
_RED = "#d5202a"


def camera_image(session: Session, frame: int) -> Image:
    """Render the image of the camera at a frame of the tour again. Raises `GraphicsError` without off-screen OpenGL."""
    return session.picture(frame)


def place_image(session: Session, frame: int) -> Image:
    """Draw the plan of the frame's storey, with the walk so far in grey, and the camera's place and field of view in red."""
    storeys = np.array([truth.storey for truth in session.truths[: frame + 1]])
    walked = session.tour.T_W_B[: frame + 1, :2, 3]
    here = np.flatnonzero(storeys == storeys[frame])
    marks = [Mark("line", "true", walked[part]) for part in np.split(here, np.flatnonzero(np.diff(here) > 1) + 1)]
    return marked_plan_image(session.house, int(storeys[frame]), [*marks, *_sight(session, frame)])


def _sight(session: Session, frame: int) -> Iterator[Mark]:
    k = session.camera.intrinsics
    T_W_C = session.tour.T_W_B[frame] @ session.camera.T_B_C
    forward, half = T_W_C[:2, 2], np.arctan(k.width / 2 / k.fx)
    angles = np.arctan2(forward[1], forward[0]) + np.linspace(-half, half, 17)
    arc = T_W_C[:2, 3] + _SIGHT_M * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    yield Mark("line", "heading", np.concatenate([T_W_C[None, :2, 3], arc, T_W_C[None, :2, 3]]), _RED)
    yield Mark("dot", "wrong", T_W_C[None, :2, 3], _RED)
