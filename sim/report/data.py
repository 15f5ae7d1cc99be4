"""The input of a report, as plain data without types of LEXIS, so that runs of any SLAM system can be reported."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Bool, Float64, Int, UInt8

from sim.errors import SimError
from worlds.spec import OpeningKind
from worlds.walkable import polyline_length

UNKNOWN = -1
"""Label index of frames to which the SLAM gave no label."""
NO_LABEL = "no label"
"""Text that the report shows in place of a label for the index `UNKNOWN`."""
Outline = Float64[np.ndarray, "_ 2"]
"""Vertices of a polygon of the floor plan, in W [m]."""


@dataclass(frozen=True, eq=False)
class PlannedRoom:
    """A room of the floor plan: its outline, label and name."""

    name: str
    """Name of the room instance, such as "bedroom 2"."""
    label: str
    outline: Outline


@dataclass(frozen=True, eq=False)
class PlannedOpening:
    """An opening between two rooms."""

    kind: OpeningKind
    ends: Float64[np.ndarray, "2 2"]
    """Both ends of the opening, in W [m]."""
    has_leaf: bool = False
    """Whether it is a door with a leaf; the leaf is an entry of `FloorPlan.leaves`."""


@dataclass(frozen=True, eq=False)
class PlannedLeaf:
    """A door leaf (the moving panel of a door) at its opening angle."""

    outline: Outline
    arc: Float64[np.ndarray, "k 2"]
    """Path of the door leaf's free end from the closed to the present position, in W [m]."""


@dataclass(frozen=True, eq=False)
class FloorPlan:
    """The floor plan of one storey."""

    level: int
    floor_m: float
    rooms: tuple[PlannedRoom, ...]
    walls: tuple[Outline, ...] = ()
    fences: tuple[Outline, ...] = ()
    openings: tuple[PlannedOpening, ...] = ()
    furniture: tuple[Outline, ...] = ()
    """Pieces that begin below head height. A ceiling lamp would look like a table."""
    treads: tuple[Outline, ...] = ()
    climbs: tuple[Float64[np.ndarray, "_ 2"], ...] = ()
    """For each staircase, the path up the flight that begins on this storey, or else that ends here, in W [m]."""
    leaves: tuple[PlannedLeaf, ...] = ()
    windows: tuple[Float64[np.ndarray, "2 2"], ...] = ()
    """Each window as the two ends of a line, in W [m]."""
    house: str | None = None
    """Name of the house."""


@dataclass(frozen=True, eq=False)
class KeyframeTable:
    """Truth and estimate of every keyframe, one row per keyframe, in the order of time. Poses are `T_W_B`."""

    stamps: Float64[np.ndarray, "n"]
    """Time stamps [s]."""
    true_poses: Float64[np.ndarray, "n 4 4"]
    odometry_poses: Float64[np.ndarray, "n 4 4"]
    """Poses of the odometry, aligned to the truth as for the ATE. `estimated_poses` are aligned in the same way."""
    estimated_poses: Float64[np.ndarray, "n 4 4"]
    storeys: Int[np.ndarray, "n"]
    """Level of the storey that truly contains each keyframe, 0 for the lowest."""
    true_labels: Int[np.ndarray, "n"]
    """Label of the room that truly contains each keyframe, as an index into `ReportData.label_names`."""
    baseline_labels: Int[np.ndarray, "n"]
    """Label predicted from each keyframe's image alone, as an index into `ReportData.label_names`, or `UNKNOWN`."""
    predicted_labels: Int[np.ndarray, "n"]
    """Label predicted for each keyframe after refinement, as an index into `ReportData.label_names`, or `UNKNOWN`."""
    true_rooms: tuple[str, ...]
    """Name of the room instance that truly contains each keyframe."""
    predicted_rooms: tuple[str, ...]
    """Name of the room instance to which the SLAM assigned each keyframe, such as "room 4 (kitchen)"; "" for none."""

    @property
    def is_labelled(self) -> bool:
        """Whether any keyframe has a label. A SLAM need not estimate labels."""
        return bool((self.predicted_labels != UNKNOWN).any())

    @property
    def is_labelled_before(self) -> bool:
        """Whether any keyframe has a label before refinement."""
        return bool((self.baseline_labels != UNKNOWN).any())

    @property
    def has_rooms(self) -> bool:
        """Whether the SLAM has assigned any keyframe to a room instance."""
        return any(self.predicted_rooms)

    @property
    def wrong(self) -> Bool[np.ndarray, "n"]:
        """For each keyframe, whether the refined label is wrong; for no keyframe if there are no labels at all."""
        return np.asarray((self.predicted_labels != self.true_labels) & self.is_labelled)

    @property
    def odometry_errors(self) -> Float64[np.ndarray, "n"]:
        """For each keyframe, the distance between the odometry's position and the true position [m]."""
        return np.asarray(np.linalg.norm(self.odometry_poses[:, :3, 3] - self.true_poses[:, :3, 3], axis=1))

    @property
    def estimated_errors(self) -> Float64[np.ndarray, "n"]:
        """For each keyframe, the distance between the estimated position and the true position [m]."""
        return np.asarray(np.linalg.norm(self.estimated_poses[:, :3, 3] - self.true_poses[:, :3, 3], axis=1))


