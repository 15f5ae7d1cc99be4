"""The file `loops.json`, in which a program states its loop closures and, optionally, the revisits that it proposed."""

from collections.abc import Callable, Sequence
from itertools import islice
from pathlib import Path
from typing import Annotated, Any, Literal, TypeAlias

import numpy as np
from jaxtyping import Bool, Float64, Int
from pydantic import BaseModel, ConfigDict, Field

from lexis.files.reading import FileKind, read_model
from lexis.maths.quaternions import poses_of
from sim.errors import SimError
from sim.harness.estimate import EstimatedLoops, repeated_pair

LOOPS = "loops.json"
"""File with loop closures and candidates; see `LoopFile`."""
_LOOPS_FILE = FileKind("loops.json as in sim/pages/your-slam.md", 100_000_000, SimError)
_UNIT = 0.01
"""Largest accepted deviation of a quaternion's norm from 1."""

RowsOf: TypeAlias = Callable[[Sequence[float]], Int[np.ndarray, "k"]]
"""A function that finds the rows of the estimate for stamps [s]. It raises `SimError` for a stamp without a frame in the
estimate. Each call takes a time that grows with the number of frames."""


class _Strict(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True, allow_inf_nan=False)


class LoopEntry(_Strict):
    """One loop closure between two frames."""

    query: float
    """Stamp of the later frame [s]."""
    match: float
    """Stamp of the earlier frame [s]."""
    T_match_query: Annotated[list[float], Field(min_length=7, max_length=7)]
    """Measured pose of the body at the later frame, in the body frame of the earlier frame: tx ty tz [m], qx qy qz qw."""
    weight: Annotated[float, Field(ge=0.0, le=1.0)] | None = None
    """Final confidence of the program in the loop; 1 if only other loops of the file have a weight."""


class CandidateEntry(_Strict):
    """Earlier frames that may show the same place as one later frame. The program proposed them before verification."""

    query: float
    """Stamp of the later frame [s]."""
    matches: list[float]
    """Stamps of the earlier frames, the most similar one first [s]."""


class LoopFile(_Strict):
    """The content of loops.json."""

    version: Literal[1]
    loops: list[LoopEntry]
    """Loop closures; an empty list means that there are none."""
    candidates: list[CandidateEntry] | None = None
    """Revisits that the program has proposed; None if the file does not list them."""


def read_loops(path: Path, rows_of: RowsOf) -> dict[str, Any]:
    """Read loops.json, and return its contents as fields of `Estimate`: `loops`, and `candidates` if the file lists them.

    Loops and candidates of frames before the walk are left out; `rows_of` returns -1 for them.

    Raises `SimError` for a file that is not valid, a stamp that belongs to no frame, a loop or a candidate whose match is
    not earlier than its query, two loops between the same frames, two entries of candidates for one query, and a quaternion
    whose norm is not 1.
    """
    file = read_model(path, _LOOPS_FILE, LoopFile)
    query, match = (rows_of([getattr(loop, name) for loop in file.loops]) for name in ("query", "match"))
    rows = np.array([loop.T_match_query for loop in file.loops], float).reshape(-1, 7)
    _check(file.loops, (query <= match) & (query >= 0), np.linalg.norm(rows[:, 3:], axis=1))
    walked, weights = (query >= 0) & (match >= 0), _weights(file.loops)
    if (repeated := repeated_pair(query[walked], match[walked])) is not None:
        again = file.loops[np.flatnonzero(walked)[repeated[1]]]
        raise SimError(f"{_place(again)} is a second entry for one pair of frames; valid: each pair once")
    chosen = None if weights is None else weights[walked]
    fields: dict[str, Any] = {"loops": EstimatedLoops(query[walked], match[walked], poses_of(rows[walked]), chosen)}
    if file.candidates is not None:
        fields["candidates"] = tuple(_candidates(file.candidates, rows_of).items())
    return fields


def _candidates(entries: Sequence[CandidateEntry], rows_of: RowsOf) -> dict[int, tuple[int, ...]]:
    """Return the rows of the matches by the row of their query, without frames before the walk."""
    queries = rows_of([entry.query for entry in entries]).tolist()
    every = iter(rows_of([stamp for entry in entries for stamp in entry.matches]).tolist())
    candidates: dict[int, tuple[int, ...]] = {}
    for entry, query in zip(entries, queries, strict=True):
        matches = tuple(islice(every, len(entry.matches)))
        if query < 0:
            continue
        place = f"{LOOPS}: the candidates of {entry.query:.6f} s"
        if max(matches, default=-1) >= query:
            raise SimError(f"{place} are not all earlier; valid: matches before their query")
        if query in candidates:
            raise SimError(f"{place} are a second entry for one frame; valid: one entry with all its matches")
        candidates[query] = tuple(row for row in matches if row >= 0)
    return candidates


def _weights(loops: Sequence[LoopEntry]) -> Float64[np.ndarray, "m"] | None:
    """Return the weights of all loops, or None if no loop has a weight."""
    if all(loop.weight is None for loop in loops):
        return None
    return np.array([1.0 if loop.weight is None else loop.weight for loop in loops])


def _place(loop: LoopEntry) -> str:
    return f"{LOOPS}: the loop from {loop.query:.6f} to {loop.match:.6f} s"


def _check(loops: Sequence[LoopEntry], not_earlier: Bool[np.ndarray, "m"], norms: Float64[np.ndarray, "m"]) -> None:
    """Raise `SimError` for a loop whose match is not earlier than its query, and for a quaternion whose norm is not 1."""
    for loop, is_not_earlier, norm in zip(loops, not_earlier.tolist(), norms.tolist(), strict=True):
        place = _place(loop)
        if is_not_earlier:
            raise SimError(f"{place} does not lead to an earlier frame; valid: match before query")
        if abs(norm - 1.0) > _UNIT:
            raise SimError(f"{place}: qx qy qz qw is no unit quaternion; valid: norm 1")
