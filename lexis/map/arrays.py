"""Conversion between a map and the flat arrays of `arrays.npz`.

Keyframes have different numbers of key points, and queries different numbers of candidates. Such rows are concatenated, and
a further array holds the counts. In `LAYOUT`, dimensions of the same name have the same size. Keyframes that have retired
have no row in `embedding`, because they share the embeddings of their anchors.
"""

from collections.abc import Iterable
from typing import TypeVar

import numpy as np
from jaxtyping import Int, Shaped

from lexis.errors import MapError
from lexis.files.arrays import Arrays, Layout
from lexis.inputs import MAX_POSITION_M, MAX_STAMP_S, NORM_TOLERANCE, is_invertible, usable_covariances
from lexis.map.other_views import pack_others, unpack_others
from lexis.maths.se3 import is_rigid
from lexis.types import (
    DESCRIPTOR_BYTES,
    LOOP_OUTCOMES,
    Features,
    Keyframe,
    Landmarks,
    LexisMap,
    LoopArrays,
    LoopDecision,
    LoopEdge,
)

LAYOUT: Layout = {
    "session": ("i8", ("keyframes",)),
    "observation_index": ("i8", ("keyframes",)),
    "stamp": ("f8", ("keyframes",)),
    "T_O_B": ("f8", ("keyframes", 4, 4)),
    "T_W_B": ("f8", ("keyframes", 4, 4)),
    "step_covariance": ("f8", ("keyframes", 6, 6)),
    "anchor": ("i8", ("keyframes",)),
    "embedding": ("f4", ("active", "d")),
    "similarities": ("f8", ("keyframes", "room_names")),
    "baseline_labels": ("i8", ("keyframes",)),
    "labels": ("i8", ("keyframes",)),
    "probabilities": ("f8", ("keyframes", "room_names")),
    "floors": ("i8", ("keyframes",)),
    "room_of": ("i8", ("keyframes",)),
    "room_mean": ("f8", ("rooms", 3)),
    "feature_count": ("i8", ("keyframes",)),
    "keypoints": ("f4", ("features", 2)),
    "descriptors": ("u1", ("features", "bytes")),
    "landmark_count": ("i8", ("keyframes",)),
    "landmark_points": ("f8", ("landmarks", 3)),
    "landmark_feature": ("i8", ("landmarks",)),
    "loop_query": ("i8", ("loops",)),
    "loop_match": ("i8", ("loops",)),
    "loop_pose": ("f8", ("loops", 4, 4)),
    "loop_covariance": ("f8", ("loops", 6, 6)),
    "loop_inliers": ("i8", ("loops",)),
    "loop_weight": ("f8", ("loops",)),
    "candidate_query": ("i8", ("queries",)),
    "candidate_count": ("i8", ("queries",)),
    "candidate_match": ("i8", ("candidates",)),
    "decision_pair": ("i8", ("decisions", 2)),
    "decision_outcome": ("i8", ("decisions",)),
    "decision_counts": ("i8", ("decisions", 3)),
    "decision_misfit": ("f8", ("decisions", 2)),
}
"""Type and shape of every array in `arrays.npz`."""

_COUNTED = {
    "feature": "keypoints",
    "landmark": "landmark_points",
    "candidate": "candidate_match",
    "other_feature": "other_keypoints",
    "other_landmark": "other_landmark_points",
}
"""For each array of counts, named without the ending `_count`, the array whose rows are counted: `feature_count` counts the
rows of `keypoints`."""
_NO_ANCHOR = -1
"""Anchor in the arrays of a keyframe that has not retired."""
_UNKNOWN = -1.0
"""Value in the arrays for a figure of a decision that was not determined."""
_Number = TypeVar("_Number", int, float)


