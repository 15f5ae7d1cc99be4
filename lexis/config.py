"""Settings of LEXIS: one frozen dataclass per stage, with defaults that work; `Config` holds them all.

The annotation of each field declares the valid values. A value that is not valid is refused when the settings are created or
read, and not in the middle of a run.
"""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Literal

from annotated_types import Ge, Gt, Interval, MinLen

from lexis.errors import ConfigError
from lexis.files.reading import FileKind, read_json
from lexis.settings import Settings, settings_of

_FILE = FileKind("settings as JSON; 'lexis config' prints the defaults", 1_000_000, ConfigError)


@dataclass(frozen=True)
class KeyframeConfig(Settings, place="keyframes", error=ConfigError):
    """Settings for selecting the observations that become keyframes of the graph (paper, Sec. III-A)."""

    spacing_m: Annotated[float, Interval(gt=0, le=2)] = 0.5
    """Length of the odometry path between keyframes [m]. It is clearly below `lexis.keyframes.MAX_STEP_M`, because plans do
    not cross larger steps."""
    rotation_rad: Annotated[float, Gt(0)] | None = None
    """Sum of the rotations from frame to frame, in whatever direction, after which a new keyframe is selected even if the
    path is shorter than `spacing_m` [rad]. None: only the path length decides, as in the paper."""
    support_spacing_m: Annotated[float, Gt(0)] = 0.25
    """Length of the odometry path from a keyframe or support frame to the next support frame [m]. Support frames only serve
    to triangulate landmarks."""
    supports: Annotated[int, Ge(1)] = 2
    """Number of frames before a keyframe, and again after it, from which the keyframe's landmarks are triangulated. These
    frames may be support frames or other keyframes."""


@dataclass(frozen=True)
class LandmarkConfig(Settings, place="landmarks", error=ConfigError):
    """Settings for extracting AKAZE features and triangulating 3-D points from them."""

    akaze_threshold: Annotated[float, Gt(0)] = 3e-4
    """Least detector response of a key point; OpenCV's default of 1e-3 finds too few key points on plain walls."""
    max_features: Annotated[int, Ge(8)] = 600
    """Largest number of key points per image; the strongest are kept."""
    epipolar_px: Annotated[float, Gt(0)] = 2.5
    """Largest distance of a match from its epipolar line [px]."""
    ratio: Annotated[float, Interval(gt=0, le=1)] = 0.8
    """Largest ratio of the best to the second-best Hamming distance of an accepted match (Lowe's ratio test)."""
    max_hamming: Annotated[int, Interval(ge=1, le=488)] = 120
    """Largest Hamming distance of two matched descriptors, which have 486 bits."""
    min_views: Annotated[int, Ge(2)] = 3
    """Least number of images, the keyframe's own included, that must agree on a landmark."""
    min_parallax_rad: Annotated[float, Interval(gt=0, lt=1)] = 0.026
    """Least parallax of a landmark [rad], which is the largest angle between any two of its viewing rays. The default is 1.5
    degrees."""
    max_reprojection_px: Annotated[float, Gt(0)] = 1.5
    """Largest reprojection error of a landmark in any view [px]."""


@dataclass(frozen=True)
class LabelConfig(Settings, place="labels", error=ConfigError):
    """Settings for refining the room labels of keyframes and finding stairs (paper, Sec. III-B)."""

    method: Literal["image", "vote", "sight"] = "sight"
    """How a keyframe gets its label. sight: from all images that show its place; see `lexis.sight`. vote: by a vote among
    the nearest keyframes, as in the paper. image: from its own image alone. Except with "image", stairs are found by their
    change of height."""
    neighbours: Annotated[int, Ge(1)] = 5
    """Number of nearest keyframes that vote on the label of a keyframe (C in the paper, there 3 to 7)."""
    every: Annotated[int, Ge(1)] = 9
    """Labels are refined during the run whenever the number of keyframes is a multiple of this number (K in the paper, there
    7 to 12), and after every optimisation. Only place recognition by room needs this; with the other methods, labels are
    refined only when a map is made."""
    stairs_name: Annotated[str, MinLen(1)] = "stairs"
    """The name of the room label for keyframes on stairs and in a moving lift; "Stairs" and "stairs" are the same name.
    These keyframes are on no floor, and separate floors. If the user's room names lack this name, these keyframes are
    labelled like all others, and get the nearest floor."""
    stairs_window_m: Annotated[float, Gt(0)] = 2.0
    """Length of the path over which the change of height is measured, centred on the keyframe [m]."""
    stairs_min_height_m: Annotated[float, Gt(0)] = 0.5
    """Least change of height over `stairs_window_m` for a keyframe to count as on stairs [m]. At either end of the stairs, a
    keyframe that is as high as the next one off the stairs does not count."""


