"""Settings: one frozen dataclass per stage, with defaults that run; `Config` holds them all.

Every class checks itself, so that a bad value is refused where it is written and not in the middle of a run.
"""

from dataclasses import dataclass, field

from lexis.errors import ConfigError


def _require(holds: bool, setting: str, value: object, valid: str) -> None:
    if not holds:
        raise ConfigError(f"{setting} is {value}; valid: {valid}")


@dataclass(frozen=True)
class KeyframeConfig:
    """Which observations enter the graph (paper, Sec. III-A)."""

    spacing_m: float = 0.5
    """Odometry path between keyframes [m]."""
    rotation_rad: float | None = None
    """Also take a keyframe after turning this far [rad]; None (the paper) goes by distance alone."""
    support_spacing_m: float = 0.25
    """Odometry path between support frames, which only serve to triangulate landmarks [m]."""
    supports: int = 2
    """Support frames used on either side of a keyframe."""

    def __post_init__(self) -> None:
        """Raise ConfigError where a value cannot work."""
        _require(self.spacing_m > 0, "keyframes.spacing_m", self.spacing_m, "> 0 m")
        if self.rotation_rad is not None:
            _require(self.rotation_rad > 0, "keyframes.rotation_rad", self.rotation_rad, "> 0 rad, or None")
        _require(self.support_spacing_m > 0, "keyframes.support_spacing_m", self.support_spacing_m, "> 0 m")
        _require(self.supports >= 1, "keyframes.supports", self.supports, ">= 1")


@dataclass(frozen=True)
class LandmarkConfig:
    """AKAZE features, and the 3-D points triangulated from them by RGB and odometry."""

    akaze_threshold: float = 3e-4
    """Detector response; OpenCV's 1e-3 leaves too few key points on plain walls."""
    max_features: int = 600
    """Strongest key points kept per image."""
    epipolar_px: float = 2.5
    """Largest distance of a match from its epipolar line [px]."""
    ratio: float = 0.8
    """Lowe's ratio of the best to the second-best Hamming distance."""
    max_hamming: int = 120
    """Largest distance of two matched descriptors, of 486 bits."""
    min_views: int = 3
    """Images that must agree on a landmark, the keyframe's included."""
    min_parallax_rad: float = 0.026
    """Smallest angle between the outermost rays of a landmark [rad]; 1.5 degrees."""
    max_reprojection_px: float = 1.5
    """Largest reprojection error in any view [px]."""

    def __post_init__(self) -> None:
        """Raise ConfigError where a value cannot work."""
        _require(self.akaze_threshold > 0, "landmarks.akaze_threshold", self.akaze_threshold, "> 0")
        _require(self.max_features >= 8, "landmarks.max_features", self.max_features, ">= 8")
        _require(self.epipolar_px > 0, "landmarks.epipolar_px", self.epipolar_px, "> 0 px")
        _require(0 < self.ratio <= 1, "landmarks.ratio", self.ratio, "(0, 1]")
        _require(0 < self.max_hamming <= 488, "landmarks.max_hamming", self.max_hamming, "1 to 488 bits")
        _require(self.min_views >= 2, "landmarks.min_views", self.min_views, ">= 2")
        _require(0 < self.min_parallax_rad < 1, "landmarks.min_parallax_rad", self.min_parallax_rad, "(0, 1) rad")
        _require(self.max_reprojection_px > 0, "landmarks.max_reprojection_px", self.max_reprojection_px, "> 0 px")


@dataclass(frozen=True)
class LabelConfig:
    """Label refinement and stairs (paper, Sec. III-B)."""

    refine: bool = True
    """Whether neighbours vote and height finds the stairs; without, every keyframe keeps its image's label."""
    neighbours: int = 5
    """C: the nearest keyframes that vote (paper: 3 to 7)."""
    every: int = 9
    """K: new keyframes between two refinements at most (paper: 7 to 12); an optimisation brings one as well."""
    stairs_name: str = "stairs"
    """The room name that height change assigns; without it in the vocabulary, stairs are not sought."""
    stairs_window_m: float = 2.0
    """Path over which height change is measured, centred on the keyframe [m]."""
    stairs_min_height_m: float = 0.5
    """Height change over the window that makes a keyframe one on stairs [m]."""

    def __post_init__(self) -> None:
        """Raise ConfigError where a value cannot work."""
        _require(self.neighbours >= 1, "labels.neighbours", self.neighbours, ">= 1 (paper: 3 to 7)")
        _require(self.every >= 1, "labels.every", self.every, ">= 1 (paper: 7 to 12)")
        _require(bool(self.stairs_name), "labels.stairs_name", repr(self.stairs_name), "a room name")
        _require(self.stairs_window_m > 0, "labels.stairs_window_m", self.stairs_window_m, "> 0 m")
        _require(self.stairs_min_height_m > 0, "labels.stairs_min_height_m", self.stairs_min_height_m, "> 0 m")


