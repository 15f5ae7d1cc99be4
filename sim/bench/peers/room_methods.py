"""`lexis-sim bench rooms`: the methods by which LEXIS finds labels and rooms, on the same walks on the feature sensor."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

from lexis.config import PAPER, Config
from sim.bench.houses import for_seeds
from sim.bench.row_files import mean_and_std
from sim.harness import Scenario, evaluate, run
from sim.harness.adapters import Lexis
from sim.harness.results import RunResult
from sim.harness.world_tests import FEATURES_FRAME_RATE_HZ

METHODS: Mapping[str, Config] = MappingProxyType(
    {
        "vote, distance (paper)": Config(labels=PAPER.labels, segmentation=PAPER.segmentation),
        "sight, distance": Config(segmentation=PAPER.segmentation),
        "vote, sight": Config(labels=PAPER.labels),
        "sight, sight": Config(),
    }
)
"""Settings of LEXIS by the names of their methods for labels and for rooms."""


@dataclass(frozen=True)
class MethodRow:
    """Figures of one method over several houses: means, and standard deviations where named.

    Each figure is over the houses that have it; see `mean_and_std`.
    """

    method: str
    labels: float | None
    """Label accuracy."""
    labels_std: float | None
    rooms: float | None
    """Panoptic quality of rooms."""
    rooms_std: float | None
    splits_and_merges: float | None
    """Number of surplus rooms by splitting and by merging, per house; see `lexis.evaluation.rooms.RoomScores`."""


def compare_methods(preset: str, seeds: Sequence[int], openness: float | None = None) -> Iterator[MethodRow]:
    """Let LEXIS map the same houses by each of `METHODS`, and yield the figures of each method.

    Walks, odometry and percepts are equal for all methods. Raises `WorldsError` for an openness outside [0, 1].
    """
    usual = Scenario(preset=preset, fidelity="features", frame_rate_hz=FEATURES_FRAME_RATE_HZ)
    slams = {name: Lexis(config=config) for name, config in METHODS.items()}
    found: dict[str, list[RunResult]] = {name: [] for name in METHODS}
    for scenario in for_seeds(usual, seeds, openness):
        for name, slam in slams.items():
            found[name].append(evaluate(run(scenario, slam), []))
    for name, results in found.items():
        labels, rooms = (mean_and_std(each[figure] for each in results) for figure in ("labels.accuracy", "rooms.pq"))
        wrong, _ = mean_and_std(_splits_and_merges(each) for each in results)
        yield MethodRow(name, *labels, *rooms, wrong)


def _splits_and_merges(result: RunResult) -> int | None:
    splits, merges = result.rooms.splits, result.rooms.merges
    return None if splits is None or merges is None else splits + merges
