"""`Estimate`: what a SLAM estimates in a run. Figures that need a field which the SLAM leaves out are null, never 0."""

from collections import Counter
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from numbers import Real
from operator import index
from types import MappingProxyType
from typing import Any, SupportsFloat, TypeGuard

import numpy as np
from jaxtyping import Float64, Int, Integer

from lexis.errors import encodable
from lexis.inputs import MAX_POSITION_M, type_of
from lexis.maths.se3 import is_rigid
from lexis.types import Poses
from sim.errors import EstimateError

_NO_SECONDS: Mapping[str, float] = MappingProxyType({})
_LONGEST_S = 1e9
"""Longest time of a stage [s]."""
_TYPES = MappingProxyType({"iu": np.int64, "fiu": np.float64})
"""The type into which the arrays of an estimate are converted, by the valid values of `dtype.kind`."""
_LARGEST = np.iinfo(np.int64).max
_RIGID = 1e-3
"""Tolerance in the check of estimated rotation matrices, which may have been computed in single precision."""
_FORMS: Mapping[str, tuple[str, tuple[int | None, ...]]] = MappingProxyType(
    {
        "T_W_B": ("fiu", (4, 4)),
        "labels": ("iu", ()),
        "baseline_labels": ("iu", ()),
        "rooms": ("iu", ()),
        "floors": ("iu", ()),
        "similarities": ("fiu", (None,)),
    }
)
"""For each optional array of `Estimate`, the valid values of numpy's `dtype.kind`, and the shape of one row (None: any
length)."""

_MEANINGS: Mapping[str, str] = MappingProxyType(
    dict.fromkeys(("labels", "baseline_labels"), ", indices into room_names or -1") | {"floors": ", with -1 on stairs"}
)
"""What the numbers of a field of `Estimate` mean, as the end of a message; for fields whose numbers are easily mistaken."""


@dataclass(frozen=True, eq=False)
class EstimatedLoops:
    """Loop closures: pairs of frames with the relative pose that the SLAM measured between them."""

    query: Int[np.ndarray, "m"]
    """For each loop, the row of its later frame in `Estimate.frames`."""
    match: Int[np.ndarray, "m"]
    """For each loop, the row of its earlier frame in `Estimate.frames`."""
    T_match_query: Float64[np.ndarray, "m 4 4"]
    """For each loop, the measured pose of the body at the later frame, in the body frame of the earlier frame."""
    weights: Float64[np.ndarray, "m"] | None = None
    """Final confidence of the SLAM in each loop, in [0, 1]; None if the SLAM gives no confidences."""

    def converted(self) -> "EstimatedLoops":
        """Return a copy of the loops, with indices as int64 and all other numbers as float64."""
        query, match = (each.astype(np.int64) for each in (self.query, self.match))
        weights = None if self.weights is None else self.weights.astype(np.float64)
        return EstimatedLoops(query, match, self.T_match_query.astype(np.float64), weights)


@dataclass(frozen=True)
class CandidateDecision:
    """What became of one proposed revisit, and why."""

    query: int
    """Row of the later frame in `Estimate.frames`."""
    match: int
    """Row of the earlier frame in `Estimate.frames`."""
    accepted: bool
    """Whether the revisit became a loop closure."""
    reason: str
    """Why the revisit was accepted or refused, in a few words; the report counts equal reasons."""
    figures: Mapping[str, SupportsFloat]
    """The values on which the decision was based, by name and unit, such as "inliers" or "misfit [m]"; unknown values are
    left out."""


