"""`lexis-sim bench table2`: label accuracy of LEXIS and of Hydra-like rooms that objects name (Table II of the paper)."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from lexis.config import PAPER
from lexis.encoder.open_clip_encoder import load_encoder
from sim.baselines.rooms import HydraPlaces, ObjectVotes
from sim.baselines.rooms.object_scores import Counted, ObjectScores, RelativeSimilarity, Similarity, count_objects
from sim.bench.houses import configs
from sim.bench.peers.side_by_side import run_side_by_side
from sim.fidelity import Fidelity
from sim.harness import Scenario, SlamUnderTest
from sim.harness.adapters import Lexis
from sim.harness.figures import evaluate
from sim.harness.world_tests import FEATURES_FRAME_RATE_HZ

PAPER_ACCURACY: Mapping[str, Mapping[str, tuple[float, float]]] = MappingProxyType(
    {
        "LEXIS, baseline": {
            "uh2-apt": (0.5131, 0.0324),
            "uh2-office": (0.6899, 0.0107),
            "ori": (0.6809, 0.0164),
            "home": (0.6121, 0.0112),
        },
        "LEXIS, refined": {
            "uh2-apt": (0.5736, 0.0127),
            "uh2-office": (0.7603, 0.0169),
            "ori": (0.7922, 0.0423),
            "home": (0.7892, 0.0301),
        },
        "Hydra, HRNet": {"uh2-apt": (0.38, 0.217), "uh2-office": (0.284, 0.069)},
        "Hydra, OneFormer": {"uh2-apt": (0.45, 0.112), "uh2-office": (0.27, 0.101)},
    }
)
"""Table II of the paper: accuracy and its standard deviation over 5 runs, by method and data set, in houses other than
ours. Figures of Hydra are shares of rooms, and figures of LEXIS are shares of keyframes."""
TRAINING_SEEDS = range(100, 120)
"""Houses of the same preset in which objects are counted for the method "Hydra-like, counts"."""
BASELINE = "LEXIS, baseline (paper)"
_REFINED = "LEXIS, refined (paper)"


@dataclass(frozen=True)
class LabelRow:
    """Label accuracy of one method in one house."""

    preset: str
    seed: int
    method: str
    accuracy: float
    """Share of keyframes with the right label."""


@dataclass(frozen=True)
class LabelMean:
    """Label accuracy of one method: mean and standard deviation over the houses of one preset."""

    accuracy: float
    std: float


def methods(scenario: Scenario) -> dict[str, SlamUnderTest]:
    """The systems for a scenario by the names of their methods. Labels before refinement are taken from the second."""
    encoder = load_encoder(scenario.encoder)

    def hydra(scores: ObjectScores) -> SlamUnderTest:
        return ObjectVotes.of(scenario, HydraPlaces(), scores)

    return {
        "LEXIS": Lexis(encoder),
        _REFINED: Lexis(encoder, PAPER),
        "Hydra-like, similarity": hydra(Similarity(encoder)),
        "Hydra-like, relative similarity": hydra(RelativeSimilarity(encoder)),
        "Hydra-like, counts": hydra(Counted(count_objects(scenario.preset, TRAINING_SEEDS))),
    }


def compare_labels(presets: Sequence[str], seeds: Sequence[int], fidelity: Fidelity) -> Iterator[LabelRow]:
    """Let every method label the keyframes of the same walks, one walk for each preset and seed."""
    rate_hz = FEATURES_FRAME_RATE_HZ if fidelity == "features" else Scenario.frame_rate_hz
    for preset in presets:
        for scenario in configs(Scenario(preset=preset, fidelity=fidelity, frame_rate_hz=rate_hz), seeds):
            for name, finished in run_side_by_side(scenario, methods(scenario)).items():
                found = evaluate(finished).labels
                if name == _REFINED:
                    yield LabelRow(preset, scenario.seed, BASELINE, found.accuracy_baseline or 0.0)
                yield LabelRow(preset, scenario.seed, name, found.accuracy or 0.0)


def means(rows: Sequence[LabelRow]) -> dict[str, dict[str, LabelMean]]:
    """Average over houses, by method and preset."""
    found: dict[str, dict[str, LabelMean]] = {}
    for method, preset in dict.fromkeys((row.method, row.preset) for row in rows):
        mine = [row.accuracy for row in rows if (row.method, row.preset) == (method, preset)]
        found.setdefault(method, {})[preset] = LabelMean(float(np.mean(mine)), float(np.std(mine)))
    return found
