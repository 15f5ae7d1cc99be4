"""`PlaceMethod`: the interface of all methods of place recognition, and the evidence about keyframes that they are given."""

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
from jaxtyping import Bool, Float16, Float32, Float64, UInt8

Scores = Float64[np.ndarray, "n n"] | Float32[np.ndarray, "n n"]
"""Score of every keyframe (columns) as a match for every query (rows); -inf: the keyframe is not proposed to this query."""


@dataclass(frozen=True, eq=False)
class SeenKeyframes:
    """The keyframes of a walk in their order, as methods of place recognition see them; no truth is among it.

    In arrays of n x n, rows are queries and columns are earlier keyframes.
    """

    embeddings: Float32[np.ndarray, "n d"]
    """Embeddings of the images by the vision-language model, with unit norm."""
    orb: tuple[UInt8[np.ndarray, "_ 32"], ...]
    """ORB descriptors of every image, those of the strongest key points first."""
    akaze: tuple[UInt8[np.ndarray, "_ 61"], ...]
    """AKAZE descriptors of every image, as LEXIS computes them to verify loops."""
    patches: tuple[Float16[np.ndarray, "_ channels"], ...]
    """Patch features of every image by the encoder `mini`, with unit norm."""
    eligible: Bool[np.ndarray, "n n"]
    """Whether each keyframe is old enough to be proposed to each query; see `lexis.place_recognition.old_enough`."""
    estimated_m: Float64[np.ndarray, "n n"]
    """Distances between keyframes by the pose graph of LEXIS at the time of the query [m]; infinite for later keyframes."""
    estimated_rad: Float64[np.ndarray, "n n"]
    """Angles between keyframes by the pose graph of LEXIS at the time of the query [rad]; infinite for later keyframes."""
    active: Bool[np.ndarray, "n n"]
    """Whether LEXIS still proposes each keyframe at the time of each query. One that others can replace retires."""
    in_room: Bool[np.ndarray, "n n"]
    """Whether each keyframe is in the room that the paper searches for each query: the closest room with its label.
    Keyframes that are not active are left out."""

    def only_eligible(self, scores: Scores) -> Scores:
        """Return the scores, with -inf for keyframes that are not old enough to be proposed."""
        return np.where(self.eligible, scores, -np.inf)


@runtime_checkable
class PlaceMethod(Protocol):
    """A method that ranks earlier keyframes as matches for every keyframe of a walk."""

    def scores(self, seen: SeenKeyframes) -> Scores:
        """Score the eligible keyframes for every query. A row depends on keyframes up to its query only."""
        ...
