"""Import of a map from a scene graph that `spark_dsg` wrote, also after Spark-DSG has loaded and saved it.

Other programs may have changed the graph. Poses, labels, embeddings and the keyframes of each room are therefore read from
the graph's own fields. Everything else is read from the metadata.
"""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TypeVar

import numpy as np

from lexis.errors import MapError
from lexis.files.reading import FileKind, read_model
from lexis.floors import NO_FLOOR
from lexis.inputs import check_camera, check_room_names
from lexis.map.arrays import check, pack
from lexis.map.interchange.spark_dsg_format import (
    AGENTS,
    PLACES,
    ROOMS,
    AgentAttributes,
    EdgeFile,
    GraphData,
    GraphFile,
    Layer,
    LoopData,
    PlaceAttributes,
    RoomAttributes,
)
from lexis.maths.quaternions import poses_of
from lexis.types import (
    NO_FEATURES,
    NO_LANDMARKS,
    CameraView,
    EncoderId,
    Keyframe,
    LexisMap,
    LoopDecision,
    LoopEdge,
    Poses,
    RoomInstance,
)

_FILE = FileKind(
    "a scene graph written by 'lexis export --format spark-dsg'", 400_000_000, MapError, unusable="no scene graph of a map"
)
_UNIT = 1e-6
"""Largest deviation of a quaternion's norm from 1."""
_Attributes = TypeVar("_Attributes")


def read_spark_dsg(path: Path) -> LexisMap:
    """Read a map from a scene graph; its keyframes have no key points or landmarks. Raises MapError for anything else."""
    file = read_model(path, _FILE, GraphFile)
    try:
        lexis_map = _map(file)
        check_camera(lexis_map.camera)
        check_room_names(lexis_map.room_names)
        check(pack(lexis_map, features=False))
    except ValueError as error:  # LexisError and its subclasses are ValueErrors
        raise _FILE.refusal(path, error) from None
    return lexis_map


def _map(file: GraphFile) -> LexisMap:
    own = file.metadata.lexis
    agents = _in_order(file, AGENTS, AgentAttributes)
    places = _in_order(file, PLACES, PlaceAttributes)
    if len(agents) != len(places):
        raise MapError(f"{len(agents)} nodes a and {len(places)} nodes p; valid: one of each for every keyframe")
    _check_lengths(places, len(own.room_names), len(own.other_cameras))
    loops = _loops(file.edges)
    return LexisMap(
        camera=own.camera.camera(own.other_cameras),
        encoder=EncoderId(own.encoder.name, own.encoder.fingerprint),
        room_names=own.room_names,
        keyframes=tuple(_keyframe(i, *attributes) for i, attributes in enumerate(zip(agents, places, strict=True))),
        T_W_B=_poses(agents),
        similarities=np.array([place.metadata.lexis.similarities for place in places], float),
        baseline_labels=np.array([place.metadata.lexis.baseline_label for place in places], int),
        labels=np.array([place.semantic_label for place in places], int),
        probabilities=np.array([place.metadata.lexis.probabilities for place in places], float),
        floors=np.array([_floor(place.metadata.lexis.floor) for place in places], int),
        rooms=_rooms(file, own, len(places)),
        loops=tuple(_loop(loop) for loop in loops),
        loop_weights=np.array([loop.weight for loop in loops], float),
        candidates=own.candidates,
        decisions=tuple(LoopDecision(**vars(decision)) for decision in own.decisions),
        stage_seconds=own.stage_seconds,
    )


def _in_order(file: GraphFile, layer: Layer, kind: type[_Attributes]) -> list[_Attributes]:
    """Return the attributes of a layer's nodes, in the order of the nodes' indices.

    Raises MapError unless the indices are 0, 1 and so on, each once, and all attributes are of the type `kind`.
    """
    found = [(index, node.attributes) for node in file.nodes if (index := layer.index(node.id)) is not None]
    nodes = dict(found)
    missing = [i for i in range(len(nodes)) if not isinstance(nodes.get(i), kind)]
    if missing:
        name = f"{layer.category}{missing[0]}"
        raise MapError(f"node {name} is missing or has other attributes; valid: one node for each of {layer.name} from 0")
    if len(nodes) < len(found):
        repeated, _ = Counter(index for index, _ in found).most_common(1)[0]
        raise MapError(f"node {layer.category}{repeated} is there twice; valid: each node once")
    return [attributes for i in range(len(nodes)) if isinstance(attributes := nodes[i], kind)]


