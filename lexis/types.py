"""The data types that the stages of LEXIS exchange: frozen dataclasses with shapes, units and frames.

Frames: ``W`` world (z up), ``O`` odometry (z up), ``B`` body, ``C`` camera (OpenCV: x right, y down, z forward). The body
frame of the simulator has x forward, y left and z up, but other data has other axes: ``Camera.T_B_C`` tells where the camera
looks. ``T_a_b`` maps coordinates in ``b`` to ``a``: ``p_a = T_a_b @ p_b``. Covariances of poses are
6x6, **rotation first** as in GTSAM, for a perturbation on the right: ``T = T_mean @ Exp(xi)``.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from typing import Literal, get_args

import numpy as np
from jaxtyping import Float32, Float64, Int, UInt8

Pose = Float64[np.ndarray, "4 4"]
Poses = Float64[np.ndarray, "n 4 4"]
Positions = Float64[np.ndarray, "n 3"]
PerKeyframe = Int[np.ndarray, "n"]
"""One whole number for every keyframe, such as its label or its floor."""
Pairs = Int[np.ndarray, "m 2"]
"""Ids of two keyframes, one pair a row."""
Image = UInt8[np.ndarray, "h w 3"]
Covariance = Float64[np.ndarray, "6 6"]
DESCRIPTOR_BYTES = 61
"""Length of an AKAZE descriptor, in bytes."""


@dataclass(frozen=True)
class Intrinsics:
    """Intrinsics of a pinhole camera without distortion [px]; the centre of the top-left pixel is (0, 0)."""

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
    """A camera: its intrinsics and its pose on the body, ``T_B_C``; with `others`, the first camera of a rig."""

    intrinsics: Intrinsics
    T_B_C: Pose
    others: tuple["Camera", ...] = ()
    """The further cameras of the rig, which have no `others` themselves."""

    @property
    def rig(self) -> tuple["Camera", ...]:
        """All cameras of the rig: this camera and the others."""
        return self, *self.others

    def copy(self) -> "Camera":
        """Return a camera with copies of all poses, because the owner of the original may write into them."""
        return Camera(self.intrinsics, self.T_B_C.copy(), tuple(other.copy() for other in self.others))


@dataclass(frozen=True, eq=False)
class Features:
    """AKAZE key points and descriptors of one image."""

    keypoints: Float32[np.ndarray, "n 2"]
    """Image coordinates, x right and y down [px]."""
    descriptors: UInt8[np.ndarray, "n bytes"]
    """Binary descriptors of `DESCRIPTOR_BYTES` bytes."""


@dataclass(frozen=True, eq=False)
class Percept:
    """An embedding and features sent in place of an image, by a camera that encodes on board or by a simulated camera."""

    embedding: Float32[np.ndarray, "d"]
    """Embedding of the image with unit norm (f_CLIP in the paper), made by the encoder that also encodes the room names."""
    features: Features
    """AKAZE features of the image (f_AKAZE in the paper). There may be none."""
    points: Float64[np.ndarray, "m 3"] = field(default_factory=lambda: np.zeros((0, 3)))
    """Points on the surfaces in view, in the body frame B [m], as a depth camera measures them. There may be none."""


@dataclass(frozen=True, eq=False)
class Observation:
    """The input of LEXIS at one instant: an image and an odometry estimate (paper, Sec. III)."""

    index: int
    """Number of the observation, by which maps and messages name it."""
    stamp: float
    """Time of the image [s]."""
    image: Image | Percept
    """RGB image, or a percept where the image itself is not sent."""
    T_O_B: Pose
    """Pose of the body as estimated by the odometry, which drifts."""
    increment_covariance: Covariance
    """Covariance of the odometry's motion estimate since the previous observation, as stated by the odometry [rad², m²]."""
    others: tuple[Image | Percept, ...] = ()
    """Images of the further cameras at the same time, in the order of `Camera.others`. A SLAM may ignore them."""

    @property
    def images(self) -> tuple[Image | Percept, ...]:
        """The images of all cameras, in the order of `Camera.rig`."""
        return self.image, *self.others

    def with_images(self, images: Iterable[Image | Percept]) -> "Observation":
        """Return the observation with other images, in the order of `Camera.rig`."""
        image, *others = images
        return replace(self, image=image, others=tuple(others))


@dataclass(frozen=True, eq=False)
class Landmarks:
    """Triangulated 3-D points of one image."""

    points: Float64[np.ndarray, "m 3"]
    """Positions in the keyframe's body frame B [m]."""
    feature_ids: Int[np.ndarray, "m"]
    """For each point, the row of its key point in the image's features. It is -1 if the point comes from a `Percept`, whose
    points have no key points."""


NO_FEATURES = Features(np.zeros((0, 2), np.float32), np.zeros((0, DESCRIPTOR_BYTES), np.uint8))
NO_LANDMARKS = Landmarks(np.zeros((0, 3)), np.zeros(0, int))


