"""What a report shows, as plain data: no type of the simulator or of LEXIS, so that any SLAM's run can be reported."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Bool, Float, Float64, Int, UInt8

from sim.errors import SimError
from worlds.spec import OpeningKind

Outline = Float64[np.ndarray, "corners 2"]
"""A polygon of the plan, in W [m]."""


@dataclass(frozen=True, eq=False)
class PlannedRoom:
    """A room of the floor plan."""

    name: str
    """Of the instance, such as "bedroom 2"."""
    label: str
    outline: Outline


@dataclass(frozen=True, eq=False)
class PlannedOpening:
    """A gap between two rooms."""

    kind: OpeningKind
    ends: Float64[np.ndarray, "2 2"]
    """[m]"""


@dataclass(frozen=True, eq=False)
class PlannedLeaf:
    """A door leaf as it stands."""

    outline: Outline
    arc: Float64[np.ndarray, "k 2"]
    """The way of its free end from shut to where it stands [m]."""


@dataclass(frozen=True, eq=False)
class FloorPlan:
    """One storey, seen from above."""

    level: int
    floor_m: float
    rooms: tuple[PlannedRoom, ...]
    walls: tuple[Outline, ...] = ()
    fences: tuple[Outline, ...] = ()
    openings: tuple[PlannedOpening, ...] = ()
    furniture: tuple[Outline, ...] = ()
    treads: tuple[Outline, ...] = ()
    leaves: tuple[PlannedLeaf, ...] = ()
    windows: tuple[Float64[np.ndarray, "2 2"], ...] = ()
    """The two ends of each [m]."""
    house: str | None = None
    """Name of the house."""


@dataclass(frozen=True, eq=False)
class KeyframeTable:
    """Truth and estimate of every keyframe, one row each, in the order of time. Poses are in W."""

    stamps: Float64[np.ndarray, "n"]
    """[s]"""
    true_poses: Float64[np.ndarray, "n 4 4"]
    odometry_poses: Float64[np.ndarray, "n 4 4"]
    """Aligned to the truth as for the ATE, the optimised ones too, so that both can be compared."""
    optimised_poses: Float64[np.ndarray, "n 4 4"]
    storeys: Int[np.ndarray, "n"]
    """True level."""
    true_labels: Int[np.ndarray, "n"]
    """Row of `ReportData.label_names`, as the two below."""
    baseline_labels: Int[np.ndarray, "n"]
    predicted_labels: Int[np.ndarray, "n"]
    true_rooms: tuple[str, ...]
    """Name of the room instance that holds the camera."""
    predicted_rooms: tuple[str, ...]
    """Name of the room instance that LEXIS put it in."""

    @property
    def wrong(self) -> Bool[np.ndarray, "n"]:
        """Whether the refined label is not the true room's."""
        return np.asarray(self.predicted_labels != self.true_labels)

    @property
    def odometry_errors(self) -> Float64[np.ndarray, "n"]:
        """Distance of the odometry from the truth [m]."""
        return np.asarray(np.linalg.norm(self.odometry_poses[:, :3, 3] - self.true_poses[:, :3, 3], axis=1))

    @property
    def optimised_errors(self) -> Float64[np.ndarray, "n"]:
        """Distance of the optimised pose from the truth [m]."""
        return np.asarray(np.linalg.norm(self.optimised_poses[:, :3, 3] - self.true_poses[:, :3, 3], axis=1))


@dataclass(frozen=True)
class LoopMark:
    """A loop edge between two keyframes, and whether it is true."""

    query: int
    match: int
    true: bool
    weight: float
    """The robust kernel's final weight, in [0, 1]."""


@dataclass(frozen=True, eq=False)
class SampleFrame:
    """A frame worth looking at."""

    keyframe: int
    image: UInt8[np.ndarray, "h w 3"]
    scores: tuple[tuple[str, float], ...]
    """The labels with the largest similarity and that similarity, best first."""


@dataclass(frozen=True, eq=False)
class PlanPath:
    """A path that LEXIS planned and a robot drove, in W."""

    start: str
    goal: str
    points: Float[np.ndarray, "k 3"]
    """Where the robot's foot was [m]; none where no plan was found."""
    success: bool | None = None
    """Whether it arrived; None: it was not driven."""
    reason: str = ""
    """Why it did not arrive."""
    ended: str | None = None
    """Name of the room that it ended in; None outside of all, or where it was not driven."""
    shortest_m: float | None = None
    """Shortest way to the goal [m]."""

    @property
    def driven_m(self) -> float:
        """Length of the path [m]."""
        return float(np.linalg.norm(np.diff(self.points, axis=0), axis=1).sum())


@dataclass(frozen=True, eq=False)
class ReportData:
    """All that `write_report` needs."""

    result: Mapping[str, Any]
    """The contents of result.json."""
    label_names: tuple[str, ...]
    plans: tuple[FloorPlan, ...]
    keyframes: KeyframeTable
    loops: tuple[LoopMark, ...] = ()
    samples: tuple[SampleFrame, ...] = ()
    paths: tuple[PlanPath, ...] = ()
    unseen_rooms: tuple[str, ...] = ()
    """Rooms of the walk that no keyframe is in."""

    @property
    def failed(self) -> tuple[PlanPath, ...]:
        """The plans that did not arrive, numbered from 1 in this order wherever they are shown."""
        return tuple(path for path in self.paths if path.success is False)

    def __post_init__(self) -> None:
        n, names = len(self.keyframes.stamps), len(self.label_names)
        if n == 0:
            raise SimError("report: there are no keyframes; at least one is needed")
        for label in ("true_labels", "baseline_labels", "predicted_labels"):
            rows = getattr(self.keyframes, label)
            if rows.min() < 0 or rows.max() >= names:
                raise SimError(f"report: {label} must lie in [0, {names}), the rows of label_names")
        ends = [k for loop in self.loops for k in (loop.query, loop.match)] + [sample.keyframe for sample in self.samples]
        if ends and not 0 <= min(ends) <= max(ends) < n:
            raise SimError(f"report: loops and samples must name keyframes in [0, {n}), not {min(ends)} to {max(ends)}")