def pack(map: LexisMap, features: bool) -> dict[str, Shaped[np.ndarray, "..."]]:
    """Convert a map to arrays; without `features`, the key points and landmarks of the keyframes are left out."""
    keyframes, loops = map.keyframes, LoopArrays.of(map.loops)
    seen = keyframes if features else ()
    nothing = np.zeros(len(keyframes))
    columns = {
        "session": [k.session for k in keyframes],
        "observation_index": [k.observation_index for k in keyframes],
        "stamp": [k.stamp for k in keyframes],
        "T_O_B": [k.T_O_B for k in keyframes],
        "T_W_B": map.T_W_B,
        "step_covariance": [k.step_covariance for k in keyframes],
        "anchor": [_NO_ANCHOR if k.anchor is None else k.anchor for k in keyframes],
        "embedding": [k.embedding for k in keyframes if k.anchor is None],
        "similarities": map.similarities,
        "baseline_labels": map.baseline_labels,
        "labels": map.labels,
        "probabilities": map.probabilities,
        "floors": map.floors,
        "room_of": map.room_of,
        "room_mean": [room.mean for room in map.rooms],
        "feature_count": [len(k.features.keypoints) for k in seen] if features else nothing,
        "keypoints": _joined([k.features.keypoints for k in seen], (0, 2)),
        "descriptors": _joined([k.features.descriptors for k in seen], (0, DESCRIPTOR_BYTES)),
        "landmark_count": [len(k.landmarks.points) for k in seen] if features else nothing,
        "landmark_points": _joined([k.landmarks.points for k in seen], (0, 3)),
        "landmark_feature": _joined([k.landmarks.feature_ids for k in seen], (0,)),
        "loop_query": loops.query,
        "loop_match": loops.match,
        "loop_pose": loops.T_match_query,
        "loop_covariance": loops.covariance,
        "loop_inliers": loops.inliers,
        "loop_weight": map.loop_weights,
        "candidate_query": [query for query, _ in map.candidates],
        "candidate_count": [len(matches) for _, matches in map.candidates],
        "candidate_match": [match for _, matches in map.candidates for match in matches],
        "decision_pair": [(d.query, d.match) for d in map.decisions],
        "decision_outcome": [LOOP_OUTCOMES.index(d.outcome) for d in map.decisions],
        "decision_counts": [_known((d.matches, d.inliers, d.cells)) for d in map.decisions],
        "decision_misfit": [_known((d.misfit_m, d.misfit_rad)) for d in map.decisions],
    }
    return {name: _as_laid_out(name, column) for name, column in columns.items()} | pack_others(keyframes, features)


def unpack_keyframes(arrays: Arrays) -> tuple[Keyframe, ...]:
    """Convert the arrays of a map back to keyframes. The arrays must have passed `check`."""
    keypoints = _split(arrays["keypoints"], arrays["feature_count"])
    descriptors = _split(arrays["descriptors"], arrays["feature_count"])
    points = _split(arrays["landmark_points"], arrays["landmark_count"])
    feature_ids = _split(arrays["landmark_feature"], arrays["landmark_count"])
    row_of = embedding_rows(arrays["anchor"])
    others = unpack_others(arrays, row_of)
    return tuple(
        Keyframe(
            id=i,
            observation_index=int(arrays["observation_index"][i]),
            stamp=float(arrays["stamp"][i]),
            T_O_B=arrays["T_O_B"][i],
            step_covariance=arrays["step_covariance"][i],
            embedding=arrays["embedding"][row_of[i]],
            features=Features(keypoints[i], descriptors[i]),
            landmarks=Landmarks(points[i], feature_ids[i]),
            session=int(arrays["session"][i]),
            others=others[i],
            anchor=None if arrays["anchor"][i] == _NO_ANCHOR else int(arrays["anchor"][i]),
        )
        for i in range(len(arrays["stamp"]))
    )


def embedding_rows(anchors: Int[np.ndarray, "n"]) -> Int[np.ndarray, "n"]:
    """Return the row of `embedding` for each keyframe: that of the keyframe itself or, if it has retired, of its anchor."""
    active = anchors == _NO_ANCHOR
    own = np.cumsum(active) - 1
    return np.asarray(np.where(active, own, own[anchors]))


def unpack_loops(arrays: Arrays) -> tuple[LoopEdge, ...]:
    """Convert the arrays of a map back to loop edges. The arrays must have passed `check`."""
    fields = (arrays[f"loop_{name}"] for name in ("query", "match", "pose", "covariance", "inliers"))
    return LoopArrays(*fields).edges()


def unpack_candidates(arrays: Arrays) -> tuple[tuple[int, tuple[int, ...]], ...]:
    """Convert the arrays of a map back to loop candidates: every query keyframe with the keyframes proposed for it.

    The arrays must have passed `check`.
    """
    matches = _split(arrays["candidate_match"], arrays["candidate_count"])
    return tuple((q, tuple(m.tolist())) for q, m in zip(arrays["candidate_query"].tolist(), matches, strict=True))