@dataclass(frozen=True)
class SegmentationConfig:
    """Clusters of keyframes and floors (paper, Sec. III-C)."""

    distance_m: float = 3.0
    """A keyframe joins a cluster of its label whose mean is at most this far [m]."""
    adjacency_m: float = 1.5
    """Same-label clusters merge when keyframes of both come this close with no other room between them [m]; those of
    consecutive keyframes merge however far these are."""
    stairs_name: str = "stairs"
    """The label that separates floors."""

    def __post_init__(self) -> None:
        """Raise ConfigError where a value cannot work."""
        _require(self.distance_m > 0, "segmentation.distance_m", self.distance_m, "> 0 m")
        _require(self.adjacency_m > 0, "segmentation.adjacency_m", self.adjacency_m, "> 0 m")
        _require(bool(self.stairs_name), "segmentation.stairs_name", repr(self.stairs_name), "a room name")


@dataclass(frozen=True)
class PlaceRecognitionConfig:
    """Loop candidates from the query's room (paper, Sec. III-D)."""

    candidates: int = 5
    """Keyframes proposed to verification per query."""
    min_gap_s: float = 10.0
    """Keyframes more recent than this are not candidates [s]."""
    min_gap_m: float = 5.0
    """Neither are those less path behind than this [m]."""

    def __post_init__(self) -> None:
        """Raise ConfigError where a value cannot work."""
        _require(self.candidates >= 0, "place_recognition.candidates", self.candidates, ">= 0 (0: no loop closures)")
        _require(self.min_gap_s >= 0, "place_recognition.min_gap_s", self.min_gap_s, ">= 0 s")
        _require(self.min_gap_m >= 0, "place_recognition.min_gap_m", self.min_gap_m, ">= 0 m")


@dataclass(frozen=True)
class VerificationConfig:
    """Geometric verification by PnP (paper, Sec. III-D)."""

    pool: int = 2
    """Neighbours on either side of the candidate whose landmarks join its own."""
    ratio: float = 0.8
    """Lowe's ratio of the best to the second-best Hamming distance."""
    max_reprojection_px: float = 3.0
    """Largest reprojection error of an inlier [px]."""
    min_inliers: int = 15
    """Distinct key points of the query that must agree."""
    min_cells: int = 5
    """Cells of a 6 x 6 grid on the image that the inliers must reach."""
    gate_m: float = 0.5
    """Constant part of the distance that a loop may lie from the current estimate [m]."""
    gate_share: float = 0.03
    """Part that grows with the path since the candidate [m/m]."""
    gate_rad: float = 0.1
    """Constant part of the angle that a loop may be turned from the current estimate [rad]."""
    gate_rad_m: float = 0.005
    """Part that grows with the path since the candidate [rad/m]."""
    max_edges: int = 3
    """Loop edges kept per query, best first."""
    pixel_sigma: float = 1.5
    """Standard deviation of an inlier's reprojection error, landmark noise included [px]."""
    rotation_sigma_rad: float = 0.005
    """Added in quadrature to a loop edge's standard deviation: the landmarks' common error [rad]."""
    translation_sigma_m: float = 0.03
    """Likewise [m]."""
    max_sigma_m: float = 0.06
    """Largest standard deviation of a loop edge's translation, in its worst direction [m]; few or distant landmarks
    leave more open, and then their own errors decide."""
    seed: int = 0
    """Of RANSAC."""

    def __post_init__(self) -> None:
        """Raise ConfigError where a value cannot work."""
        _require(self.pool >= 0, "verification.pool", self.pool, ">= 0")
        _require(0 < self.ratio <= 1, "verification.ratio", self.ratio, "(0, 1]")
        _require(self.max_reprojection_px > 0, "verification.max_reprojection_px", self.max_reprojection_px, "> 0 px")
        _require(self.min_inliers >= 4, "verification.min_inliers", self.min_inliers, ">= 4")
        _require(1 <= self.min_cells <= 36, "verification.min_cells", self.min_cells, "1 to 36")
        _require(self.gate_m >= 0, "verification.gate_m", self.gate_m, ">= 0 m")
        _require(self.gate_share >= 0, "verification.gate_share", self.gate_share, ">= 0")
        _require(self.gate_rad >= 0, "verification.gate_rad", self.gate_rad, ">= 0 rad")
        _require(self.gate_rad_m >= 0, "verification.gate_rad_m", self.gate_rad_m, ">= 0 rad/m")
        _require(self.max_edges >= 1, "verification.max_edges", self.max_edges, ">= 1")
        _require(self.pixel_sigma > 0, "verification.pixel_sigma", self.pixel_sigma, "> 0 px")
        sigma = self.rotation_sigma_rad
        _require(sigma > 0, "verification.rotation_sigma_rad", sigma, "> 0 rad")
        sigma = self.translation_sigma_m
        _require(sigma > 0, "verification.translation_sigma_m", sigma, "> 0 m")
        _require(self.max_sigma_m > sigma, "verification.max_sigma_m", self.max_sigma_m, "> translation_sigma_m")
        _require(self.seed >= 0, "verification.seed", self.seed, ">= 0")


