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
    edge_lines: list[int] = []
    for number, line in numbered_lines(path, _FILE):
        kind, *words = line.split()
        if kind in _IGNORED:
            continue
        values = _numbers(path, number, kind, words)
        if kind.startswith("VERTEX"):
            vertices.append(values)
        else:
            edges.append(values)
            edge_lines.append(number)
    rows = np.array(vertices).reshape(-1, _NUMBERS["VERTEX_SE3:QUAT"])
    ids = np.unique(rows[:, 0])
    if len(ids) < max(len(rows), 1):
        raise _FILE.refusal(path, "holds no vertex, or an id twice")
    return G2oGraph(poses_of(rows[np.argsort(rows[:, 0]), 1:]), _edges(path, ids, np.array(edges), edge_lines))


def _numbers(path: Path, number: int, kind: str, words: Sequence[str]) -> list[float]:
    """Return the numbers after the first word of a line.

    Raises LexisError unless they are finite, as many as `kind` has, and contain a unit quaternion.
    """
    try:
        values = [float(word) for word in words]
    except ValueError:
        values = []
    if len(values) != _NUMBERS.get(kind, -1) or not np.isfinite(values).all():
        raise _FILE.refusal(path, f"line {number}: {kind} with {len(words)} words")
    first = 1 if kind.startswith("VERTEX") else 2
    if abs(np.linalg.norm(values[first + 3 : first + 7]) - 1.0) > 1e-2:
        raise _FILE.refusal(path, f"line {number}: the quaternion has no unit norm")
    return values


def _edges(
    path: Path, ids: Float64[np.ndarray, "n"], rows: Float64[np.ndarray, "..."], lines: Sequence[int]
) -> tuple[LoopEdge, ...]:
    rows = rows.reshape(-1, _NUMBERS["EDGE_SE3:QUAT"])
    ends = np.searchsorted(ids, rows[:, :2])
    known = ids[np.minimum(ends, len(ids) - 1)] == rows[:, :2]
    wrong = ~known.all(axis=1) | (ends[:, 0] == ends[:, 1])
    if wrong.any():
        raise _FILE.refusal(path, f"line {lines[int(wrong.argmax())]}: an edge needs two different vertices of the file")
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
        raise _FILE.refusal(path, f"line {line}: the information matrix is not positive definite")
    return np.asarray(np.linalg.inv(information))
