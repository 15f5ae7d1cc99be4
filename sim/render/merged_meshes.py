"""Merges meshes for faster rendering: surfaces with the same texture image and the same visibility cells become one mesh.

Each indoor room is a visibility cell, and everything outdoors is one cell; see `visibility`.
"""

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from sim.render.visibility import Cells, Visibility
from worlds.visuals.house_visuals import ATLAS, Visual
from worlds.visuals.surfaces import OUTSIDE


@dataclass(frozen=True, eq=False)
class Merged:
    """A merged mesh. It is drawn if the camera may see one of its visibility cells (rooms, or everything outdoors)."""

    visual: Visual
    cells: Cells


def cells_of(part: Visual, visibility: Visibility) -> Cells:
    """Return the visibility cells (rooms, or everything outdoors) that contain a part of the scene.

    A wall, floor or ceiling is in the cell of its room. An object is in every cell that it reaches into.
    """
    if part.image == ATLAS:
        return visibility.cells_of(part.corners)
    room = part.name.rpartition("/")[0]
    return frozenset([visibility.outdoors if room == OUTSIDE else visibility.cell_of_room(room)])


def merge(parts: Sequence[Visual], visibility: Visibility) -> tuple[Merged, ...]:
    """Merge the parts that have equal texture images and visibility cells.

    The order of `parts` is kept. Where two faces are coplanar, the same face is therefore visible as without merging.
    """
    groups: dict[tuple[str, Cells], list[Visual]] = defaultdict(list)
    for part in parts:
        groups[part.image, cells_of(part, visibility)].append(part)
    return tuple(
        Merged(_joined(f"merged/{i}", image, group), cells) for i, ((image, cells), group) in enumerate(groups.items())
    )


def _joined(name: str, image: str, group: Sequence[Visual]) -> Visual:
    corners, uv, normals = (np.concatenate([getattr(part, f) for part in group]) for f in ("corners", "uv", "normals"))
    return Visual(name, name, image, corners, uv, normals)
