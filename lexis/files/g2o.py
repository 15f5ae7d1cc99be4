"""Pose graphs as g2o files: lines ``VERTEX_SE3:QUAT id pose`` and ``EDGE_SE3:QUAT from to pose information``."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Float64

from lexis.files.reading import FileKind, numbered_lines
from lexis.maths.quaternions import poses_of
from lexis.maths.se3 import adjoint, inverse
from lexis.types import LoopEdge, Pose, Poses

TRANSLATION_FIRST = np.array([3, 4, 5, 0, 1, 2])
"""Order of rows and columns that turns a 6x6 matrix with rotation first into one with translation first, as g2o has it."""
_FILE = FileKind("a g2o file with lines VERTEX_SE3:QUAT and EDGE_SE3:QUAT", 500_000_000)
_NUMBERS = {"VERTEX_SE3:QUAT": 8, "EDGE_SE3:QUAT": 30}
"""How many numbers follow the first word of a line: the ids, seven numbers of a pose, and, for an edge, the 21 numbers of
the upper triangle of an information matrix."""
_IGNORED = ("FIX",)
_NORM_TOLERANCE = 0.01
"""Largest difference between the norm of a quaternion and 1."""


@dataclass(frozen=True, eq=False)
class G2oGraph:
    """A pose graph: initial poses, in the order of their ids in the file, and the measured edges between them."""

    T_W_B: Poses
    edges: tuple[LoopEdge, ...]
    """All edges, each from a later to an earlier pose. An edge that the file states in the other direction is inverted."""


def read_g2o(path: Path) -> G2oGraph:
    """Read a pose graph in three dimensions.

    Raises LexisError if the file cannot be read, a line is malformed, an id is given twice, an edge does not connect two
    different poses of the file, or an information matrix is not positive definite.
    """
    vertices: list[list[float]] = []
    edges: list[list[float]] = []
    vertex_lines: dict[float, int] = {}
    edge_lines: list[int] = []
    for number, line in numbered_lines(path, _FILE):
        kind, *words = line.split()
        if kind in _IGNORED:
            continue
        values = _numbers(path, number, kind, words)
        if kind.startswith("VERTEX"):
            first = vertex_lines.setdefault(values[0], number)
            if first != number:
                twice = f"vertex {words[0]} is given twice, first in line {first}"
                raise _FILE.refusal(path, f"line {number}: {twice}; valid: each id once")
            vertices.append(values)
        else:
            edges.append(values)
            edge_lines.append(number)
    if not vertices:
        raise _FILE.refusal(path, "holds no vertex; valid: a line 'VERTEX_SE3:QUAT id x y z qx qy qz qw' for each pose")
    rows = np.array(vertices)
    rows = rows[np.argsort(rows[:, 0])]
    return G2oGraph(poses_of(rows[:, 1:]), _edges(path, rows[:, 0], np.array(edges), edge_lines))


def _numbers(path: Path, number: int, kind: str, words: Sequence[str]) -> list[float]:
    """Return the numbers after the first word of a line.

    Raises LexisError unless `kind` is known, and the numbers are finite, as many as `kind` has, and contain a unit
    quaternion.
    """
    place = f"line {number}"
    if kind not in _NUMBERS:
        raise _FILE.refusal(path, f"{place}: {kind!r:.40} is not known; valid: {', '.join((*_NUMBERS, *_IGNORED))}")
    if len(words) != _NUMBERS[kind]:
        raise _FILE.refusal(path, f"{place}: {kind} with {len(words)} words; valid: {_NUMBERS[kind]} numbers after {kind}")
    values = [_number(word) for word in words]
    if not np.isfinite(values).all():
        wrong = words[int(np.isfinite(values).argmin())]
        raise _FILE.refusal(path, f"{place}: {wrong!r:.40} is not a finite number; valid: numbers such as 2, -0.5 or 1e-3")
    first = 1 if kind.startswith("VERTEX") else 2
    norm = np.linalg.norm(values[first + 3 : first + 7])
    if abs(norm - 1.0) > _NORM_TOLERANCE:
        valid = f"a unit quaternion qx qy qz qw, with a norm from {1 - _NORM_TOLERANCE:g} to {1 + _NORM_TOLERANCE:g}"
        raise _FILE.refusal(path, f"{place}: the quaternion has norm {norm:.3g}; valid: {valid}")
    return values


def _number(word: str) -> float:
    """Return the number that a word states; NaN if it states none."""
    try:
        return float(word)
    except ValueError:
        return np.nan


def _edges(
    path: Path, ids: Float64[np.ndarray, "n"], rows: Float64[np.ndarray, "..."], lines: Sequence[int]
) -> tuple[LoopEdge, ...]:
    rows = rows.reshape(-1, _NUMBERS["EDGE_SE3:QUAT"])
    ends = np.searchsorted(ids, rows[:, :2])
    known = ids[np.minimum(ends, len(ids) - 1)] == rows[:, :2]
    wrong = ~known.all(axis=1) | (ends[:, 0] == ends[:, 1])
    if wrong.any():
        k = int(wrong.argmax())
        a, b = rows[k, :2]
        reason = f"an edge needs two different vertices, and not {a:.15g} and {b:.15g}"
        raise _FILE.refusal(path, f"line {lines[k]}: {reason}; valid: two ids of vertices of the file")
    covariances = _covariances(path, rows[:, 9:], lines)
    found = zip(ends.tolist(), poses_of(rows[:, 2:9]), covariances, strict=True)
    return tuple(_edge(a, b, T_a_b, covariance) for (a, b), T_a_b, covariance in found)


def _edge(a: int, b: int, T_a_b: Pose, covariance: Float64[np.ndarray, "6 6"]) -> LoopEdge:
    """Return an edge from the later to the earlier pose. Inversion does not change the norm of the whitened residual."""
    if a < b:
        return LoopEdge(b, a, T_a_b, covariance, 0)
    Ad = adjoint(T_a_b)
    return LoopEdge(a, b, inverse(T_a_b), Ad @ covariance @ Ad.T, 0)


def _covariances(path: Path, triangles: Float64[np.ndarray, "m 21"], lines: Sequence[int]) -> Float64[np.ndarray, "m 6 6"]:
    """Covariances with rotation first, from upper triangles of information matrices with translation first."""
    information = np.zeros((len(triangles), 6, 6))
    rows, columns = np.triu_indices(6)
    information[:, rows, columns] = information[:, columns, rows] = triangles
    information = information[:, TRANSLATION_FIRST[:, None], TRANSLATION_FIRST]
    positive = np.linalg.eigvalsh(information)[:, 0] > 0
    if not positive.all():
        line = lines[int(np.argmin(positive))]
        valid = "the upper triangle of a positive definite matrix, row by row"
        raise _FILE.refusal(path, f"line {line}: the information matrix is not positive definite; valid: {valid}")
    return np.asarray(np.linalg.inv(information))
