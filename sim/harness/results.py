"""The result of a run as typed values, named as in result.json. A figure that a run cannot have is None."""

import difflib
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, is_dataclass
from typing import Any, get_type_hints

from sim.errors import SimError

RESULT = "result.json"
"""File with the result of a run, in the run's folder."""
SCHEMA = 1
MATCHES = (1, 3, 5)
"""Least numbers of right matches for which a query counts as a true positive; `RunResult.place_recognition` has figures for
each."""
_SHORT = 3
"""Words of at most this length need less likeness to a name, because one wrong letter changes much of them."""


@dataclass(frozen=True)
class HouseFigures:
    """Size and openness of the house of a run, and the file that holds the house."""

    rooms: int
    floors: int
    area_m2: float
    openness: float
    spec: str = "house.json"
    """Name of the file that holds the house, in the folder of the run."""


def group_of(figure: str | None) -> str:
    """Return the group of a figure by its dotted name, such as "rooms" for "rooms.pq"; "" without a figure."""
    return "" if figure is None else figure.partition(".")[0]


@dataclass(frozen=True)
class WalkFigures:
    """The tour of a run: length [m], duration [s], number of frames, and number of frames of the estimate (`keyframes`)."""

    path_m: float
    duration_s: float
    frames: int
    keyframes: int


@dataclass(frozen=True)
class LabelFigures:
    """Figures on room labels; see `lexis.evaluation.labels`."""

    accuracy: float | None = None
    accuracy_baseline: float | None = None
    """Label accuracy before refinement."""
    accuracy_graded: float | None = None
    """Label accuracy if, near an open boundary between two rooms, the labels of both rooms count as right."""
    per_room: Mapping[str, float] = field(default_factory=dict)
    """Label accuracy of the frames with each true label, by this label."""


@dataclass(frozen=True)
class RoomFigures:
    """Figures on room instances; see `lexis.evaluation.rooms.RoomScores`."""

    pq: float | None = None
    precision: float | None = None
    recall: float | None = None
    hydra_precision: float | None = None
    hydra_recall: float | None = None
    ari: float | None = None
    v_measure: float | None = None
    splits: int | None = None
    merges: int | None = None
    count_error: int | None = None


@dataclass(frozen=True)
class FloorFigures:
    """Figures on floors; see `lexis.evaluation.floors`."""

    accuracy: float | None = None
    count_error: int | None = None


@dataclass(frozen=True)
class LoopFigures:
    """Figures on loop closures; see `lexis.evaluation.loops.LoopScores`."""

    proposed: int | None = None
    verified: int | None = None
    true: int | None = None
    false: int | None = None
    precision: float | None = None
    recall: float | None = None
    error_m: float | None = None
    error_rad: float | None = None


@dataclass(frozen=True)
class MatchFigures:
    """Figures on proposed revisits, as in Fig. 5 of the LEXIS paper; see `lexis.evaluation.place_recognition.MatchCounts`.

    A proposed frame is right if it is at most 1 m and 0.5 rad away, at least 10 s earlier, and at least 5 m earlier on the
    path by odometry.
    """

    tp: int | None = None
    fp: int | None = None
    possible: int | None = None
    precision: float | None = None


@dataclass(frozen=True)
class CoverageFigures:
    """How much of the tour the frames of the estimate cover: numbers of rooms, and share of the path."""

    rooms_visited: int
    """Number of rooms that contain a frame of the estimate."""
    rooms: int
    """Number of rooms that the tour passes through."""
    path_covered: float | None


@dataclass(frozen=True)
class TrajectoryFigures:
    """Figures on errors of the poses; see `lexis.evaluation.trajectory`. Errors below 1e-9 m are 0."""

    ate_odometry_m: float | None = None
    """Absolute trajectory error (ATE) of the odometry that the SLAM was given [m]."""
    ate_m: float | None = None
    """Absolute trajectory error (ATE) of the estimate [m]."""
    rpe_8m_m: float | None = None
    """Relative pose error of the estimate: RMSE of the translation error over stretches of 8 m of path [m]."""
    rpe_8m_odometry_m: float | None = None
    rpe_24m_m: float | None = None
    rpe_24m_odometry_m: float | None = None


@dataclass(frozen=True)
class PlanningFigures:
    """Figures on plans that a simulated robot has driven; see `lexis.evaluation.planning`."""

    queries: int = 0
    success: float | None = None
    spl: float | None = None
    collisions: int | None = None


