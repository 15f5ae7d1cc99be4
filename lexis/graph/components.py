"""The components of a map. Sessions that loop edges connect share a frame; other sessions lie beside them."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Int

from lexis.maths.groups import groups_of
from lexis.types import Keyframe, LexisMap, LoopArrays, LoopEdge, Poses

_GAP_M = 10.0
"""Distance between components that are laid side by side [m]. No method of LEXIS connects places so far apart."""


def sessions_of(keyframes: Sequence[Keyframe]) -> Int[np.ndarray, "n"]:
    """Return the session of every keyframe."""
    return np.array([keyframe.session for keyframe in keyframes], int)


def session_components(keyframes: Sequence[Keyframe], loops: Sequence[LoopEdge]) -> Int[np.ndarray, "sessions"]:
    """Return the component of every session, named by the number of its earliest session."""
    sessions = sessions_of(keyframes)
    edges, count = LoopArrays.of(loops), int(sessions.max()) + 1
    ends = sessions[edges.query], sessions[edges.match]
    group = groups_of(np.stack(ends, axis=1), count)
    earliest = np.unique(group, return_index=True)[1]
    return np.asarray(earliest[group])


def component_of(map: LexisMap) -> Int[np.ndarray, "n"]:
    """Return the component of every keyframe of a map, named by the number of its earliest session."""
    return np.asarray(session_components(map.keyframes, map.loops)[sessions_of(map.keyframes)])


def sessions_apart(map: LexisMap) -> list[int]:
    """Return the sessions of a map that are not connected with its first session."""
    return np.flatnonzero(session_components(map.keyframes, map.loops)).tolist()


def side_by_side(T_W_B: Poses, components: Int[np.ndarray, "n"]) -> Poses:
    """Lay components that share no frame beside each other along x, so that no two of them overlap.

    The first component stays where it is, and every component keeps its shape and its heights.
    """
    laid = T_W_B.copy()
    names = np.unique(components)
    end_m = laid[components == names[0], 0, 3].max()
    for name in names[1:]:
        rows = components == name
        laid[rows, 0, 3] += end_m + _GAP_M - laid[rows, 0, 3].min()
        end_m = laid[rows, 0, 3].max()
    return laid