@dataclass(frozen=True)
class LoopMark:
    """A loop edge between the keyframes `query` and `match` (row numbers), and whether its relative pose is right."""

    query: int
    match: int
    true: bool
    weight: float
    """Final weight of the loop edge under the optimiser's robust kernel, in [0, 1]; 1 if the SLAM states no weights."""
    error_m: float = 0.0
    error_rad: float = 0.0
    """Errors of the measured relative pose [m, rad]."""


@dataclass(frozen=True)
class CandidateMark:
    """A loop candidate: the keyframes `query` and `match` (row numbers), the SLAM's decision, and the truth."""

    query: int
    match: int
    accepted: bool
    reason: str
    """Why the SLAM accepted or refused the candidate."""
    figures: Mapping[str, float]
    """The figures on which the decision was based, by name."""
    distance_m: float
    """Distance between the true positions of both keyframes [m]."""
    revisit: bool
    """Whether both keyframes were truly taken at the same place: within 1 m and 0.5 rad."""


@dataclass(frozen=True, eq=False)
class SampleFrame:
    """A frame that the report shows as an example."""

    keyframe: int
    image: UInt8[np.ndarray, "h w 3"]
    scores: tuple[tuple[str, float], ...]
    """The labels that are most similar to the image, each with its similarity, best first."""


@dataclass(frozen=True, eq=False)
class PlanPath:
    """A plan of the SLAM from room to room, and the path in W that a robot drove along the plan."""

    start: str
    goal: str
    points: Float64[np.ndarray, "k 3"]
    """Positions of the robot on the floor, in W [m]; empty if no plan was found."""
    success: bool
    """Whether the robot reached the goal; False, too, if the plan was not driven."""
    reason: str = ""
    """Reason why the robot did not reach the goal; empty if the robot reached the goal."""
    ended: str | None = None
    """Name of the room that the robot ended in; None if it ended outside of all rooms or the plan was not driven."""
    shortest_m: float | None = None
    """Length of the shortest possible path from the start to the goal [m]; None if it is unknown."""

    @property
    def driven_m(self) -> float:
        """Length of the path that the robot drove [m]."""
        return polyline_length(self.points)


@dataclass(frozen=True)
class ShownFailure:
    """Why a run counts as a failure, and where it first went wrong."""

    what: str
    """What failed, such as the message of an assertion; it may have several lines."""
    place: str = ""
    """Room, time and kind of the first error; empty if no single frame shows the failure."""
    keyframe: int | None = None
    """Keyframe at which the first error occurs (row number), if it is known."""


@dataclass(frozen=True, eq=False)
class ReportData:
    """Everything that `write_report` needs. Raises `SimError` if there are no keyframes, or for indices out of range."""

    result: Mapping[str, Any]
    """The contents of result.json."""
    label_names: tuple[str, ...]
    plans: tuple[FloorPlan, ...]
    keyframes: KeyframeTable
    loops: tuple[LoopMark, ...] = ()
    samples: tuple[SampleFrame, ...] = ()
    paths: tuple[PlanPath, ...] = ()
    faults_of_images: tuple[str, ...] = ()
    """Names of the faults of the run that the images of `samples` do not show."""
    unseen_rooms: tuple[str, ...] = ()
    """Names of the rooms on the walk that contain no keyframe."""
    candidates: tuple[CandidateMark, ...] = ()
    failure: ShownFailure | None = None
    """Why the run counts as a failure; None for a run without a verdict."""
    mistakes: tuple[str, ...] = ()
    """Sentences on mistakes of the estimate that its figures do not explain, such as floors that are numbered from 1."""
    estimates_poses: bool = True
    """Whether the SLAM estimates poses. If not, the estimated poses of the keyframes are those of the odometry."""

    @property
    def estimates_loops(self) -> bool:
        """Whether the SLAM estimates which loops it has closed, which may be none."""
        return bool(self.loops) or (self.result.get("loops") or {}).get("verified") is not None

    @property
    def shown_labels(self) -> tuple[str, ...]:
        """The names of all labels by index. The last one, `NO_LABEL`, is at the index -1 (`UNKNOWN`)."""
        return (*self.label_names, NO_LABEL)

    @property
    def failed(self) -> tuple[PlanPath, ...]:
        """The plans that did not reach their goal, driven or not. The report numbers them from 1 in this order."""
        return tuple(path for path in self.paths if not path.success)

    def __post_init__(self) -> None:
        n, names = len(self.keyframes.stamps), len(self.label_names)
        if n == 0:
            raise SimError("report: there are no keyframes; at least one is needed")
        for label in ("true_labels", "baseline_labels", "predicted_labels"):
            rows = getattr(self.keyframes, label)
            if rows.min() < UNKNOWN or rows.max() >= names:
                raise SimError(f"report: {label} must lie in [0, {names}), the rows of label_names, or be {UNKNOWN}")
        ends = [k for loop in self.loops for k in (loop.query, loop.match)] + [sample.keyframe for sample in self.samples]
        ends += [k for mark in self.candidates for k in (mark.query, mark.match)]
        ends += [] if self.failure is None or self.failure.keyframe is None else [self.failure.keyframe]
        if ends and not 0 <= min(ends) <= max(ends) < n:
            found = f"{min(ends)} to {max(ends)}"
            raise SimError(
                f"report: loops, candidates, samples and the failure must name keyframes in [0, {n}), not {found}"
            )