@dataclass(frozen=True)
class TimeFigures:
    """Wall times of the parts of a run [s]."""

    house_s: float
    scene_s: float
    render_s: float
    slam_s: float
    """Time in which the SLAM under test processed the walk, as the harness measured it [s]."""
    stages_s: Mapping[str, float]
    """Time by stage, as the SLAM reports it [s]."""
    realtime_factor: float | None
    """Duration of the tour divided by `slam_s`."""
    start_s: float = 0.0
    """Time in which the SLAM under test was started [s]. LEXIS loads its encoder then; 0 for a program."""


@dataclass(frozen=True)
class FaultFigures:
    """Faults of a run, and how many observations they changed, were delivered and were refused."""

    given: tuple[str, ...]
    """The faults in the notation of the command line."""
    frames: Mapping[str, int]
    """Number of frames that each fault changed, by the fault's name."""
    delivered: int
    """Number of observations that reached the SLAM."""
    refused: int
    """Number of observations that the SLAM refused."""


_OF_FAULTS = frozenset(f"faults.{name}" for name in get_type_hints(FaultFigures))


@dataclass(frozen=True)
class RunResult:
    """All figures of a run, as in result.json."""

    seed: int
    preset: str | None
    fidelity: str
    slam: str
    """Name of the class of the SLAM under test, with the settings that it states, or the command of a program."""
    encoder: str | None
    """Name of the vision-language model, as the SLAM states it."""
    odometry: str
    house: HouseFigures
    run: WalkFigures
    labels: LabelFigures
    rooms: RoomFigures
    floors: FloorFigures
    loops: LoopFigures
    place_recognition: Mapping[str, MatchFigures]
    """Figures of place recognition by the least number of right matches for which a query counts as a true positive. The
    keys are the numbers in `MATCHES`, as text."""
    coverage: CoverageFigures
    trajectory: TrajectoryFigures
    planning: PlanningFigures
    time: TimeFigures
    versions: Mapping[str, str | None]
    scenario: str
    """Content hash of the scenario."""
    faults: FaultFigures | None = None

    def data(self) -> dict[str, Any]:
        """Return the contents of result.json. Runs without faults have no entry "faults"."""
        data = {"schema": SCHEMA} | asdict(self)
        if self.faults is None:
            del data["faults"]
        return data

    def known(self, name: str) -> float:
        """Return the figure with a dotted name, which a benchmark needs. Raises `SimError` if the run cannot have it."""
        value = self[name]
        if value is None:
            raise SimError(
                f"{name} is null for seed {self.seed}; valid: a run in which the SLAM estimates what {name} needs"
            )
        return float(value)

    def __getitem__(self, name: str) -> Any:
        """Return the figure with a dotted name, such as "labels.accuracy"; None below `faults` if the run has no faults.

        Raises KeyError that lists the valid names.
        """
        parts = name.split(".")
        if self.faults is None and ".".join(parts[:2]) in _OF_FAULTS:
            return None
        value: Any = self
        for k, part in enumerate(parts):
            choices = value if isinstance(value, Mapping) else getattr(value, "__dict__", {})
            if part not in choices:
                valid = ", ".join(choices) or repr(".".join(parts[:k]))
                raise KeyError(f"{name!r}: no figure {part!r}; valid: {valid}")
            value = choices[part]
        return value


def figure_meant(kind: Any, word: str) -> str:
    """Return a guess at the figure that a misspelt word means, such as " (did you mean 'pq'?)"; "" without a guess.

    `kind` is the class of results that has no figure of this name. The guess may be a figure deeper in this class. If
    several figures there have the same last name, the guess names all of them: 'labels.accuracy' and 'floors.accuracy'.
    """
    names = _figures(kind)
    near, deep = [*get_type_hints(kind), *names], [name.rpartition(".")[2] for name in names]
    likeness = 0.5 if len(word) <= _SHORT else 0.6
    for guess in difflib.get_close_matches(word, near + deep, n=1, cutoff=likeness):
        meant = [guess] if guess in near else [name for name, last in zip(names, deep, strict=True) if last == guess]
        return f" (did you mean {' or '.join(map(repr, meant))}?)"
    return ""


def _figures(kind: Any) -> list[str]:
    """Return the dotted names of all figures of a class of results."""
    found = []
    for name, hint in get_type_hints(kind).items():
        found += [f"{name}.{inner}" for inner in _figures(hint)] if is_dataclass(hint) else [name]
    return found