def _check_lengths(places: Sequence[PlaceAttributes], room_names: int, others: int) -> None:
    """Raise MapError unless all keyframes have one embedding for each camera, and figures for every room name.

    All embeddings need the same length. `others` is the number of the further cameras.
    """
    for i, place in enumerate(places):
        feature, wanted = place.semantic_feature, places[0].semantic_feature.rows
        if not len(feature.data) == feature.rows == wanted:
            found = f"an embedding of {len(feature.data)} numbers in {feature.rows} rows"
            raise MapError(f"node p{i} has {found}; valid: {wanted}, as p0")
        if {len(other) for other in place.metadata.lexis.other_embeddings} - {wanted}:
            raise MapError(f"node p{i} has other_embeddings of other lengths; valid: {wanted}, as the embedding")
        if len(place.metadata.lexis.other_embeddings) != others:
            count = len(place.metadata.lexis.other_embeddings)
            raise MapError(f"node p{i} has {count} other_embeddings; valid: {others}, one for each of other_cameras")
        for name in ("similarities", "probabilities"):
            if (count := len(getattr(place.metadata.lexis, name))) != room_names:
                raise MapError(f"node p{i} has {count} {name}; valid: {room_names}")


def _keyframe(i: int, agent: AgentAttributes, place: PlaceAttributes) -> Keyframe:
    own = agent.metadata.lexis
    first, *others = (
        _view(embedding) for embedding in (place.semantic_feature.data, *place.metadata.lexis.other_embeddings)
    )
    return Keyframe(
        id=i,
        observation_index=own.observation_index,
        stamp=own.stamp,
        T_O_B=np.array(own.T_O_B),
        step_covariance=np.array(own.step_covariance),
        embedding=first.embedding,
        features=first.features,
        landmarks=first.landmarks,
        session=own.session,
        others=tuple(others),
        anchor=own.anchor,
    )


def _view(embedding: Sequence[float]) -> CameraView:
    """Return the view of a camera of which only the embedding is known."""
    with np.errstate(over="ignore"):  # what is too large becomes infinite, and is refused later
        single = np.array(embedding).astype(np.float32)
    return CameraView(single, NO_FEATURES, NO_LANDMARKS)


def _poses(agents: Iterable[AgentAttributes]) -> Poses:
    rotations = np.array([[q.x, q.y, q.z, q.w] for q in (agent.world_R_body for agent in agents)], float).reshape(-1, 4)
    with np.errstate(over="ignore"):
        bent = np.flatnonzero(~(np.abs(np.linalg.norm(rotations, axis=1) - 1.0) <= _UNIT))
    if bent.size:
        raise MapError(f"node a{bent[0]} has a rotation that is no unit quaternion; valid: norm 1 within {_UNIT:g}")
    return poses_of(np.column_stack([np.array([agent.position for agent in agents], float).reshape(-1, 3), rotations]))


def _floor(floor: int | None) -> int:
    return NO_FLOOR if floor is None else floor


def _rooms(file: GraphFile, own: GraphData, keyframes: int) -> tuple[RoomInstance, ...]:
    rooms, members = _in_order(file, ROOMS, RoomAttributes), _members(file.edges, keyframes)
    found = []
    for i, room in enumerate(rooms):
        if i not in members or room.semantic_label >= len(own.room_names):
            raise MapError(f"room R{i} has no keyframe, or a label that is not among room_names")
        label = own.room_names[room.semantic_label]
        found.append(RoomInstance(i, label, tuple(sorted(members[i])), np.array(room.position), room.metadata.lexis.floor))
    if beyond := set(members) - set(range(len(rooms))):
        raise MapError(f"an edge leads from R{min(beyond)}, which is no node; valid: R0 to R{len(rooms) - 1}")
    return tuple(found)


def _members(edges: Iterable[EdgeFile], keyframes: int) -> Mapping[int, list[int]]:
    """Return the keyframes of every room, by the edges from rooms to places.

    Raises MapError if an edge leads to a place that is no keyframe, or a keyframe is in two rooms.
    """
    room_of: dict[int, int] = {}
    for edge in edges:
        room, place = ROOMS.index(edge.source), PLACES.index(edge.target)
        if room is None or place is None:
            continue
        if place >= keyframes or room_of.setdefault(place, room) != room:
            raise MapError(f"p{place} is no keyframe, or is in two rooms; valid: one of {keyframes} keyframes, in one room")
    members: dict[int, list[int]] = {}
    for place, room in room_of.items():
        members.setdefault(room, []).append(place)
    return members


def _loops(edges: Iterable[EdgeFile]) -> list[LoopData]:
    """Return the loop edges that the edges of the graph hold, in the order in which the map had them."""
    lists = [edge.info.metadata.lexis.loops for edge in edges if edge.info.metadata.lexis is not None]
    return sorted((loop for loops in lists for loop in loops), key=lambda loop: loop.order)


def _loop(loop: LoopData) -> LoopEdge:
    return LoopEdge(loop.query, loop.match, np.array(loop.T_match_query), np.array(loop.covariance), loop.inliers)
