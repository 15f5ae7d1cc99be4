"""The part of Spark-DSG's JSON format that holds a map: layers, identifiers of nodes, and models that check a file.

Spark-DSG is the library of 3-D scene graphs behind Hydra (https://github.com/MIT-SPARK/Spark-DSG; format of version 1.1). A
graph has layers of nodes, and edges within layers and between layers. A map of LEXIS becomes these layers:

- FLOORS: one node per floor. This layer is an addition of LEXIS; Spark-DSG has none for floors.
- ROOMS: one node per room instance, below its floor. Stairs are rooms without a floor.
- PLACES: one node per keyframe, with its label and the embedding of its image, below its room.
- AGENTS: one node per keyframe, with its pose and time, below its place.

Data for which the format has no field are in the metadata of nodes, edges and the graph, under the key `KEY`.
"""

from dataclasses import dataclass
from typing import Annotated, Generic, Literal, TypeVar

from pydantic import BaseModel, ConfigDict, Discriminator, Field, Tag

from lexis.files.camera import CameraData, Row
from lexis.files.models import STRICT, EncoderData, RoomNames
from lexis.inputs import MAX_CAMERAS, MAX_ROOM_NAMES
from lexis.types import LoopOutcome

KEY = "lexis"
"""Key of the data of LEXIS in the metadata of nodes, edges and the graph. `Tagged` has a field of this name."""
AGENT, PLACE, ROOM, FLOOR = "AgentNodeAttributes", "PlaceNodeAttributes", "RoomNodeAttributes", "SemanticNodeAttributes"
"""Types of node attributes in files, for agents, places, rooms and floors."""
_FEW, _MANY = 10_000, 1_000_000
_INDEX_BITS = 56
_Own = TypeVar("_Own")


@dataclass(frozen=True)
class Layer:
    """A layer of the graph. Several layers can have the same level; they differ in their partitions."""

    name: str
    level: int
    partition: int
    category: str
    """Letter with which the names of the layer's nodes begin."""

    @property
    def key(self) -> dict[str, int]:
        """The layer's level and partition, by which files refer to the layer."""
        return {"layer": self.level, "partition": self.partition}

    def node(self, index: int) -> int:
        """Return a node's identifier, which Spark-DSG prints as the letter of the layer and the index, for example R3."""
        return (ord(self.category) << _INDEX_BITS) | index

    def index(self, node: int) -> int | None:
        """Return the index of a node in this layer; None if the node is in another layer."""
        return node & ((1 << _INDEX_BITS) - 1) if node >> _INDEX_BITS == ord(self.category) else None


AGENTS = Layer("AGENTS", 2, ord("a"), "a")
PLACES = Layer("PLACES", 3, 0, "p")
ROOMS = Layer("ROOMS", 4, 0, "R")
FLOORS = Layer("FLOORS", 5, 1, "F")
LAYERS = (AGENTS, PLACES, ROOMS, FLOORS)

_OPEN = ConfigDict(frozen=True, extra="ignore", allow_inf_nan=False)
"""Configuration of models for data that Spark-DSG defines. Unknown fields are ignored, because later versions may add
fields."""
Vector = tuple[float, float, float]
Matrix4 = tuple[Row, Row, Row, Row]
Row6 = tuple[float, float, float, float, float, float]
Matrix6 = tuple[Row6, Row6, Row6, Row6, Row6, Row6]
Id = Annotated[int, Field(ge=0, lt=_MANY)]
Count = Annotated[int, Field(ge=0, lt=2**62)]
NodeId = Annotated[int, Field(ge=0, lt=2**64)]


class DecisionData(BaseModel):
    """A decision on a loop candidate; see `lexis.types.LoopDecision`."""

    model_config = STRICT

    query: Id
    match: Id
    outcome: LoopOutcome
    matches: Count | None = None
    inliers: Count | None = None
    cells: Count | None = None
    misfit_m: float | None = None
    misfit_rad: float | None = None


class GraphData(BaseModel):
    """Data of a map besides its keyframes, rooms and edges."""

    model_config = STRICT

    schema_version: Literal[2] = Field(alias="schema")
    camera: CameraData
    other_cameras: tuple[CameraData, ...] = Field((), max_length=MAX_CAMERAS - 1)
    """The further cameras of a rig. Files of a single camera do not state them."""
    encoder: EncoderData
    room_names: RoomNames
    candidates: tuple[tuple[Id, tuple[Id, ...]], ...] = Field(max_length=_MANY)
    decisions: tuple[DecisionData, ...] = Field(max_length=100 * _MANY)
    stage_seconds: dict[str, float] = Field(max_length=100)


