"""Export of a map as a scene graph in the JSON format of Spark-DSG.

`spark_dsg_format` describes how a map becomes layers, nodes and edges. The file is written without the library of Spark-DSG.
Tests load the file with the library, and read the file that the library saves again.
"""

import json
from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float64
from scipy.spatial import cKDTree

from lexis.files.camera import CameraData
from lexis.files.replace import replaced_file
from lexis.floors import NO_FLOOR, floor_numbers
from lexis.graph.components import sessions_of
from lexis.map.interchange.spark_dsg_format import AGENT, AGENTS, FLOOR, FLOORS, KEY, LAYERS, PLACE, PLACES, ROOM, ROOMS
from lexis.maths.quaternions import as_quaternions
from lexis.maths.se3 import transform
from lexis.maths.stretches import consecutive_pairs
from lexis.room_names import instance_names
from lexis.types import LexisMap

_HEADER = {"project_name": "lexis", "version": {"major": 1, "minor": 1, "patch": 3}}
_LAST_NS = 2**63 - 1
"""Largest time that a node can hold [ns], in the year 2262."""
_NO_LABEL = 2**32 - 1
_UPRIGHT = {"w": 1.0, "x": 0.0, "y": 0.0, "z": 0.0}
_Json = dict[str, Any]


def write_spark_dsg(map: LexisMap, path: Path) -> None:
    """Write the map as a scene graph. Raises LexisError if the file cannot be written.

    The graph leaves out key points, descriptors and landmarks, as `save_map` does without `features`.
    """
    with replaced_file(path) as beside:
        beside.write_text(json.dumps(scene_graph(map), separators=(",", ":"), allow_nan=False) + "\n", encoding="utf-8")


def scene_graph(map: LexisMap) -> _Json:
    """Return the scene graph of a map as plain data for JSON."""
    return {
        "SPARK_DSG_header": _HEADER,
        "directed": False,
        "multigraph": False,
        "layer_keys": [layer.key for layer in LAYERS],
        "layer_names": {layer.name: layer.key for layer in LAYERS},
        "metadata": _metadata(map),
        "nodes": [*_floors(map), *_rooms(map), *_places(map), *_agents(map)],
        "edges": [*_hierarchy(map), *_walk(map)],
    }


def _metadata(map: LexisMap) -> _Json:
    names = [[i, name] for i, name in enumerate(map.room_names)]
    others = [CameraData.of(other).model_dump(mode="json") for other in map.camera.others]
    own = {
        "schema": 2,
        "camera": CameraData.of(map.camera).model_dump(mode="json"),
        **({"other_cameras": others} if others else {}),
        "encoder": asdict(map.encoder),
        "room_names": list(map.room_names),
        "candidates": map.candidates,
        "decisions": [asdict(decision) for decision in map.decisions],
        "stage_seconds": map.stage_seconds,
    }
    spaces = {f"_l{layer.level}p{layer.partition}": names for layer in (ROOMS, PLACES)}
    return {"labelspaces": spaces, KEY: own}


def _floors(map: LexisMap) -> Iterator[_Json]:
    for floor in _floor_numbers(map):
        members = np.flatnonzero(map.floors == floor)
        points = map.T_W_B[members, :3, 3]
        semantic = _semantic(f"floor {floor}", _NO_LABEL, points)
        yield _node(FLOORS.node(floor), FLOORS.key, FLOOR, _centre(points), semantic, {"floor": floor})


def _floor_numbers(map: LexisMap) -> list[int]:
    """Return the numbers of all floors that have keyframes or rooms, ascending."""
    return sorted({*floor_numbers(map.floors), *(room.floor for room in map.rooms if room.floor is not None)})


def _rooms(map: LexisMap) -> Iterator[_Json]:
    for room, name in zip(map.rooms, instance_names(map.rooms), strict=True):
        label = map.room_names.index(room.label)
        semantic = _semantic(name, label, map.T_W_B[list(room.keyframes), :3, 3])
        more = semantic | {"semantic_class_probabilities": {}}
        yield _node(ROOMS.node(room.id), ROOMS.key, ROOM, room.mean, more, {"floor": room.floor})


def _places(map: LexisMap) -> Iterator[_Json]:
    clearances = _clearances(map)
    for i, keyframe in enumerate(map.keyframes):
        position = map.T_W_B[i, :3, 3]
        embedding = keyframe.embedding.astype(np.float64).tolist()
        more = {
            "semantic_feature": {"rows": len(embedding), "cols": 1, "data": embedding},
            "distance": float(clearances[i]),
            "num_basis_points": 0,
            "pcl_mesh_connections": [],
            "voxblox_mesh_connections": [],
            "deformation_connections": [],
            "mesh_vertex_labels": [],
            "real_place": True,
            "need_cleanup": False,
            "active_frontier": False,
            "anti_frontier": False,
            "frontier_scale": [0.0, 0.0, 0.0],
            "num_frontier_voxels": 0,
            "orientation": _UPRIGHT,
        }
        own = {
            "floor": None if map.floors[i] == NO_FLOOR else int(map.floors[i]),
            "baseline_label": int(map.baseline_labels[i]),
            "similarities": map.similarities[i].tolist(),
            "probabilities": map.probabilities[i].tolist(),
        }
        if keyframe.others:
            own["other_embeddings"] = [view.embedding.astype(np.float64).tolist() for view in keyframe.others]
        semantic = _semantic(f"keyframe {i}", int(map.labels[i]), position[None])
        yield _node(PLACES.node(i), PLACES.key, PLACE, position, semantic | more, own)