@dataclass(frozen=True, eq=False)
class Estimate:
    """What a SLAM estimates in a run. Arrays have one row for each frame in `frames`: its keyframes, or all frames.

    Raises `EstimateError` for values of another type than the fields state; for arrays that differ in their number of
    rows, or have numbers that are not finite; for rows that do not exist; for poses that are no rigid motions or not on
    Earth; for labels, rooms and floors below -1; and for loops whose query is not later than its match, or that are listed
    twice.
    """

    frames: Int[np.ndarray, "n"]
    """`Observation.index` of every frame that the estimate covers, ascending and each once."""
    T_W_B: Poses | None = None
    """Poses of the body in the SLAM's own world frame. To compute figures, this frame is aligned with the true world
    frame."""
    labels: Int[np.ndarray, "n"] | None = None
    """Room label of every frame, as an index into the argument `room_names` of `SlamUnderTest.start`. -1: the frame has no
    label, which counts as wrong."""
    baseline_labels: Int[np.ndarray, "n"] | None = None
    """Labels before refinement, in the form of `labels`; for a SLAM that refines labels."""
    rooms: Int[np.ndarray, "n"] | None = None
    """Room instance of every frame, as a number from 0 that the SLAM chooses; -1 for a frame in no room."""
    floors: Int[np.ndarray, "n"] | None = None
    """Floor number of every frame: 0 for the lowest floor, -1 for a frame on stairs."""
    loops: EstimatedLoops | None = None
    candidates: tuple[tuple[int, tuple[int, ...]], ...] | None = None
    """Proposed revisits: for each query (a row of `frames`), the rows of the frames that may show the same place, the most
    similar first."""
    decisions: tuple[CandidateDecision, ...] | None = None
    """What became of proposed revisits. Only the report shows these decisions; no figure depends on them."""
    similarities: Float64[np.ndarray, "n names"] | None = None
    """Similarity of every frame with every room name. The report shows the highest similarities of some frames."""
    encoder: str | None = None
    """Name of the vision-language model that was used."""
    stage_seconds: Mapping[str, float] = field(default_factory=lambda: _NO_SECONDS)
    """Wall time of each stage of the SLAM [s], by the stage's name."""

    def __post_init__(self) -> None:
        n = _checked_frames(self.frames)
        for name, (kinds, row) in _FORMS.items():
            if (values := getattr(self, name)) is not None:
                _check_rows(name, values, n, kinds, row)
        if self.T_W_B is not None:
            _check_rigid("T_W_B", self.T_W_B)
        for name in ("labels", "baseline_labels", "rooms", "floors"):
            values = getattr(self, name)
            if values is not None and (below := np.flatnonzero(values < -1)).size:
                bad = f"{name} has {values[below[0]]} in row {below[0]}"
                raise EstimateError(f"estimate: {bad}; valid: numbers from 0, or -1 for none")
        if self.loops is not None:
            _check_loops(self.loops)
        rows = [] if self.loops is None else [*self.loops.query.tolist(), *self.loops.match.tolist()]
        rows += [] if self.candidates is None else _candidate_rows(self.candidates)
        rows += [] if self.decisions is None else _decision_rows(self.decisions)
        object.__setattr__(self, "stage_seconds", _checked_stages(self.stage_seconds))
        if self.encoder is not None:
            _check_text("encoder", self.encoder)
        if rows and not 0 <= min(rows) <= max(rows) < n:
            found = f"rows {min(rows)} to {max(rows)}"
            raise EstimateError(f"estimate: loops, candidates and decisions refer to {found}; valid: 0 to {n - 1}")
        self._convert_arrays()

    def _convert_arrays(self) -> None:
        """Copy whole numbers as int64 and other numbers as float64, so that figures do not depend on a SLAM's types.

        Lists become tuples, so that a SLAM that goes on to write into them changes nothing.
        """
        object.__setattr__(self, "frames", self.frames.astype(np.int64))
        for name, (kinds, _) in _FORMS.items():
            if (values := getattr(self, name)) is not None:
                object.__setattr__(self, name, values.astype(_TYPES[kinds]))
        if self.loops is not None:
            object.__setattr__(self, "loops", self.loops.converted())
        if self.candidates is not None:
            own = tuple((index(query), tuple(map(index, matches))) for query, matches in self.candidates)
            object.__setattr__(self, "candidates", own)
        if self.decisions is not None:
            object.__setattr__(self, "decisions", tuple(self.decisions))

    def named_rooms(self, room_names: tuple[str, ...]) -> dict[int, str] | None:
        """Return the most frequent label of every room instance, by the instance's number.

        Instances without any labelled frame are left out. The result is None unless there are both rooms and labels.
        """
        if self.rooms is None or self.labels is None:
            return None
        named = (self.rooms >= 0) & (self.labels >= 0)
        counts = {int(room): np.bincount(self.labels[named & (self.rooms == room)]) for room in np.unique(self.rooms[named])}
        return {room: room_names[int(np.argmax(count))] for room, count in counts.items()}