@dataclass(frozen=True, eq=False)
class CameraView:
    """What one camera of a keyframe saw."""

    embedding: Float32[np.ndarray, "d"]
    """CLIP embedding of the image (f_CLIP in the paper), with unit norm."""
    features: Features
    """AKAZE features of the image (f_AKAZE in the paper)."""
    landmarks: Landmarks


@dataclass(frozen=True, eq=False)
class Keyframe:
    """A node of the pose graph: its odometry pose, the CLIP embedding and features of its image, and landmarks.

    The image is that of the first camera; what further cameras of a rig saw is in `others`.
    """

    id: int
    """Position in the sequence of keyframes, from 0."""
    observation_index: int
    stamp: float
    """Time of the image [s]."""
    T_O_B: Pose
    step_covariance: Covariance
    """Covariance of the odometry's motion estimate since the previous keyframe [rad², m²]."""
    embedding: Float32[np.ndarray, "d"]
    """CLIP embedding of the image (f_CLIP in the paper), with unit norm."""
    features: Features
    """AKAZE features of the image (f_AKAZE in the paper)."""
    landmarks: Landmarks
    session: int = 0
    """Number of the recording session, from 0. Each session has an odometry frame O of its own."""
    others: tuple[CameraView, ...] = ()
    """What the further cameras saw, in the order of `Camera.others`."""
    anchor: int | None = None
    """Id of an earlier keyframe that shows the same place, if this keyframe has retired from the pose graph; see
    `lexis.graph.thinning`. This keyframe then has the embeddings of its anchor, and neither features nor landmarks."""

    @property
    def views(self) -> tuple[CameraView, ...]:
        """What all cameras saw, in the order of `Camera.rig`."""
        return CameraView(self.embedding, self.features, self.landmarks), *self.others

    @property
    def embeddings(self) -> Float32[np.ndarray, "cameras d"]:
        """CLIP embeddings of the images of all cameras."""
        return np.stack([view.embedding for view in self.views])

    @property
    def points(self) -> Float64[np.ndarray, "k 3"]:
        """Positions of the landmarks of all cameras in the body frame B [m]."""
        return np.concatenate([view.landmarks.points for view in self.views])


@dataclass(frozen=True, eq=False)
class LoopEdge:
    """A verified loop closure between two keyframes."""

    query: int
    """Id of the later keyframe."""
    match: int
    """Id of the earlier keyframe."""
    T_match_query: Pose
    covariance: Covariance
    """Covariance of ``T_match_query`` [rad², m²]."""
    inliers: int
    """Number of key points in the later keyframe's images that lie where `T_match_query` predicts them."""


LoopOutcome = Literal[
    "accepted", "few matches", "few inliers", "crowded inliers", "uncertain pose", "far from the estimate", "surplus",
    "unconfirmed", "contradicted", "unsupported",
]  # fmt: skip
"""What became of a loop candidate. Inliers are crowded if they cover too little of the image. A pose is uncertain in two
cases. (1) Its standard deviation is large, and it differs from the current estimate, or no estimate relates the two
keyframes. (2) The inliers cover little of the image, and the rotation differs from the current estimate. A candidate is
surplus if enough others of the same query have more inliers. It is unconfirmed if a simulated verifier rejects it without a
reason. It is contradicted if other loops of the same query, with at least as many inliers in all, lead to another pose. It
is unsupported if it leads to a session that shares no frame with the query, and too few keyframes agree with it to join
both.
"""
LOOP_OUTCOMES: tuple[LoopOutcome, ...] = get_args(LoopOutcome)
"""Saved maps contain the positions of outcomes in this list, so a new outcome belongs at its end."""


@dataclass(frozen=True)
class LoopDecision:
    """What became of one loop candidate in verification, and the figures that decided. None: not determined."""

    query: int
    """Id of the new keyframe."""
    match: int
    """Id of the earlier keyframe that was proposed."""
    outcome: LoopOutcome
    matches: int | None = None
    """Number of key points in the new keyframe's images that match a landmark."""
    inliers: int | None = None
    """Number of key points that agree with the relative pose."""
    cells: int | None = None
    """Number of cells of a 6 x 6 grid on the image that contain an inlier; with several cameras, the largest number."""
    misfit_m: float | None = None
    """Distance between the measured position of the new keyframe and its position in the estimate at that time [m].
    Keyframes that share no frame have no such distance.

    A loop may be refused for its difference in height although this distance is within its limit."""
    misfit_rad: float | None = None
    """Angle between the measured rotation of the new keyframe and its rotation in the estimate when the candidate was
    verified [rad]."""


