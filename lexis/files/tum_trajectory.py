"""Trajectories as TUM files: "stamp tx ty tz qx qy qz qw", in seconds and metres."""

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from jaxtyping import Float64
from scipy.spatial.transform import Rotation

from lexis.errors import LexisError
from lexis.files.reading import FileKind, numbered_lines
from lexis.files.replace import replaced_file
from lexis.maths.quaternions import UNIT_TOLERANCE, poses_of
from lexis.types import Poses

_FILE = FileKind("lines of 'stamp tx ty tz qx qy qz qw'", 200_000_000)


def write_tum(path: Path, stamps: Sequence[float] | Float64[np.ndarray, "n"], poses: Poses) -> None:
    """Write stamps [s] and poses as lines of "stamp tx ty tz qx qy qz qw". Raises LexisError if writing fails."""
    quaternions = Rotation.from_matrix(poses[:, :3, :3]).as_quat(canonical=True) if len(poses) else np.zeros((0, 4))
    rows = np.column_stack([stamps, poses[:, :3, 3], quaternions])
    text = "".join(f"{row[0]:.6f} {' '.join(f'{value:.9f}' for value in row[1:])}\n" for row in rows)
    with replaced_file(path) as beside:
        beside.write_text(text, encoding="utf-8")


def read_tum(path: Path) -> tuple[Float64[np.ndarray, "n"], Poses]:
    """Read stamps [s] and poses from a TUM file; lines that begin with # are skipped.

    Raises:
        LexisError: the file cannot be read, a line is not eight finite numbers with a unit quaternion, or stamps do not
            ascend.
    """
    rows = np.array([_numbers(path, number, line) for number, line in numbered_lines(path, _FILE)]).reshape(-1, 8)
    if not len(rows):
        raise LexisError(f"{path}: holds no pose; valid: lines of 'stamp tx ty tz qx qy qz qw'")
    if (np.diff(rows[:, 0]) <= 0).any():
        k = int(np.flatnonzero(np.diff(rows[:, 0]) <= 0)[0]) + 1
        raise LexisError(f"{path}: stamp {rows[k, 0]} follows {rows[k - 1, 0]}; valid: ascending stamps")
    return rows[:, 0].copy(), poses_of(rows[:, 1:])


def _numbers(path: Path, number: int, line: str) -> list[float]:
    try:
        values = [float(word) for word in line.split()]
    except ValueError:
        values = []
    if len(values) != 8 or not all(map(math.isfinite, values)):
        raise LexisError(f"{path}:{number}: {line[:80]!r}; valid: eight finite numbers 'stamp tx ty tz qx qy qz qw'")
    if abs((norm := math.hypot(*values[4:])) - 1.0) > UNIT_TOLERANCE:
        raise LexisError(f"{path}:{number}: the quaternion qx qy qz qw has the norm {norm:.4g}; valid: 1")
    return values