def unpack_decisions(arrays: Arrays) -> tuple[LoopDecision, ...]:
    """Convert the arrays of a map back to decisions on loop candidates. The arrays must have passed `check`."""
    columns = (arrays[f"decision_{name}"].tolist() for name in ("pair", "outcome", "counts", "misfit"))
    decisions = []
    for (query, match), outcome, counts, misfits in zip(*columns, strict=True):
        matches, inliers, cells = map(_if_known, counts)
        misfit_m, misfit_rad = map(_if_known, misfits)
        decisions.append(LoopDecision(query, match, LOOP_OUTCOMES[outcome], matches, inliers, cells, misfit_m, misfit_rad))
    return tuple(decisions)


def check(arrays: Arrays) -> None:
    """Raise MapError unless the values are finite and plausible, and all indices and counts fit the arrays they refer to.

    The arrays must have the types and shapes of `LAYOUT`.
    """
    for name, array in arrays.items():
        if array.dtype.kind == "f" and not np.isfinite(array).all():
            raise MapError(f"array {name} has values that are not finite")
    _check_references(arrays)
    _check_anchors(arrays)
    for name, counted in _COUNTED.items():
        if counted in arrays:
            _check_counts(arrays, name)
    for prefix in ("", "other_") if "other_embedding" in arrays else ("",):
        _check_embeddings(arrays, prefix)
        _check_descriptors(arrays, prefix)
        _check_landmarks(arrays, prefix)
    for name in ("T_O_B", "T_W_B", "loop_pose"):
        if not is_rigid(arrays[name], tolerance=1e-5).all():
            raise MapError(f"array {name} has a matrix that is no rigid motion")
    for name in ("T_O_B", "T_W_B", "loop_pose", "room_mean", "landmark_points", "other_landmark_points"):
        if np.abs(arrays.get(name, np.zeros(0))).max(initial=0.0) > MAX_POSITION_M:
            raise MapError(f"array {name} has a position beyond {MAX_POSITION_M:g} m; valid: positions on Earth")
    if np.abs(arrays["stamp"]).max(initial=0.0) > MAX_STAMP_S:
        raise MapError(f"array stamp has a time beyond {MAX_STAMP_S:g} s; valid: seconds of a usual clock")
    for name in ("step_covariance", "loop_covariance"):
        if not usable_covariances(arrays[name]).all():
            raise MapError(f"array {name} has a matrix that is no covariance; valid: symmetric, positive semi-definite ones")
    if not is_invertible(arrays["loop_covariance"]).all():
        raise MapError("array loop_covariance has a singular matrix; valid: covariances that are positive definite")


def _check_references(arrays: Arrays) -> None:
    n = len(arrays["stamp"])
    bounds = {
        "labels": (0, arrays["similarities"].shape[1]),
        "baseline_labels": (0, arrays["similarities"].shape[1]),
        "probabilities": (0.0, np.nextafter(1.0, 2.0)),
        "floors": (-1, n),
        "room_of": (-1, len(arrays["room_mean"])),
        "loop_query": (0, n),
        "loop_match": (0, n),
        "candidate_query": (0, n),
        "candidate_match": (0, n),
        "decision_pair": (0, n),
        "decision_outcome": (0, len(LOOP_OUTCOMES)),
        "decision_counts": (_UNKNOWN, np.inf),
        "decision_misfit": (_UNKNOWN, np.inf),
        "loop_weight": (0.0, np.nextafter(1.0, 2.0)),
    }
    for name, (low, high) in bounds.items():
        if ((arrays[name] < low) | (arrays[name] >= high)).any():
            raise MapError(f"array {name} has a value outside [{low}, {high})")
    if n < 1:
        raise MapError("the map has no keyframes; valid: at least one")
    steps = np.diff(arrays["session"], prepend=0)
    if ((steps != 0) & (steps != 1)).any() or arrays["session"][0]:
        raise MapError("array session does not count sessions; valid: 0, ..., 0, 1, ..., 1 and so on")
    if ((np.diff(arrays["stamp"]) <= 0) & (steps[1:] == 0)).any():
        raise MapError("array stamp does not ascend within a session")
    query, match = arrays["loop_query"], arrays["loop_match"]
    if (later := np.flatnonzero(match >= query)).size:
        i = later[0]
        raise MapError(f"loop {i} leads from keyframe {query[i]} to {match[i]}, which is not earlier; valid: an earlier one")