@dataclass(frozen=True, eq=False)
class LoopArrays:
    """Loop edges as arrays: one array for each field of `LoopEdge`, with one row for each edge."""

    query: Int[np.ndarray, "m"]
    match: Int[np.ndarray, "m"]
    T_match_query: Float64[np.ndarray, "m 4 4"]
    covariance: Float64[np.ndarray, "m 6 6"]
    """Covariances of `T_match_query` [rad², m²]."""
    inliers: Int[np.ndarray, "m"]

    @staticmethod
    def of(edges: Sequence[LoopEdge]) -> "LoopArrays":
        """Stack the fields of `edges` into arrays."""
        return LoopArrays(
            np.array([edge.query for edge in edges], int),
            np.array([edge.match for edge in edges], int),
            np.array([edge.T_match_query for edge in edges], float).reshape(-1, 4, 4),
            np.array([edge.covariance for edge in edges], float).reshape(-1, 6, 6),
            np.array([edge.inliers for edge in edges], int),
        )

    def edges(self) -> tuple[LoopEdge, ...]:
        """Convert the arrays back to loop edges. Poses and covariances are views of the arrays, not copies."""
        numbers = zip(self.query.tolist(), self.match.tolist(), self.inliers.tolist(), strict=True)
        return tuple(
            LoopEdge(query, match, self.T_match_query[i], self.covariance[i], inliers)
            for i, (query, match, inliers) in enumerate(numbers)
        )


@dataclass(frozen=True, eq=False)
class RoomInstance:
    """A cluster of keyframes that represents one room, such as "office 2" (paper, Sec. III-C)."""

    id: int
    label: str
    keyframes: tuple[int, ...]
    """Ids of the room's keyframes, ascending."""
    mean: Float64[np.ndarray, "3"]
    """Mean position of the keyframes in W [m]."""
    floor: int | None
    """Floor number: 0 for the lowest floor, None for stairs."""


@dataclass(frozen=True)
class EncoderId:
    """Identity of the model that made embeddings. Only embeddings of models with equal fingerprints can be compared."""

    name: str
    """Argument with which `load_encoder` loads the model."""
    fingerprint: str
    """Hash of the model's weights and preprocessing."""


@dataclass(frozen=True, eq=False)
class LexisMap:
    """The output of LEXIS: a semantically segmented pose graph (paper, Fig. 2). Axes `n` are indexed by keyframe id."""

    camera: Camera
    encoder: EncoderId
    """The model that made the keyframes' embeddings."""
    room_names: tuple[str, ...]
    """All names that a room can have. Labels are indices into this tuple."""
    keyframes: tuple[Keyframe, ...]
    T_W_B: Poses
    """Optimised poses of the keyframes. Sessions that no loop edge connects to the first one lie beside it along x, because
    their place is unknown."""
    similarities: Float64[np.ndarray, "n rooms"]
    """Cosine similarity of every keyframe's image with every entry of `room_names` (paper, Eq. 1). With several cameras, it
    is the mean over their images."""
    baseline_labels: Int[np.ndarray, "n"]
    """Labels of the keyframes before refinement: for each keyframe, the index of the room name with the largest entry of
    `similarities`."""
    labels: Int[np.ndarray, "n"]
    """Labels of the keyframes after refinement, as indices into `room_names`."""
    probabilities: Float64[np.ndarray, "n rooms"]
    """How probable it is that the room around each keyframe has each of `room_names`, from the images that show the place.
    The probabilities are calibrated on generated houses for the label method "sight". A keyframe on a climb is on stairs
    with probability 1. Other methods give their own label the probability 1. Where a label is corrected, because it
    changes in a doorway, a small room is absorbed, or two rooms merge, the old and the new label exchange theirs."""
    floors: Int[np.ndarray, "n"]
    """Floor number of every keyframe: 0 for the lowest floor, -1 on stairs."""
    rooms: tuple[RoomInstance, ...]
    """All room instances; the id of each is its index here."""
    loops: tuple[LoopEdge, ...]
    loop_weights: Float64[np.ndarray, "loops"]
    """Weight of every loop edge under the robust kernel at the final poses, in [0, 1]. An edge that fits badly has a small
    weight."""
    candidates: tuple[tuple[int, tuple[int, ...]], ...]
    """Pairs of a new keyframe's id and the ids of the earlier keyframes proposed as its loop candidates, best first."""
    decisions: tuple[LoopDecision, ...] = ()
    """What became of the candidates, in the order of `candidates`. A verifier may leave the decisions out."""
    stage_seconds: dict[str, float] = field(default_factory=dict)
    """Wall time spent in each stage of the pipeline [s], by the stage's name."""

    @property
    def room_of(self) -> Int[np.ndarray, "n"]:
        """Id of the room instance of every keyframe; -1 for a keyframe that belongs to no room."""
        room_of = np.full(len(self.keyframes), -1)
        for room in self.rooms:
            room_of[list(room.keyframes)] = room.id
        return room_of

    def probability_of(self, room: RoomInstance) -> float:
        """Return the probability that the label of a room is right, which is the mean over its keyframes."""
        return float(self.probabilities[list(room.keyframes), self.room_names.index(room.label)].mean())

    def label_of(self, keyframe: int) -> str:
        """Return the room name of a keyframe."""
        return self.room_names[int(self.labels[keyframe])]