class AgentData(BaseModel):
    """Data of a keyframe besides its optimised pose: its session, the odometry, and the exact time of its image [s]."""

    model_config = STRICT

    session: Id = 0
    """Number of the recording session, from 0; in a file that states none, all keyframes are of one session."""
    observation_index: Annotated[int, Field(ge=-(2**62), lt=2**62)]
    stamp: float
    T_O_B: Matrix4
    step_covariance: Matrix6
    anchor: Id | None = None
    """Id of the keyframe that shows this keyframe's place. Only keyframes that have retired have this field."""


class PlaceData(BaseModel):
    """Data from which a keyframe's label was derived, and the number of the keyframe's floor; None on stairs."""

    model_config = STRICT

    floor: Id | None
    baseline_label: Id
    similarities: tuple[float, ...] = Field(max_length=MAX_ROOM_NAMES)
    probabilities: tuple[Annotated[float, Field(ge=0, le=1)], ...] = Field(max_length=MAX_ROOM_NAMES)
    other_embeddings: tuple[tuple[float, ...], ...] = Field((), max_length=MAX_CAMERAS - 1)
    """Embeddings of the images of the further cameras of a rig. Files of a single camera do not state them."""


class RoomData(BaseModel):
    """Number of a room's floor; None for stairs."""

    model_config = STRICT

    floor: Id | None


class LoopData(BaseModel):
    """A loop edge. Two keyframes may have several loop edges."""

    model_config = STRICT

    order: Id
    """Position of the edge among the loop edges of the map, from 0."""
    query: Id
    match: Id
    T_match_query: Matrix4
    covariance: Matrix6
    inliers: Count
    weight: float


class EdgeData(BaseModel):
    """The loop edges between two keyframes."""

    model_config = STRICT

    loops: tuple[LoopData, ...] = Field(max_length=_FEW)


class QuaternionData(BaseModel):
    """A rotation as a quaternion."""

    model_config = _OPEN

    w: float
    x: float
    y: float
    z: float


class FeatureData(BaseModel):
    """A vector, as a matrix with one column."""

    model_config = _OPEN

    data: tuple[float, ...] = Field(max_length=_FEW)
    rows: Id
    cols: Literal[1]


class Tagged(BaseModel, Generic[_Own]):
    """Metadata that contain data of LEXIS. Data of other programs may stand beside these and are ignored."""

    model_config = _OPEN

    lexis: _Own


class AgentAttributes(BaseModel):
    """Attributes of a node of the layer AGENTS."""

    model_config = _OPEN

    position: Vector
    world_R_body: QuaternionData
    metadata: Tagged[AgentData]


class PlaceAttributes(BaseModel):
    """Attributes of a node of the layer PLACES."""

    model_config = _OPEN

    semantic_label: Id
    semantic_feature: FeatureData
    metadata: Tagged[PlaceData]


class RoomAttributes(BaseModel):
    """Attributes of a node of the layer ROOMS."""

    model_config = _OPEN

    position: Vector
    semantic_label: Id
    metadata: Tagged[RoomData]


class OtherAttributes(BaseModel):
    """Attributes of a node that is not needed to read a map: a floor, or a node that another program has added."""

    model_config = _OPEN


def _kind(attributes: object) -> str:
    """Return the tag of the model for a node's attributes: their type, or "other"."""
    kind = attributes.get("type") if isinstance(attributes, dict) else None
    return kind if kind in (AGENT, PLACE, ROOM) else "other"


Attributes = Annotated[
    Annotated[AgentAttributes, Tag(AGENT)]
    | Annotated[PlaceAttributes, Tag(PLACE)]
    | Annotated[RoomAttributes, Tag(ROOM)]
    | Annotated[OtherAttributes, Tag("other")],
    Discriminator(_kind),
]


class NodeFile(BaseModel):
    """A node of the graph."""

    model_config = _OPEN

    id: NodeId
    attributes: Attributes


class MaybeTagged(BaseModel):
    """Metadata that may hold the data of loop edges."""

    model_config = _OPEN

    lexis: EdgeData | None = None


class EdgeInfo(BaseModel):
    """Attributes of an edge."""

    model_config = _OPEN

    metadata: MaybeTagged = MaybeTagged()


class EdgeFile(BaseModel):
    """An edge between two nodes. If the nodes are of two levels, it leads from the parent to the child."""

    model_config = _OPEN

    source: NodeId
    target: NodeId
    info: EdgeInfo = EdgeInfo()


class GraphFile(BaseModel):
    """A scene graph that holds a map."""

    model_config = _OPEN

    metadata: Tagged[GraphData]
    nodes: tuple[NodeFile, ...] = Field(max_length=_MANY)
    edges: tuple[EdgeFile, ...] = Field(max_length=10 * _MANY)