def _checked_frames(frames: object) -> int:
    """Return the number of frames. Raises `EstimateError` unless `frames` holds indices from 0, ascending and each once."""
    if not _is_plain(frames) or frames.dtype.kind not in "iu" or frames.ndim != 1:
        raise EstimateError(f"estimate: frames is {type_of(frames)}; valid: an array of whole numbers, one for each frame")
    valid = "valid: one or more indices of observations, from 0 and ascending, each once"
    if len(frames) == 0:
        raise EstimateError(f"estimate: frames is empty; {valid}")
    _check_size("frames", frames)
    if (below := np.flatnonzero(frames < 0)).size:
        raise EstimateError(f"estimate: frames has {frames[below[0]]} in row {below[0]}; {valid}")
    if (falls := 1 + np.flatnonzero(frames[1:] <= frames[:-1])).size:
        row = falls[0]
        late = "faults may deliver observations late or twice"
        raise EstimateError(f"estimate: frames has {frames[row]} after {frames[row - 1]} in row {row}; {valid} ({late})")
    return len(frames)


def _candidate_rows(candidates: object) -> list[int]:
    """Return all rows that proposed revisits refer to. Raises `EstimateError` for another form."""
    if _is_list(candidates) and all(_is_list(pair) and len(pair) == 2 and _is_list(pair[1]) for pair in candidates):
        with suppress(TypeError):
            rows = [[index(query), *map(index, matches)] for query, matches in candidates]
            repeated = [row for row, count in Counter(row for row, *_ in rows).items() if count > 1]
            if repeated:
                raise EstimateError(f"estimate: candidates has two entries for row {repeated[0]}; valid: one for each query")
            return [row for entry in rows for row in entry]
    valid = "a tuple of pairs of a row and other rows, such as ((7, (2, 0)),)"
    raise EstimateError(f"estimate: candidates is {candidates!r:.60}; valid: {valid}")


def _is_list(value: object) -> TypeGuard[Sequence[Any]]:
    """Whether a value is a sequence, which can be read more than once, unlike a generator."""
    return isinstance(value, Sequence) or (isinstance(value, np.ndarray) and value.ndim > 0)


def _decision_rows(decisions: object) -> list[int]:
    """Return all rows that decisions refer to. Raises `EstimateError` for anything but a sequence of `CandidateDecision`."""
    if not isinstance(decisions, Sequence) or not all(isinstance(each, CandidateDecision) for each in decisions):
        raise EstimateError(f"estimate: decisions is {decisions!r:.60}; valid: a tuple of CandidateDecision")
    for decision in decisions:
        _check_text("reason of a decision", decision.reason)
        if not isinstance(decision.figures, Mapping):
            raise EstimateError(
                f"estimate: figures of a decision are {decision.figures!r:.40}; valid: a mapping of names to numbers"
            )
        for name, value in decision.figures.items():
            _check_text("name of a figure of a decision", name)
            if not isinstance(value, Real):
                given = f"figures[{name!r:.40}] of a decision is {value!r:.40}"
                raise EstimateError(f"estimate: {given}; valid: a number; leave unknown figures out")
    try:
        return [index(row) for decision in decisions for row in (decision.query, decision.match)]
    except TypeError:
        raise EstimateError("estimate: query or match of a decision is no whole number; valid: rows of frames") from None


def _checked_stages(seconds: object) -> Mapping[str, float]:
    """Return the times of the stages as numbers of Python. Raises `EstimateError` for anything but a mapping to numbers."""
    if not isinstance(seconds, Mapping) or not all(isinstance(each, Real) for each in seconds.values()):
        raise EstimateError(f"estimate: stage_seconds is {seconds!r:.60}; valid: a mapping of the stage's name to seconds")
    for name, value in seconds.items():
        _check_text("name in stage_seconds", name)
        if not 0.0 <= value <= _LONGEST_S:
            raise EstimateError(f"estimate: stage_seconds[{name!r:.40}] is {value!r:.40}; valid: 0 to {_LONGEST_S:g} s")
    return MappingProxyType({name: float(value) for name, value in seconds.items()})


def _check_text(name: str, text: object) -> None:
    """Raise `EstimateError` unless a field is a text that can be written to a file."""
    if not isinstance(text, str) or encodable(text) != text:
        raise EstimateError(f"estimate: {name} is {text!r:.40}; valid: a text")


