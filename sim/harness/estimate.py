"""The claims that a SLAM makes about a run. Every claim is optional: figures without a claim are null, never 0."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

import numpy as np
from jaxtyping import Float64, Int

from lexis.types import Poses
from sim.errors import SimError

_NO_SECONDS: Mapping[str, float] = MappingProxyType({})


@dataclass(frozen=True, eq=False)
class LoopClaims:
    """Loop closures: pairs of frames with the relative pose that the SLAM measured between them."""

    query: Int[np.ndarray, "m"]
    """Row of the later frame in `Estimate.frames`."""
    match: Int[np.ndarray, "m"]
    """Row of the earlier frame."""
    T_match_query: Float64[np.ndarray, "m 4 4"]
    """Measured pose of the query's body in the body frame of the match."""
    weights: Float64[np.ndarray, "m"]
    """Final confidence of the SLAM in each loop, in [0, 1]; all ones if the SLAM gives no confidence."""


@dataclass(frozen=True, eq=False)
class Estimate:
    """The claims of a SLAM about a run, with one row for each frame that they cover: its keyframes, or all frames.

    Raises `SimError` for claims whose sizes differ, that are not finite, or that refer to rows that do not exist.
    """

    frames: Int[np.ndarray, "n"]
    """`Observation.index` of every frame, ascending."""
    T_W_B: Poses | None = None
    """Poses of the body in the SLAM's own world frame, which figures align with the true world frame."""
    labels: Int[np.ndarray, "n"] | None = None
    """Room label of every frame, as an index into the argument `room_names` of `SlamUnderTest.start`."""
    baseline_labels: Int[np.ndarray, "n"] | None = None
    """Labels before refinement, if the SLAM refines labels."""
    rooms: Int[np.ndarray, "n"] | None = None
    """Room instance of every frame, as a number from 0 that the SLAM chooses; -1 for a frame in no room."""
    floors: Int[np.ndarray, "n"] | None = None
    """Number of the floor, 0 for the lowest; -1 for a frame on stairs."""
    loops: LoopClaims | None = None
    candidates: tuple[tuple[int, tuple[int, ...]], ...] | None = None
    """Proposed revisits: for each query row, the rows of the frames that the query may revisit, the most similar first."""
    similarities: Float64[np.ndarray, "n names"] | None = None
    """Similarity of every frame with every room name; the report shows the largest."""
    encoder: str | None = None
    """Name of the vision-language model that was used."""
    stage_seconds: Mapping[str, float] = field(default_factory=lambda: _NO_SECONDS)
    """Wall time by stage [s]."""

    def __post_init__(self) -> None:
        n = len(self.frames)
        if n == 0 or (np.diff(self.frames) <= 0).any() or self.frames[0] < 0:
            raise SimError("estimate: frames must be one or more indices of observations, from 0 and ascending")
        for name in ("T_W_B", "labels", "baseline_labels", "rooms", "floors", "similarities"):
            claim = getattr(self, name)
            if claim is not None and len(claim) != n:
                raise SimError(f"estimate: {name} has {len(claim)} rows; valid: {n}, one for each of the frames")
            if claim is not None and not np.isfinite(claim).all():
                raise SimError(f"estimate: {name} is not finite in row {int(np.argwhere(~np.isfinite(claim))[0, 0])}")
        rows = [] if self.loops is None else [*self.loops.query.tolist(), *self.loops.match.tolist()]
        rows += [row for query, matches in self.candidates or () for row in (query, *matches)]
        if rows and not 0 <= min(rows) <= max(rows) < n:
            raise SimError(f"estimate: loops and candidates refer to rows {min(rows)} to {max(rows)}; valid: 0 to {n - 1}")

    def named_rooms(self, room_names: tuple[str, ...]) -> dict[int, str] | None:
        """The most frequent label of every room instance, by its number; None unless rooms and labels are claimed."""
        if self.rooms is None or self.labels is None:
            return None
        counts = {int(room): np.bincount(self.labels[self.rooms == room]) for room in np.unique(self.rooms) if room >= 0}
        return {room: room_names[int(np.argmax(count))] for room, count in counts.items()}