@dataclass(frozen=True)
class SegmentationConfig(Settings, place="segmentation", error=ConfigError):
    """Settings for clustering keyframes into rooms and floors (paper, Sec. III-C)."""

    method: Literal["distance", "sight"] = "sight"
    """How keyframes of one label are joined to rooms. sight: by whether they see each other's places; see `lexis.sight`.
    distance: by their distances, as in the paper."""
    distance_m: Annotated[float, Gt(0)] = 3.0
    """A keyframe joins a cluster of its label only if the cluster's mean position is within this distance [m]."""
    adjacency_m: Annotated[float, Gt(0)] = 1.5
    """Two clusters of the same label merge if a keyframe of one is within this distance of a keyframe of the other and no
    other room lies between the two keyframes [m]. Clusters that contain consecutive keyframes merge at any distance."""


@dataclass(frozen=True)
class SightConfig(Settings, place="sight", error=ConfigError):
    """Settings for labels and rooms from the free space that the images show (beyond the paper)."""

    range_m: Annotated[float, Interval(gt=0, le=100)] = 6.0
    """Largest distance of a landmark from the camera [m]. The space between the camera and farther landmarks does not count
    as seen."""
    reach_m: Annotated[float, Gt(0)] = 1.5
    """Largest horizontal distance from the camera of the places that stand for its visible space [m]. What lies farther away
    often belongs to another room of an open plan."""
    near_m: Annotated[float, Gt(0)] = 0.7
    """Distance from a keyframe within which visible space belongs to the place of this keyframe [m]."""
    temperature: Annotated[float, Gt(0)] = 0.063
    """The similarities of an image are divided by this before the softmax that converts them to probabilities."""
    least_probability: Annotated[float, Interval(gt=0, lt=1)] = 1e-4
    """Constant that is added to the label probabilities of an image, so that no image can rule out a label."""
    own_weight: Annotated[float, Ge(0)] = 0.6
    """Additional weight of a keyframe's own image in the label of the keyframe. Each image, the own one included, already
    has as weight the share of its visible space that lies near the keyframe."""
    independence: Annotated[float, Interval(gt=0, le=1)] = 0.3
    """Share of the summed evidence that counts in the probabilities of labels. It is less than 1, because images of one
    place resemble each other: what misleads one of them misleads others. It does not change the labels."""
    neighbour_weight: Annotated[float, Ge(0)] = 2.0
    """Weight of the label probabilities of the keyframes that see a keyframe's place, relative to the evidence of the
    images."""
    passes: Annotated[int, Ge(0)] = 3
    """Number of passes of opinion pooling, in which keyframes come to agree with the keyframes that see their places."""
    share: Annotated[float, Interval(ge=0, lt=1)] = 0.06
    """A keyframe sees the place of another keyframe if more than this share of its visible space lies near the other
    keyframe."""
    min_keyframes: Annotated[int, Ge(1)] = 3
    """Least number of keyframes of a room. A smaller room is absorbed by the larger room of its floor that it sees, or is
    seen from, most."""
    split_m: Annotated[float, Ge(0)] = 0.15
    """A room is split into two parts if the normalised cut of sight between them, times the length of the room, is below
    this [m]. With 0, no room is split. See `lexis.sight.divided_rooms`."""
    passage_m: Annotated[float, Interval(ge=0, le=5)] = 1.1
    """Largest width of a narrow passage on the path, such as a doorway [m]. With 0, no passages are sought. See
    `lexis.sight.passages`."""
    passage_weight: Annotated[float, Interval(ge=0, le=1)] = 0.1
    """Weight of sight through a narrow passage, relative to other sight, when it is decided which rooms are split."""
    border_m: Annotated[float, Ge(0)] = 0.75
    """If the label of the keyframes changes at most this far from a narrow passage on the path, it changes in the passage
    instead [m]. With 0, labels stay. See `lexis.sight.borders`."""
    merge_cut: Annotated[float, Gt(0)] = 0.08
    """Least normalised cut of sight between two rooms that merge; a room is split only if the cut between its parts is below
    it. With a value above 2, no rooms merge, because a cut is at most 2, and `split_m` alone decides on splits. See
    `lexis.sight.alike_rooms` and `lexis.sight.divided_rooms`."""
    merge_log_odds: Annotated[float, Ge(0)] = 2.5
    """Two rooms merge only if in both of them, the mean log odds of the room's own label over the label of the other room
    are below this."""
    alcove_log_odds: Annotated[float, Ge(0)] = 4.5
    """The limit in place of `merge_log_odds` for a room that has an alcove, when the two merge. An alcove is a room that the
    path leaves into one other room only, except through doorways; its own limit is `merge_log_odds`. If `alcove_log_odds` is
    not larger than `merge_log_odds`, alcoves are like all rooms."""