@dataclass(frozen=True)
class PoseGraphConfig:
    """The optimisation (paper, Eq. 2)."""

    dcs: float = 12.6
    """DCS compares the squared whitened residual with it: chi² of 6 degrees of freedom at 0.95."""
    every: int = 10
    """Keyframes between two optimisations at least."""
    min_rotation_sigma_rad: float = 1e-4
    """Added in quadrature to an odometry step's standard deviation, which may be stated as zero [rad]."""
    min_translation_sigma_m: float = 1e-4
    """Likewise [m]."""
    max_iterations: int = 50
    """Of Levenberg-Marquardt."""

    def __post_init__(self) -> None:
        """Raise ConfigError where a value cannot work."""
        _require(self.dcs > 0, "pose_graph.dcs", self.dcs, "> 0 (12.6 to 16.8 keep true loops)")
        _require(self.every >= 1, "pose_graph.every", self.every, ">= 1")
        sigma = self.min_rotation_sigma_rad
        _require(sigma > 0, "pose_graph.min_rotation_sigma_rad", sigma, "> 0 rad")
        sigma = self.min_translation_sigma_m
        _require(sigma > 0, "pose_graph.min_translation_sigma_m", sigma, "> 0 m")
        _require(self.max_iterations >= 1, "pose_graph.max_iterations", self.max_iterations, ">= 1")


@dataclass(frozen=True)
class PlannerConfig:
    """Paths between rooms over the graph (paper, Sec. IV)."""

    shortcut_m: float = 0.6
    """Keyframes this close are joined although nobody walked between them [m]; keep it under twice the robot's
    clearance plus a wall's thickness, or a path may cross a wall. 0 allows only what was walked or closed as a loop."""

    def __post_init__(self) -> None:
        """Raise ConfigError where a value cannot work."""
        _require(self.shortcut_m >= 0, "planner.shortcut_m", self.shortcut_m, ">= 0 m")


@dataclass(frozen=True)
class Config:
    """All settings of LEXIS, in the order of the stages; what concerns two stages is checked here."""

    keyframes: KeyframeConfig = field(default_factory=KeyframeConfig)
    landmarks: LandmarkConfig = field(default_factory=LandmarkConfig)
    labels: LabelConfig = field(default_factory=LabelConfig)
    segmentation: SegmentationConfig = field(default_factory=SegmentationConfig)
    place_recognition: PlaceRecognitionConfig = field(default_factory=PlaceRecognitionConfig)
    verification: VerificationConfig = field(default_factory=VerificationConfig)
    pose_graph: PoseGraphConfig = field(default_factory=PoseGraphConfig)
    planner: PlannerConfig = field(default_factory=PlannerConfig)

    def __post_init__(self) -> None:
        """Raise ConfigError where two stages contradict each other."""
        views = 2 * self.keyframes.supports + 1
        _require(
            self.landmarks.min_views <= views,
            "landmarks.min_views",
            self.landmarks.min_views,
            f"up to the {views} images that keyframes.supports leaves, or there is no landmark",
        )
        _require(
            self.segmentation.stairs_name == self.labels.stairs_name,
            "segmentation.stairs_name",
            repr(self.segmentation.stairs_name),
            f"{self.labels.stairs_name!r}, as labels.stairs_name, or no floor is found",
        )
