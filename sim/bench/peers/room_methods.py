"""`lexis-sim bench rooms`: the methods by which LEXIS finds labels and rooms, on the same walks on the feature sensor."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from lexis.config import PAPER, Config
from sim.bench.houses import configs
from sim.harness import Scenario, evaluate, run
from sim.harness.adapters import Lexis
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
    """Figures of one method over several houses: means, and standard deviations where named."""

    method: str
    labels: float
    """Label accuracy."""
    labels_std: float
    rooms: float
    """Panoptic quality of rooms."""
    rooms_std: float
    splits_and_merges: float
    """Number of surplus rooms by splitting and by merging, per house; see `lexis.evaluation.rooms.RoomScores`."""


def compare_methods(preset: str, seeds: Sequence[int], openness: float | None = None) -> Iterator[MethodRow]:
    """Let LEXIS map the same houses by each of `METHODS`, and yield the figures of each method.

    Walks, odometry and percepts are equal for all methods. Raises `WorldsError` for an openness outside [0, 1].
    """
    usual = Scenario(preset=preset, fidelity="features", frame_rate_hz=FEATURES_FRAME_RATE_HZ)
    slams = {name: Lexis(config=config) for name, config in METHODS.items()}
    found: dict[str, list[tuple[float, float, int]]] = {name: [] for name in METHODS}
    for scenario in configs(usual, seeds, openness):
        for name, slam in slams.items():
            result = evaluate(run(scenario, slam), [])
            wrong = (result.rooms.splits or 0) + (result.rooms.merges or 0)
            found[name].append((result.labels.accuracy or 0.0, result.rooms.pq or 0.0, wrong))
    for name, rows in found.items():
        (labels, rooms, wrong), (labels_std, rooms_std, _) = np.mean(rows, axis=0), np.std(rows, axis=0)
        yield MethodRow(name, float(labels), float(labels_std), float(rooms), float(rooms_std), float(wrong))