@dataclass(frozen=True)
class PlaceRecognitionConfig(Settings, place="place_recognition", error=ConfigError):
    """Settings for proposing loop candidates (paper, Sec. III-D)."""

    method: Literal["probability", "room", "similarity"] = "probability"
    """How loop candidates are chosen. probability: the keyframes whose place the new keyframe shows most probably, by the
    similarity of the images and by the estimated poses. room: as in the paper, the keyframes with the most similar images in
    the closest room that has the label of the new image. similarity: the keyframes with the most similar images of all."""
    candidates: Annotated[int, Ge(0)] = 10
    """Largest number of loop candidates that are proposed for one query, which is a new keyframe."""
    min_gap_s: Annotated[float, Ge(0)] = 10.0
    """Least time between a loop candidate and the query, which is the new keyframe [s]."""
    min_gap_m: Annotated[float, Ge(0)] = 5.0
    """Least length of the path between a loop candidate and the query, which is the new keyframe [m]."""
    least_probability: Annotated[float, Interval(gt=0, lt=1)] = 0.004
    """Least probability of a revisit at which the method "probability" proposes candidates. It is low, because a false
    candidate only costs a verification, but a missing candidate can cost a loop."""
    log_odds: Annotated[float, Interval(ge=-100, le=100)] = -2.14
    """Log odds of a revisit if the similarity of the images is 0 and the estimated poses are equal. This setting and the
    next one are fitted to the encoder `mini`."""
    similarity_weight: Annotated[float, Ge(0)] = 10.6
    """Log odds that are added per unit of cosine similarity of the images."""
    place_m: Annotated[float, Gt(0)] = 0.415
    """Estimated distance that lowers the log odds by 1 [m]; they fall with its square."""
    place_rad: Annotated[float, Gt(0)] = 0.236
    """Estimated angle that lowers the log odds by 1 [rad]; they fall with its square."""
    lost_log_odds: Annotated[float, Ge(0)] = 13.4
    """Largest amount by which the estimated distance and angle can lower the log odds of a revisit. The amount is limited,
    because the estimated pose may be completely wrong. It is 0.3 above the fitted value, which gives fewer false
    answers. A robot that was carried elsewhere is found by far loops instead (lexis/pages/places.md)."""