def _check_loops(loops: object) -> None:
    """Raise `EstimateError` unless there are as many matches, rigid motions and weights in [0, 1] as queries."""
    if not isinstance(loops, EstimatedLoops):
        raise EstimateError(f"estimate: loops is {type_of(loops)}; valid: EstimatedLoops")
    n = len(loops.query) if _is_plain(loops.query) and loops.query.ndim else 0
    for name in ("query", "match"):
        _check_rows(f"loops.{name}", getattr(loops, name), n, "iu", ())
    if (wrong := np.flatnonzero(loops.query <= loops.match)).size:
        row = wrong[0]
        pair = f"query {loops.query[row]} and match {loops.match[row]} in row {row}"
        raise EstimateError(f"estimate: loops has {pair}; valid: a query that is later than its match")
    if (repeated := repeated_pair(loops.query, loops.match)) is not None:
        first, row = repeated
        pair = f"the pair of query {loops.query[row]} and match {loops.match[row]} in rows {first} and {row}"
        raise EstimateError(f"estimate: loops has {pair}; valid: each pair once")
    _check_rows("loops.T_match_query", loops.T_match_query, n, "fiu", (4, 4))
    _check_rigid("loops.T_match_query", loops.T_match_query)
    if loops.weights is not None:
        _check_rows("loops.weights", loops.weights, n, "fiu", ())
        if n and not 0.0 <= loops.weights.min() <= loops.weights.max() <= 1.0:
            found = f"{loops.weights.min():g} to {loops.weights.max():g}"
            raise EstimateError(f"estimate: loops.weights are {found}; valid: numbers in [0, 1]")


def repeated_pair(query: Integer[np.ndarray, "m"], match: Integer[np.ndarray, "m"]) -> tuple[int, int] | None:
    """Return the rows of the first two loops between the same frames; None without any."""
    rows: dict[tuple[int, int], int] = {}
    for row, pair in enumerate(zip(query.tolist(), match.tolist(), strict=True)):
        if (first := rows.setdefault(pair, row)) != row:
            return first, row
    return None


def _check_rigid(name: str, motions: Float64[np.ndarray, "n 4 4"]) -> None:
    """Raise `EstimateError` unless all matrices are rigid motions."""
    rigid = is_rigid(np.asarray(motions, np.float64), _RIGID)
    if not rigid.all():
        row = int(np.argmin(rigid))
        problem = f"estimate: {name} is no rigid motion in row {row}"
        if is_rigid(np.asarray(motions[row], np.float64).T, _RIGID):
            raise EstimateError(f"{problem}: the last row is not 0 0 0 1; is the pose transposed?")
        raise EstimateError(f"{problem}; valid: rotation and translation")
    far = np.abs(motions[:, :3, 3]).max(axis=1, initial=0.0) > MAX_POSITION_M
    if far.any():
        raise EstimateError(
            f"estimate: {name} is beyond {MAX_POSITION_M:g} m in row {int(far.argmax())}; valid: places on Earth"
        )


def _check_rows(name: str, values: object, n: int, kinds: str, row: tuple[int | None, ...]) -> None:
    """Raise `EstimateError` unless a field of an estimate is an array with `n` finite rows of the given shape."""
    wanted = "whole numbers" if kinds == "iu" else "numbers"
    if not _is_plain(values) or values.dtype.kind not in kinds or values.ndim != 1 + len(row):
        shape = ", ".join(["n", *("any" if size is None else str(size) for size in row)])
        valid = f"an array of {wanted} of shape ({shape}){_MEANINGS.get(name, '')}"
        raise EstimateError(f"estimate: {name} is {type_of(values)}; valid: {valid}")
    if len(values) != n:
        of = "loop closure" if name.startswith("loops.") else "of the frames"
        raise EstimateError(f"estimate: {name} has {len(values)} rows; valid: {n}, one for each {of}")
    if any(size not in (None, found) for size, found in zip(row, values.shape[1:], strict=True)):
        raise EstimateError(f"estimate: {name} has shape {values.shape}; valid: {(n, *row)}")
    if not np.isfinite(values).all():
        raise EstimateError(f"estimate: {name} is not finite in row {int(np.argwhere(~np.isfinite(values))[0, 0])}")
    if kinds == "iu":
        _check_size(name, values)


def _check_size(name: str, values: Integer[np.ndarray, "n"]) -> None:
    """Raise `EstimateError` for numbers that int64 cannot hold, such as an unsigned -1."""
    if (beyond := np.flatnonzero(values > _LARGEST)).size:
        raise EstimateError(f"estimate: {name} has {values[beyond[0]]} in row {beyond[0]}; valid: numbers up to 2^63 - 1")


def _is_plain(value: object) -> TypeGuard[np.ndarray]:
    """Whether a value is an array of numpy, and not one that hides some of its numbers."""
    return isinstance(value, np.ndarray) and not isinstance(value, np.ma.MaskedArray)
