"""Conversion between the views of a rig's further cameras and the flat arrays of `arrays.npz`.

A map of a single camera has none of these arrays. Otherwise, there is one view for each keyframe and further camera, in the
order of the keyframes, and for each keyframe in the order of the cameras.
"""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Int, Shaped

from lexis.files.arrays import Arrays, Layout
from lexis.types import DESCRIPTOR_BYTES, CameraView, Features, Keyframe, Landmarks

LAYOUT: Layout = {
    "other_embedding": ("f4", ("active", "others", "d")),
    "other_feature_count": ("i8", ("keyframes", "others")),
    "other_keypoints": ("f4", ("other_features", 2)),
    "other_descriptors": ("u1", ("other_features", "other_bytes")),
    "other_landmark_count": ("i8", ("keyframes", "others")),
    "other_landmark_points": ("f8", ("other_landmarks", 3)),
    "other_landmark_feature": ("i8", ("other_landmarks",)),
}
"""Type and shape of every array of the further cameras."""


def pack_others(keyframes: Sequence[Keyframe], features: bool) -> dict[str, Shaped[np.ndarray, "..."]]:
    """Convert the views of further cameras to arrays; without `features`, key points and landmarks are left out."""
    views = [view for keyframe in keyframes for view in keyframe.others]
    if not views:
        return {}
    seen = views if features else []
    per_view = len(keyframes), len(keyframes[0].others)
    columns = {
        "other_embedding": np.array([[view.embedding for view in k.others] for k in keyframes if k.anchor is None]),
        "other_feature_count": np.reshape([len(view.features.keypoints) * features for view in views], per_view),
        "other_keypoints": np.concatenate([np.zeros((0, 2)), *(view.features.keypoints for view in seen)]),
        "other_descriptors": _joined([view.features.descriptors for view in seen]),
        "other_landmark_count": np.reshape([len(view.landmarks.points) * features for view in views], per_view),
        "other_landmark_points": np.concatenate([np.zeros((0, 3)), *(view.landmarks.points for view in seen)]),
        "other_landmark_feature": np.concatenate([np.zeros(0), *(view.landmarks.feature_ids for view in seen)]),
    }
    return {name: np.asarray(column, LAYOUT[name][0]) for name, column in columns.items()}


def unpack_others(arrays: Arrays, row_of: Int[np.ndarray, "n"]) -> list[tuple[CameraView, ...]]:
    """Convert the arrays back to the views of further cameras, a tuple for each keyframe. The arrays must be checked.

    `row_of` holds the row of every keyframe in `other_embedding`.
    """
    count = len(arrays["stamp"])
    if "other_embedding" not in arrays:
        return [()] * count
    embeddings = arrays["other_embedding"]
    features = np.cumsum(arrays["other_feature_count"])[:-1]
    landmarks = np.cumsum(arrays["other_landmark_count"])[:-1]
    columns = (
        [embedding for row in row_of.tolist() for embedding in embeddings[row]],
        np.split(arrays["other_keypoints"], features),
        np.split(arrays["other_descriptors"], features),
        *(np.split(arrays[f"other_landmark_{name}"], landmarks) for name in ("points", "feature")),
    )
    views = [
        CameraView(embedding, Features(keypoints, descriptors), Landmarks(points, ids))
        for embedding, keypoints, descriptors, points, ids in zip(*columns, strict=True)
    ]
    others = embeddings.shape[1]
    return [tuple(views[i * others : (i + 1) * others]) for i in range(count)]


def _joined(parts: Sequence[Shaped[np.ndarray, "_ bytes"]]) -> Shaped[np.ndarray, "m bytes"]:
    return np.concatenate(parts) if parts else np.zeros((0, DESCRIPTOR_BYTES))
