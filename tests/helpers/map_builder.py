"""Small maps for tests, with the contents that LEXIS gives them: keyframes along a walk through rooms."""

from dataclasses import replace

import numpy as np
from scipy.special import softmax

from lexis.graph.thinning import as_retired
from lexis.types import (
    Camera,
    CameraView,
    EncoderId,
    Features,
    Intrinsics,
    Keyframe,
    Landmarks,
    LexisMap,
    LoopDecision,
    LoopEdge,
    RoomInstance,
)

CAMERA = Camera(Intrinsics(480, 360, 200.0, 200.0, 239.5, 179.5), np.eye(4))

ENCODER = EncoderId("test", "0" * 64)


def random_pose(rng, position):
    """A pose at a position, with a random rotation about z."""
    yaw = rng.uniform(-np.pi, np.pi)
    pose = np.eye(4)
    pose[:2, :2] = [[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]]
    pose[:3, 3] = position
    return pose


def covariance(rng):
    """A random symmetric positive definite 6 x 6 matrix."""
    root = rng.normal(0.0, 0.01, (6, 6))
    return root @ root.T + 1e-4 * np.eye(6)


def view(rng, n):
    """What a camera saw: n features, of which every other one is a landmark."""
    features = Features(rng.uniform(0, 360, (n, 2)).astype(np.float32), rng.integers(0, 256, (n, 61), dtype=np.uint8))
    ids = np.arange(0, n, 2)
    embedding = rng.normal(size=16).astype(np.float32)
    embedding /= np.linalg.norm(embedding)
    return CameraView(embedding, features, Landmarks(rng.normal(size=(len(ids), 3)), ids))


def keyframe(rng, i, pose):
    """A keyframe with a few features, of which every other one is a landmark. Every fifth keyframe has no features."""
    seen = view(rng, 0 if i % 5 == 4 else int(rng.integers(1, 8)))
    return Keyframe(i, 5 * i, 0.5 * i, pose, covariance(rng), seen.embedding, seen.features, seen.landmarks)


def accepted(query, match):
    """The decision on a loop candidate that became an edge."""
    return LoopDecision(query, match, "accepted", matches=40, inliers=20, cells=7, misfit_m=0.25, misfit_rad=0.125)


def few(query, match):
    """The decision on a loop candidate without enough matches."""
    return LoopDecision(query, match, "few matches", matches=3)


def build_map(positions, labels, rooms, room_names, rng, loops=(), weights=(), refused=()):
    """A map of keyframes at positions (n, 3) with labels (n,) and rooms, a list of (label, keyframes).

    The keyframes `refused` are candidates without enough matches for all queries.
    """
    positions = np.asarray(positions, float)
    poses = np.stack([random_pose(rng, p) for p in positions])
    similarities = rng.uniform(0.0, 0.1, (len(labels), len(room_names)))
    similarities[np.arange(len(labels)), labels] += 0.5
    instances = tuple(
        RoomInstance(i, label, tuple(members), positions[list(members)].mean(axis=0), 0)
        for i, (label, members) in enumerate(rooms)
    )
    return LexisMap(
        camera=CAMERA,
        encoder=ENCODER,
        room_names=tuple(room_names),
        keyframes=tuple(keyframe(rng, i, pose) for i, pose in enumerate(poses)),
        T_W_B=poses,
        similarities=similarities,
        baseline_labels=np.array(labels),
        labels=np.array(labels),
        probabilities=softmax(similarities / 0.05, axis=1),
        floors=np.zeros(len(labels), int),
        rooms=instances,
        loops=tuple(LoopEdge(q, m, random_pose(rng, (0.1, 0, 0)), covariance(rng), 20) for q, m in loops),
        loop_weights=np.array(weights, float),
        candidates=tuple((q, (m, *refused)) for q, m in loops),
        decisions=tuple(decision for q, m in loops for decision in (accepted(q, m), *(few(q, other) for other in refused))),
        stage_seconds={"encode": 1.5},
    )


def corridor_with_offices(rng, **changes):
    """A map of a corridor along x with two offices beside it; 40 keyframes, half a metre apart."""
    x = np.concatenate([np.arange(0, 5, 0.5), np.full(5, 5.0), np.full(5, 5.2), np.arange(5.2, 10, 0.5), np.full(10, 10.0)])
    y = np.concatenate(
        [np.zeros(10), np.arange(0.5, 3, 0.5), np.arange(2.5, 0, -0.5), np.zeros(10), np.arange(0.5, 5.5, 0.5)]
    )
    positions = np.stack([x, y, np.zeros(40)], axis=1)
    labels = np.repeat([0, 1, 0, 1], [10, 10, 10, 10])
    members = [("corridor", [*range(10), *range(20, 30)]), ("office", range(10, 20)), ("office", range(30, 40))]
    return build_map(positions, labels, members, ("corridor", "office", "kitchen"), rng, **changes)


def with_retired(lexis_map, anchors):
    """The map with some keyframes that have retired; `anchors` holds the ids of their anchors by their own ids."""
    keyframes = lexis_map.keyframes
    thinned = tuple(as_retired(k, keyframes[anchors[k.id]]) if k.id in anchors else k for k in keyframes)
    return replace(lexis_map, keyframes=thinned)


def with_retired_copies(lexis_map, id, copies):
    """The map after so many further visits of the place of one keyframe, which have retired and follow this keyframe."""
    rows = np.append(np.arange(len(lexis_map.keyframes)), np.full(copies, id))
    arrays = ("T_W_B", "similarities", "baseline_labels", "labels", "probabilities", "floors")
    members = [tuple(np.flatnonzero(np.isin(rows, room.keyframes)).tolist()) for room in lexis_map.rooms]
    repeated = replace(
        lexis_map,
        keyframes=tuple(replace(lexis_map.keyframes[row], id=new) for new, row in enumerate(rows.tolist())),
        rooms=tuple(replace(room, keyframes=own) for room, own in zip(lexis_map.rooms, members, strict=True)),
        **{name: getattr(lexis_map, name)[rows] for name in arrays},
    )
    return with_retired(repeated, dict.fromkeys(range(len(lexis_map.keyframes), len(rows)), id))


def with_rear_camera(lexis_map, rng):
    """The map as if it came from a rig with a second camera, which looks back. Every third of its images has no features."""
    backwards = Camera(CAMERA.intrinsics, np.diag([-1.0, -1.0, 1.0, 1.0]))
    others = [(view(rng, 0 if i % 3 == 2 else int(rng.integers(1, 8))),) for i in range(len(lexis_map.keyframes))]
    keyframes = (replace(k, others=seen) for k, seen in zip(lexis_map.keyframes, others, strict=True))
    return replace(lexis_map, camera=replace(CAMERA, others=(backwards,)), keyframes=tuple(keyframes))