def _check_anchors(arrays: Arrays) -> None:
    """Raise MapError unless each anchor is an earlier keyframe that has not retired.

    The first keyframe of a session does not retire. The number of embeddings has to be that of the active keyframes.
    """
    anchors = arrays["anchor"]
    active = anchors == _NO_ANCHOR
    retired = np.flatnonzero(~active)
    if ((anchors[retired] < 0) | (anchors[retired] >= retired)).any() or not active[anchors[retired]].all():
        raise MapError("array anchor refers to a keyframe that is not earlier, or has retired itself; valid: an active one")
    if np.diff(arrays["session"], prepend=-1)[retired].any():
        raise MapError("array anchor has an anchor for the first keyframe of a session; valid: -1")
    for name in ("embedding", "other_embedding"):
        if name in arrays and len(arrays[name]) != active.sum():
            raise MapError(f"array {name} has {len(arrays[name])} rows; valid: {active.sum()}, one for each active keyframe")


def _check_embeddings(arrays: Arrays, prefix: str) -> None:
    """Raise MapError unless the embeddings have unit norm."""
    norms = np.linalg.norm(arrays[f"{prefix}embedding"].astype(np.float64), axis=-1)
    if (bad := np.argwhere(np.abs(norms - 1.0) > NORM_TOLERANCE)).size:
        raise MapError(f"array {prefix}embedding has norm {norms[tuple(bad[0])]:.3g} in row {bad[0, 0]}; valid: unit norm")


def _check_descriptors(arrays: Arrays, prefix: str) -> None:
    """Raise MapError unless the descriptors are as long as those of AKAZE."""
    columns = arrays[f"{prefix}descriptors"].shape[1]
    if columns != DESCRIPTOR_BYTES:
        raise MapError(f"array {prefix}descriptors has {columns} columns; valid: {DESCRIPTOR_BYTES}")


def _check_landmarks(arrays: Arrays, prefix: str) -> None:
    """Raise MapError unless each landmark refers to a feature of its own image, or to none (-1).

    `prefix` is "other_" for the images of the further cameras.
    """
    features, of_landmarks = arrays[f"{prefix}landmark_feature"], arrays[f"{prefix}landmark_count"]
    owners = np.repeat(arrays[f"{prefix}feature_count"].ravel(), of_landmarks.ravel())
    if (features >= owners).any() or (features < -1).any():
        raise MapError(f"array {prefix}landmark_feature refers to a feature that its image does not have")


def _check_counts(arrays: Arrays, name: str) -> None:
    """Raise MapError unless the counts per keyframe or query add up to the total number of items."""
    counts, total = arrays[f"{name}_count"], len(arrays[_COUNTED[name]])
    # Each count is bounded first, so that the sum of the counts cannot overflow.
    if ((counts < 0) | (counts > total)).any() or counts.sum() != total:
        raise MapError(f"array {name}_count does not add up to the {total} {name}s of the map")


def _as_laid_out(name: str, column: object) -> Shaped[np.ndarray, "..."]:
    kind, shape = LAYOUT[name]
    array = np.asarray(column, kind)
    # An array that numpy makes of an empty list has one dimension only.
    return array if array.ndim == len(shape) else array.reshape([s if isinstance(s, int) else 0 for s in shape])


def _known(values: Iterable[float | int | None]) -> list[float | int]:
    return [_UNKNOWN if value is None else value for value in values]


def _if_known(value: _Number) -> _Number | None:
    return None if value == _UNKNOWN else value


def _joined(parts: list[Shaped[np.ndarray, "..."]], empty: tuple[int, ...]) -> Shaped[np.ndarray, "..."]:
    return np.concatenate(parts) if parts else np.zeros(empty)


def _split(array: Shaped[np.ndarray, "..."], counts: Int[np.ndarray, "n"]) -> list[Shaped[np.ndarray, "..."]]:
    return np.split(array, np.cumsum(counts)[:-1]) if len(counts) else []