@dataclass(frozen=True)
class VerificationConfig(Settings, place="verification", error=ConfigError):
    """Settings for verifying loop candidates by PnP (paper, Sec. III-D)."""

    pool: Annotated[int, Ge(0)] = 2
    """Number of keyframes on either side of a loop candidate whose landmarks are added to the candidate's own."""
    ratio: Annotated[float, Interval(gt=0, le=1)] = 0.8
    """Largest ratio of the best to the second-best Hamming distance of an accepted match (Lowe's ratio test)."""
    max_reprojection_px: Annotated[float, Gt(0)] = 3.0
    """Largest reprojection error of an inlier [px]."""
    min_inliers: Annotated[int, Ge(4)] = 15
    """Least number of distinct key points that must be inliers of PnP, in at least one image of the new keyframe."""
    min_cells: Annotated[int, Interval(ge=1, le=36)] = 5
    """Least number of cells of a 6 x 6 grid on at least one image that must contain an inlier."""
    min_cells_turned: Annotated[int, Interval(ge=1, le=36)] = 10
    """A loop edge whose rotation differs from the current estimate by more than `gate_rad`, however long the path is, is
    rejected unless its inliers lie in at least this many cells of a 6 x 6 grid on one image. Inliers in fewer cells often
    lie on a single piece of furniture, whose landmarks have errors in common."""
    gate_m: Annotated[float, Ge(0)] = 0.5
    """A loop edge is rejected if its translation differs from the current estimate by more than this limit [m]. The limit
    grows with the path by `gate_share`."""
    gate_share: Annotated[float, Ge(0)] = 0.03
    """Distance that is added to `gate_m` for every metre of path between the two keyframes of the loop edge [m/m]."""
    gate_height_share: Annotated[float, Ge(0)] = 0.01
    """Distance that is added to `gate_m` for every metre of path, as a limit for the difference in height alone [m/m]. It is
    smaller than `gate_share`, because odometry that knows the vertical drifts less in height, and because storeys that look
    alike are only a few metres apart."""
    gate_rad: Annotated[float, Ge(0)] = 0.1
    """A loop edge is rejected if its rotation differs from the current estimate by more than this limit [rad]. The limit
    grows with the path by `gate_rad_m`."""
    gate_rad_m: Annotated[float, Ge(0)] = 0.005
    """Angle that is added to `gate_rad` for every metre of path between the two keyframes of the loop edge [rad/m]."""
    max_contradiction: Annotated[float, Gt(0)] | None = None
    """Largest squared Mahalanobis distance between the poses that two loop edges give to a new keyframe. If the distance is
    larger, the edges contradict each other, and one of them is rejected; only edges to neighbouring keyframes are compared.
    A usual limit is 16.8, the 0.99 quantile of chi² with 6 degrees of freedom. None: edges are not compared, and the robust
    kernel alone judges them (sim/pages/pose-graphs.md)."""
    max_edges: Annotated[int, Ge(1)] = 3
    """Largest number of loop edges from one new keyframe; those with the most inliers are kept. Edges that join two sessions
    are not limited."""
    ray_sigma_rad: Annotated[float, Gt(0)] = 0.0248
    """Standard deviation of the direction to an inlier in the covariance of a loop edge [rad]. The default is 5 px at a
    focal length of 201 px. It exceeds the largest error of an inlier, because the landmarks of an edge have errors in
    common: many inliers hold less information than as many independent measurements (sim/pages/pose-graphs.md)."""
    rotation_sigma_rad: Annotated[float, Gt(0)] = 0.005
    """Error that all landmarks of a loop edge share; it is added in quadrature to the standard deviation of the edge's
    rotation [rad]."""
    translation_sigma_m: Annotated[float, Gt(0)] = 0.03
    """Error that all landmarks of a loop edge share; it is added in quadrature to the standard deviation of the edge's
    translation [m]."""
    sure_sigma_m: Annotated[float, Gt(0)] = 0.08
    """Largest standard deviation of the translation of a sure loop edge, in its worst direction [m]. If it is larger, the
    landmarks are too few or too distant to determine the translation, and the edge is uncertain."""
    sure_sigma_rad: Annotated[float, Gt(0)] = 0.035
    """Largest standard deviation of the rotation of a sure loop edge, about its worst axis [rad]."""
    uncertain_gate_m: Annotated[float, Ge(0)] = 0.35
    """An uncertain loop edge is also rejected if its translation differs from the current estimate by this limit or more
    [m], or its rotation by more than `gate_rad`. Neither limit grows with the path: an uncertain edge may confirm the
    estimate, but not correct drift, because its covariance is so large that the robust kernel would trust a wrong one."""
    seed: Annotated[int, Ge(0)] = 0
    """Seed of the random samples that RANSAC draws."""

    def __post_init__(self) -> None:
        """Raise ConfigError for a value that is not valid."""
        super().__post_init__()
        if self.sure_sigma_m <= self.translation_sigma_m:
            self.refuse("sure_sigma_m", f"> translation_sigma_m = {self.translation_sigma_m:g} m")
        if self.sure_sigma_rad <= self.rotation_sigma_rad:
            self.refuse("sure_sigma_rad", f"> rotation_sigma_rad = {self.rotation_sigma_rad:g} rad")


