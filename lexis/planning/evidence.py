"""Evidence that a place lies in a room: how much the images that show the place resemble the room's name.

In the paper, an image describes the place where it was taken. This is misleading where rooms are open to one another: in
front of an open boundary, the whole image shows the next room.
"""

import numpy as np
from jaxtyping import Float64, Int
from scipy.spatial import cKDTree

from lexis.graph.thinning import are_active
from lexis.maths.ties import rounded
from lexis.sight.cameras import mean
from lexis.types import LexisMap

LOOK_AHEAD_M = 1.5
"""Assumed distance from a camera to the place that its image shows [m]. The image describes that place, which is ahead of
the camera, rather than the camera's own place."""
EVIDENCE_REACH_M = 2.0
"""An image counts as evidence for a place if what the image shows is within this distance of the place [m]. The distance
must exceed `LOOK_AHEAD_M`, so that at the position of every keyframe that has not retired, at least its own image counts."""


def evidence_at(map: LexisMap, label: str, keyframes: Int[np.ndarray, "k"]) -> Float64[np.ndarray, "k"]:
    """Return the evidence that keyframes stand in a room with the label, rounded. It decreases towards the room's boundary.

    Evidence is the similarity of the keyframe's place to the room's name, minus the largest similarity to another room name.
    The similarity of a place is the weighted mean over the images that show the place. The images of a retired keyframe are
    those of its anchor, and do not count again. A place that no image shows has the similarity of the nearest image.
    """
    similarities = _similarities_at(map, map.T_W_B[keyframes, :3, 3])
    column = map.room_names.index(label)
    others = np.delete(similarities, column, axis=1).max(axis=1, initial=-1.0)
    return rounded(similarities[:, column] - others)


def shown_places(map: LexisMap) -> Float64[np.ndarray, "n 3"]:
    """Return the place that every keyframe's image shows: ahead of the camera, at the keyframe's height, in W [m].

    With several cameras, it is the mean of the places ahead of them, as similarities are means over the cameras.
    """
    places, ahead = map.T_W_B[:, :3, 3].copy(), mean([camera.T_B_C[:3, 2] for camera in map.camera.rig])
    places[:, :2] += LOOK_AHEAD_M * (map.T_W_B[:, :3, :3] @ ahead)[:, :2]
    return places


def _similarities_at(map: LexisMap, places: Float64[np.ndarray, "k 3"]) -> Float64[np.ndarray, "k rooms"]:
    active = are_active(map.keyframes)
    shown, similarities = shown_places(map)[active], map.similarities[active]
    tree = cKDTree(shown)
    near_images = tree.query_ball_point(places, EVIDENCE_REACH_M, return_sorted=True)
    found = similarities[tree.query(places)[1]]
    for row, (place, near) in enumerate(zip(places, near_images, strict=True)):
        weights = _distance_weights(shown[near] - place)
        if weights.any():
            found[row] = np.average(similarities[near], axis=0, weights=weights)
    return np.asarray(found)


def _distance_weights(offsets: Float64[np.ndarray, "k 3"]) -> Float64[np.ndarray, "k"]:
    """Return weights of images by the distance of the place they show: 1 at distance 0, and 0 from `EVIDENCE_REACH_M` on."""
    return np.asarray(np.maximum(1.0 - (offsets**2).sum(axis=1) / EVIDENCE_REACH_M**2, 0.0) ** 2)
