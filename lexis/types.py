"""The data that flows through LEXIS: frozen, with shapes, units and frames spelled out.

Frames: ``W`` world (z up), ``O`` odometry, ``B`` body (x forward, y left, z up), ``C`` camera (OpenCV: x right,
y down, z forward). ``T_a_b`` maps coordinates in ``b`` to ``a``: ``p_a = T_a_b @ p_b``. Covariances of poses are
6x6, **rotation first** as in GTSAM, of a perturbation on the right: ``T = T_mean @ Exp(xi)``.
"""

from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float32, Float64, Int, UInt8

Pose = Float64[np.ndarray, "4 4"]
Poses = Float64[np.ndarray, "n 4 4"]
Image = UInt8[np.ndarray, "h w 3"]
Covariance = Float64[np.ndarray, "6 6"]


@dataclass(frozen=True)
class Intrinsics:
    """A pinhole without distortion; the centre of the top-left pixel is (0, 0). All in [px]."""

    width: int
    height: int
    fx: float
    fy: float
    cx: float
    cy: float

    @property
    def matrix(self) -> Float64[np.ndarray, "3 3"]:
        """The calibration matrix K."""
        return np.array([[self.fx, 0.0, self.cx], [0.0, self.fy, self.cy], [0.0, 0.0, 1.0]])


@dataclass(frozen=True, eq=False)
class Camera:
    """Intrinsics and the camera's place on the body, ``T_B_C``."""

    intrinsics: Intrinsics
    T_B_C: Pose


@dataclass(frozen=True, eq=False)
class Features:
    """AKAZE key points of one image."""

    keypoints: Float32[np.ndarray, "n 2"]
    """[px], x right and y down."""
    descriptors: UInt8[np.ndarray, "n bytes"]


@dataclass(frozen=True, eq=False)
class Percept:
    """What was seen in an image where it was taken: by a camera that encodes on board, or by a simulated one."""

    embedding: Float32[np.ndarray, "d"]
    """f_CLIP, unit norm, of the encoder that LEXIS reads room names with."""
    features: Features
    """f_AKAZE; none is a valid answer."""


@dataclass(frozen=True, eq=False)
class Observation:
    """All that LEXIS is given at one instant: an image and an odometry estimate (paper, Sec. III)."""

    index: int
    stamp: float
    """Time of the image [s]."""
    image: Image | Percept
    """RGB; or, where nobody sends images, what was seen in it."""
    T_O_B: Pose
    """The odometry's estimate of the body; it drifts."""
    increment_covariance: Covariance
    """What the odometry believes of the error it made since the previous observation [rad², m²]."""


@dataclass(frozen=True, eq=False)
class Landmarks:
    """Triangulated 3-D points of one keyframe."""

    points: Float64[np.ndarray, "m 3"]
    """In the keyframe's body frame B [m]."""
    feature_ids: Int[np.ndarray, "m"]
    """Row of the keyframe's features that each point was triangulated from."""


@dataclass(frozen=True, eq=False)
class Keyframe:
    """A node of the graph: where odometry put it, what it saw, and the CLIP embedding of that."""

    id: int
    """Position in the sequence of keyframes, from 0."""
    observation_index: int
    stamp: float
    """[s]"""
    T_O_B: Pose
    step_covariance: Covariance
    """Of the odometry since the previous keyframe [rad², m²]."""
    embedding: Float32[np.ndarray, "d"]
    """f_CLIP, unit norm."""
    features: Features
    """f_AKAZE."""
    landmarks: Landmarks


@dataclass(frozen=True, eq=False)
class LoopEdge:
    """A verified loop closure between two keyframes."""

    query: int
    """Id of the later keyframe."""
    match: int
    """Id of the earlier keyframe."""
    T_match_query: Pose
    covariance: Covariance
    """[rad², m²]"""
    inliers: int
    """Landmarks that agree with the pose."""


@dataclass(frozen=True, eq=False)
class RoomInstance:
    """A cluster of keyframes that LEXIS holds to be one room, such as "office 2" (paper, Sec. III-C)."""

    id: int
    label: str
    keyframes: tuple[int, ...]
    """Ids, ascending."""
    mean: Float64[np.ndarray, "3"]
    """Mean position in W [m]."""
    floor: int | None
    """0 is the lowest; None for stairs."""


@dataclass(frozen=True)
class EncoderId:
    """The model that made embeddings: only those of equal fingerprints can be compared."""

    name: str
    """What to ask `load_encoder` for."""
    fingerprint: str


@dataclass(frozen=True, eq=False)
class LexisMap:
    """The output: a semantically segmented pose graph (paper, Fig. 2). Arrays are indexed by keyframe id."""

    camera: Camera
    encoder: EncoderId
    """Of the keyframes' embeddings."""
    room_names: tuple[str, ...]
    """The vocabulary that labels index into."""
    keyframes: tuple[Keyframe, ...]
    T_W_B: Poses
    """Optimised poses."""
    similarities: Float64[np.ndarray, "n rooms"]
    """Cosine similarity of every image with every room prompt (Eq. 1)."""
    baseline_labels: Int[np.ndarray, "n"]
    """Before refinement: the prompt with the largest similarity."""
    labels: Int[np.ndarray, "n"]
    """After refinement."""
    floors: Int[np.ndarray, "n"]
    """0 is the lowest; -1 on stairs."""
    rooms: tuple[RoomInstance, ...]
    loops: tuple[LoopEdge, ...]
    loop_weights: Float64[np.ndarray, "loops"]
    """The robust kernel's final weight of every loop edge, in [0, 1]."""
    candidates: tuple[tuple[int, tuple[int, ...]], ...]
    """For every query keyframe, the keyframes proposed to verification, best first."""
    stage_seconds: dict[str, float] = field(default_factory=dict)
    """Wall time by stage [s]."""

    @property
    def room_of(self) -> Int[np.ndarray, "n"]:
        """Id of the room instance of every keyframe; -1 for one that is in none."""
        room_of = np.full(len(self.keyframes), -1)
        for room in self.rooms:
            room_of[list(room.keyframes)] = room.id
        return room_of

    def label_of(self, keyframe: int) -> str:
        """The room name of a keyframe."""
        return self.room_names[int(self.labels[keyframe])]