@dataclass(frozen=True)
class PoseGraphConfig(Settings, place="pose_graph", error=ConfigError):
    """Settings for optimising the pose graph (paper, Eq. 2)."""

    kernel: Literal["dcs", "gnc", "huber", "none"] = "dcs"
    """How the influence of wrong loop edges is limited. dcs: dynamic covariance scaling (Agarwal et al., 2013), as in the
    paper. gnc: graduated non-convexity with truncated least squares (Yang et al., 2020), which solves the graph many times:
    it starts with equal trust in all loops, and lowers the weights of those that do not fit. huber: the Huber kernel. none:
    least squares."""
    outlier_threshold: Annotated[float, Gt(0)] = 30.0
    """Squared whitened residual above which the kernel down-weights a loop edge. The default is well above the 0.95 quantile
    of chi² with 6 degrees of freedom, 12.6, because the errors of true loops have heavier tails than a Gaussian
    (sim/pages/pose-graphs.md)."""
    every: Annotated[int, Ge(1)] = 10
    """Least number of keyframes between two optimisations of the graph."""
    window: Annotated[int, Ge(1)] = 100
    """Number of keyframes, counted from the last, that most optimisations move. All earlier poses are fixed then."""
    growth: Annotated[float, Interval(ge=0, lt=1)] = 0.2
    """The whole graph is optimised whenever this share of its keyframes has been added since the last time, and when the
    map is finished. The time per keyframe thus hardly grows with the graph. With 0, every optimisation is of the whole
    graph."""
    copies: Annotated[int, Ge(1)] | None = 2
    """A keyframe may retire from the optimisation if this many keyframes of earlier visits show its place, within 1 m and
    0.5 rad. Its pose relative to one of these keyframes is then fixed, it is no loop candidate any more, and it gives up its
    features, landmarks and loop edges. The graph and the map thus grow with the area that is walked, and hardly with the
    time. None: no keyframe retires. See `lexis.graph.thinning`."""
    retire_above: Annotated[int, Ge(0)] = 800
    """Keyframes begin to retire when more keyframes than this have not retired. All keyframes that may retire then do so at
    once, and fewer than this may remain. A smaller graph costs little, and keeps all of its loop edges."""
    min_rotation_sigma_rad: Annotated[float, Gt(0)] = 1e-4
    """Error that is added in quadrature to the standard deviation of an odometry step's rotation, because the odometry
    may state a deviation of 0 [rad]."""
    min_translation_sigma_m: Annotated[float, Gt(0)] = 1e-4
    """Error that is added in quadrature to the standard deviation of an odometry step's translation, because the odometry
    may state a deviation of 0 [m]."""
    max_iterations: Annotated[int, Ge(1)] = 50
    """Largest number of Levenberg-Marquardt iterations in one optimisation."""

    def __post_init__(self) -> None:
        """Raise ConfigError if the shortest distance between two optimisations already exceeds the window."""
        super().__post_init__()
        if self.window < self.every:
            self.refuse("window", f">= every = {self.every}")


