"""Export of a map to the file formats of other tools: TUM, KITTI, g2o, JSON, SVG, Spark-DSG, Hydra and ROS."""

import json
from collections.abc import Callable, Mapping
from dataclasses import asdict
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from lexis.errors import LexisError, MapError
from lexis.files.g2o import TRANSLATION_FIRST
from lexis.files.replace import replaced_file
from lexis.files.tum_trajectory import write_tum
from lexis.map.interchange.hydra_rooms import write_hydra_rooms
from lexis.map.interchange.ros_map import write_ros_maps
from lexis.map.interchange.spark_dsg import write_spark_dsg
from lexis.map.picture import map_svg
from lexis.maths.se3 import between
from lexis.room_names import instance_names
from lexis.types import Covariance, LexisMap, Pose


def export_map(map: LexisMap, format: str, path: Path | str) -> None:
    """Write the map to a file in one of `FORMATS`, or to a folder for the format "ros".

    Raises LexisError if the format is unknown, the map cannot be written in the format, or writing fails.
    """
    if format not in FORMATS:
        raise LexisError(f"unknown format {format!r}; valid: {', '.join(FORMATS)}")
    FORMATS[format](map, Path(path))


def _tum(map: LexisMap, path: Path) -> None:
    """Write the optimised poses as lines of "stamp tx ty tz qx qy qz qw".

    Raises MapError if the stamps do not ascend, because readers of TUM files need that, `read_tum` included.
    """
    for a, b in pairwise(map.keyframes):
        if round(b.stamp, 6) <= round(a.stamp, 6):  # as they are written
            raise MapError(
                f"{path}: stamp {b.stamp:.6f} s of session {b.session} follows {a.stamp:.6f} s of session {a.session}, and "
                "the stamps of a TUM file ascend; valid: sessions of one clock, one after the other, or the format json"
            )
    write_tum(path, [keyframe.stamp for keyframe in map.keyframes], map.T_W_B)


def _kitti(map: LexisMap, path: Path) -> None:
    """Write the optimised poses: the upper three rows of each T_W_B in one line."""
    _write(path, [" ".join(f"{value:.9e}" for value in pose[:3].ravel()) for pose in map.T_W_B])


def _g2o(map: LexisMap, path: Path) -> None:
    """Write the pose graph: optimised vertices, odometry edges, and all loop edges whatever their robust weight."""
    vertices = [f"VERTEX_SE3:QUAT {i} {_pose(pose)}" for i, pose in enumerate(map.T_W_B)]
    pairs = pairwise(map.keyframes)
    steps = [_edge(a.id, b.id, between(a.T_O_B, b.T_O_B), b.step_covariance) for a, b in pairs if a.session == b.session]
    loops = [_edge(loop.match, loop.query, loop.T_match_query, loop.covariance) for loop in map.loops]
    _write(path, [*vertices, *steps, *loops])


def _json(map: LexisMap, path: Path) -> None:
    """Write rooms, keyframes, loops and loop candidates, for people and for scripts in other languages."""
    _write(path, [json.dumps(summary(map), indent=1)])


def _svg(map: LexisMap, path: Path) -> None:
    """Write a picture: the plan of every floor with keyframes, rooms and loop edges."""
    _write(path, [map_svg(map)])


FORMATS: dict[str, Callable[[LexisMap, Path], None]] = {
    "tum": _tum,
    "kitti": _kitti,
    "g2o": _g2o,
    "json": _json,
    "svg": _svg,
    "spark-dsg": write_spark_dsg,
    "hydra": write_hydra_rooms,
    "ros": write_ros_maps,
}


def summary(map: LexisMap) -> dict[str, Any]:
    """Return rooms, keyframes, loops and loop candidates as plain data for JSON.

    Positions are in W [m], and quaternions are in the order x, y, z, w.
    """
    names = instance_names(map.rooms)
    room_of = {i: name for room, name in zip(map.rooms, names, strict=True) for i in room.keyframes}
    quaternions = Rotation.from_matrix(map.T_W_B[:, :3, :3]).as_quat(canonical=True)
    keyframes = [
        {
            "id": i,
            "session": keyframe.session,
            "stamp_s": keyframe.stamp,
            "position_m": map.T_W_B[i, :3, 3].tolist(),
            "orientation_xyzw": quaternions[i].tolist(),
            "label": map.label_of(i),
            "probability": float(map.probabilities[i, map.labels[i]]),
            "room": room_of.get(i),
            "floor": int(map.floors[i]) if map.floors[i] >= 0 else None,
        }
        for i, keyframe in enumerate(map.keyframes)
    ]
    rooms = [
        {
            "name": name,
            "label": room.label,
            "probability": map.probability_of(room),
            "floor": room.floor,
            "mean_m": room.mean.tolist(),
            "keyframes": list(room.keyframes),
        }
        for room, name in zip(map.rooms, names, strict=True)
    ]
    loops = [
        {"query": loop.query, "match": loop.match, "inliers": loop.inliers, "weight": float(weight)}
        for loop, weight in zip(map.loops, map.loop_weights, strict=True)
    ]
    return {
        "schema": 1,
        "room_names": list(map.room_names),
        "rooms": rooms,
        "keyframes": keyframes,
        "loops": loops,
        "candidates": _candidates(map, room_of),
    }


def _candidates(map: LexisMap, room_of: Mapping[int, str]) -> list[dict[str, Any]]:
    """Return what became of every loop candidate in verification, with the figures that decided.

    Each candidate also has the room of the earlier keyframe, the similarity of the most similar images, and the final weight
    of its edge.
    """
    weights = {(loop.query, loop.match): float(w) for loop, w in zip(map.loops, map.loop_weights, strict=True)}
    embeddings = [keyframe.embeddings.astype(np.float64) for keyframe in map.keyframes]
    return [
        asdict(decision)
        | {
            "room": room_of.get(decision.match),
            "similarity": float((embeddings[decision.query] @ embeddings[decision.match].T).max()),
            "weight": weights.get((decision.query, decision.match)),
        }
        for decision in map.decisions
    ]


def _edge(a: int, b: int, T_a_b: Pose, covariance: Covariance) -> str:
    """Return a line EDGE_SE3:QUAT.

    Its information matrix is for tangent vectors in g2o's order, as GTSAM reads and writes them. (0.1 mrad)² and (0.1 mm)²
    are added to the variances, because exact odometry would have infinite information.
    """
    information = np.linalg.inv(covariance + 1e-8 * np.eye(6))[np.ix_(TRANSLATION_FIRST, TRANSLATION_FIRST)]
    upper = " ".join(f"{value:.9g}" for value in information[np.triu_indices(6)])
    return f"EDGE_SE3:QUAT {a} {b} {_pose(T_a_b)} {upper}"


def _pose(pose: Pose) -> str:
    quaternion = Rotation.from_matrix(pose[:3, :3]).as_quat(canonical=True)
    return " ".join(f"{value:.9f}" for value in (*pose[:3, 3], *quaternion))


def _write(path: Path, lines: list[str]) -> None:
    with replaced_file(path) as beside:
        beside.write_text("\n".join(lines) + "\n", encoding="utf-8")