def _clearances(map: LexisMap) -> Float64[np.ndarray, "n"]:
    """Return the distance of every keyframe from the nearest landmark of any keyframe [m]; 0 if there are no landmarks."""
    points = [transform(T, keyframe.points) for T, keyframe in zip(map.T_W_B, map.keyframes, strict=True)]
    landmarks = np.concatenate(points)
    if not len(landmarks):
        return np.zeros(len(map.keyframes))
    return np.asarray(cKDTree(landmarks).query(map.T_W_B[:, :3, 3])[0])


def _agents(map: LexisMap) -> Iterator[_Json]:
    quaternions = as_quaternions(map.T_W_B[:, :3, :3]).tolist()
    for i, keyframe in enumerate(map.keyframes):
        more = {
            "timestamp": max(-_LAST_NS, min(round(keyframe.stamp * 1e9), _LAST_NS)),
            "world_R_body": dict(zip("xyzw", quaternions[i], strict=True)),
            "external_key": AGENTS.node(i),
            "dbow_ids": None,
            "dbow_values": None,
        }
        own = {
            "session": keyframe.session,
            "observation_index": keyframe.observation_index,
            "stamp": keyframe.stamp,
            "T_O_B": keyframe.T_O_B.tolist(),
            "step_covariance": keyframe.step_covariance.tolist(),
        }
        if keyframe.anchor is not None:
            own["anchor"] = keyframe.anchor
        yield _node(AGENTS.node(i), AGENTS.key, AGENT, map.T_W_B[i, :3, 3], more, own)


def _hierarchy(map: LexisMap) -> Iterator[_Json]:
    """Yield edges from floors to rooms, from rooms to places, and from places to agents."""
    for room in map.rooms:
        if room.floor is not None:
            yield _edge(FLOORS.node(room.floor), ROOMS.node(room.id))
        yield from (_edge(ROOMS.node(room.id), PLACES.node(i)) for i in room.keyframes)
    yield from (_edge(PLACES.node(i), AGENTS.node(i)) for i in range(len(map.keyframes)))


def _walk(map: LexisMap) -> Iterator[_Json]:
    """Yield edges between consecutive places, between rooms that follow each other on the walk, and between agents.

    The last keyframe of a session and the first keyframe of the next session are not consecutive. There is an edge
    between the agents of two keyframes if they are consecutive or a loop edge connects them. The edge's metadata hold all
    loop edges between the two keyframes.
    """
    steps = [(a, b) for a, b in consecutive_pairs(sessions_of(map.keyframes)).tolist()]
    yield from (_edge(PLACES.node(a), PLACES.node(b)) for a, b in steps)
    room_of = map.room_of.tolist()
    adjacent = {tuple(sorted((room_of[a], room_of[b]))) for a, b in steps if -1 != room_of[a] != room_of[b] != -1}
    yield from (_edge(ROOMS.node(a), ROOMS.node(b)) for a, b in sorted(adjacent))
    between: dict[tuple[int, int], list[_Json]] = {step: [] for step in steps}
    for order, (loop, weight) in enumerate(zip(map.loops, map.loop_weights.tolist(), strict=True)):
        arrays = {"T_match_query": loop.T_match_query.tolist(), "covariance": loop.covariance.tolist()}
        own = {"order": order, "query": loop.query, "match": loop.match, "inliers": loop.inliers, "weight": weight}
        between.setdefault((loop.match, loop.query), []).append(own | arrays)
    for (a, b), loops in between.items():
        yield _edge(AGENTS.node(a), AGENTS.node(b), max((loop["weight"] for loop in loops), default=1.0), {"loops": loops})


def _node(id: int, layer: dict[str, int], kind: str, position: Any, more: _Json, own: _Json) -> _Json:
    attributes = {
        "type": kind,
        "position": [float(value) for value in position],
        "last_update_time_ns": 0,
        "is_active": False,
        "is_predicted": False,
        "metadata": {KEY: own},
    }
    return {"id": id, **layer, "attributes": attributes | more}


def _semantic(name: str, label: int, points: Float64[np.ndarray, "k 3"]) -> _Json:
    """Return the attributes of a node with a name, a label and a bounding box, which is the box around `points`."""
    low, high = (points.min(axis=0), points.max(axis=0)) if len(points) else (np.zeros(3), np.zeros(3))
    box = {"dimensions": (high - low).tolist(), "world_P_center": ((low + high) / 2).tolist(), "world_R_center": _UPRIGHT}
    return {
        "name": name,
        "color": {"r": 0, "g": 0, "b": 0, "a": 255},
        "bounding_box": {"type": "AABB"} | box,
        "semantic_label": label,
        "semantic_feature": {"rows": 0, "cols": 0, "data": None},
    }


def _centre(points: Float64[np.ndarray, "k 3"]) -> Float64[np.ndarray, "3"]:
    return points.mean(axis=0) if len(points) else np.zeros(3)


def _edge(source: int, target: int, weight: float = 1.0, own: _Json | None = None) -> _Json:
    info = {"type": "EdgeAttributes", "weighted": True, "weight": weight, "metadata": {} if own is None else {KEY: own}}
    return {"source": source, "target": target, "info": info}