@dataclass(frozen=True)
class SessionConfig(Settings, place="sessions", error=ConfigError):
    """Settings for joining a session to the rest of the map (beyond the paper)."""

    candidates: Annotated[int, Ge(0)] = 10
    """Number of keyframes in other components of the map that are compared with each new keyframe, as long as the map has
    several components."""
    agreeing: Annotated[int, Ge(2)] = 5
    """Least number of keyframes whose loop edges must agree on the relative pose before two sessions are joined. If several
    keyframes agree on another one, `lexis.sessions.relocalisation` says when the former prevail."""
    span_m: Annotated[float, Ge(0)] = 1.0
    """Least length of the path between the first and the last of the keyframes whose loop edges agree [m]."""
    window_m: Annotated[float, Gt(0)] = 20.0
    """Largest length of the path from a keyframe with loop edges to the current keyframe [m]. Older loop edges are
    forgotten."""
    kidnapping_agreeing: Annotated[int, Ge(2)] | None = 10
    """Least number of keyframes whose far loops must agree on one displacement before the finished map is corrected; the
    robot was then carried elsewhere in the session. None: the map is never corrected. See `lexis.sessions.kidnapping`."""


@dataclass(frozen=True)
class PlannerConfig(Settings, place="planner", error=ConfigError):
    """Settings for planning paths between rooms over the pose graph (paper, Sec. IV)."""

    shortcut_m: Annotated[float, Ge(0)] = 0.6
    """Largest distance between two keyframes that are connected although the camera did not walk between them, because they
    are in one room or a loop edge joins them [m]. Keep it below twice the robot's clearance plus the thickness of a wall, or
    a path may cross a wall."""
    sight_m: Annotated[float, Interval(ge=0, le=20)] = 3.0
    """Largest distance between keyframes that are connected because the images show free space between them [m]. With 0,
    there are no such connections. The limit bounds memory: the space is checked at points in proportion to the distance.
    See `lexis.planning.shortcuts`."""
    radius_m: Annotated[float, Interval(gt=0, le=5)] = 0.25
    """Width of the free space on either side of a connection through free space (`sight_m`) [m]; at least the robot's
    radius."""


@dataclass(frozen=True)
class Config(Settings, place="lexis", error=ConfigError):
    """All settings of LEXIS, in the order of the stages."""

    keyframes: KeyframeConfig = field(default_factory=KeyframeConfig)
    landmarks: LandmarkConfig = field(default_factory=LandmarkConfig)
    labels: LabelConfig = field(default_factory=LabelConfig)
    segmentation: SegmentationConfig = field(default_factory=SegmentationConfig)
    sight: SightConfig = field(default_factory=SightConfig)
    place_recognition: PlaceRecognitionConfig = field(default_factory=PlaceRecognitionConfig)
    verification: VerificationConfig = field(default_factory=VerificationConfig)
    pose_graph: PoseGraphConfig = field(default_factory=PoseGraphConfig)
    sessions: SessionConfig = field(default_factory=SessionConfig)
    planner: PlannerConfig = field(default_factory=PlannerConfig)

    @property
    def by_sight(self) -> bool:
        """Whether the labels, the segmentation into rooms, or both use the method "sight" (see `lexis.sight`)."""
        return "sight" in (self.labels.method, self.segmentation.method)

    def __post_init__(self) -> None:
        """Raise ConfigError if the settings of two stages contradict each other."""
        views = 2 * self.keyframes.supports + 1
        if self.landmarks.min_views > views:
            self.landmarks.refuse(
                "min_views", f"up to the {views} images that keyframes.supports leaves, or there is no landmark"
            )


PAPER = Config(
    labels=LabelConfig(method="vote"),
    segmentation=SegmentationConfig(method="distance"),
    place_recognition=PlaceRecognitionConfig(method="room", candidates=5),
)
"""Settings with the methods of the paper for labels, rooms and loop candidates.

Other defaults go beyond the paper and stay as they are: keyframes retire (`pose_graph.copies`; None switches it off), paths
take shortcuts through space that images show to be free (`planner.sight_m`; 0 switches it off), and loop edges that differ
too much from the current estimate are rejected (the gates of `verification`).
"""


def read_config(path: Path) -> Config:
    """Read settings from a JSON file; settings that the file leaves out keep their defaults. Raises ConfigError."""
    return settings_of(Config, read_json(path, _FILE), str(path))
