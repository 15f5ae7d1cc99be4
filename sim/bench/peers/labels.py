"""`lexis-sim bench table2`: label accuracy of LEXIS and of Hydra-like rooms that objects name (Table II of the paper)."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np
from jaxtyping import Int

from lexis.config import PAPER
from lexis.encoder.open_clip_encoder import load_encoder
from lexis.perception import TextEncoder
from sim.baselines.rooms import HydraPlaces, ObjectVotes
from sim.baselines.rooms.object_scores import Counted, ObjectScores, RelativeSimilarity, Similarity, count_rooms
from sim.bench.houses import for_seeds
from sim.bench.peers.side_by_side import run_side_by_side
from sim.bench.row_files import grouped, mean_and_std
from sim.errors import SimError
from sim.fidelity import Fidelity
from sim.harness import Run, Scenario, SlamUnderTest, evaluate
from sim.harness.adapters import Lexis
from sim.harness.world_tests import usual_rate_hz
from sim.wording import seeds_text

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
_REFINED, _COUNTED = "LEXIS, refined (paper)", "Hydra-like, counts"


@dataclass(frozen=True)
class LabelRow:
    """Labels by one method in one house."""

    preset: str
    seed: int
    method: str
    accuracy: float | None
    """Share of keyframes with the right label; None: no labels are estimated."""
    rooms: float | None
    """Share of found rooms with the right label (see `room_accuracy`), as Hydra is evaluated; None: there are no rooms."""


@dataclass(frozen=True)
class LabelMean:
    """Labels by one method over the houses of one preset: mean and standard deviation of the accuracy, mean over rooms.

    Each figure is over the houses that have it; see `mean_and_std`.
    """

    accuracy: float | None
    std: float | None
    rooms: float | None


def methods(scenario: Scenario, encoder: TextEncoder) -> dict[str, SlamUnderTest]:
    """Return the systems for a scenario, by the names of their methods."""

    def hydra(scores: ObjectScores) -> SlamUnderTest:
        return ObjectVotes.of(scenario, HydraPlaces(), scores)

    return {
        _REFINED: Lexis(encoder, PAPER),
        "LEXIS": Lexis(encoder),
        "Hydra-like, similarity": hydra(Similarity(encoder)),
        "Hydra-like, relative similarity": hydra(RelativeSimilarity(encoder)),
        _COUNTED: hydra(Counted(count_rooms(scenario.preset, TRAINING_SEEDS))),
    }


def compare_labels(presets: Sequence[str], seeds: Sequence[int], fidelity: Fidelity) -> Iterator[list[LabelRow]]:
    """Let every method label the keyframes of the same walks; yields the rows of one walk for each preset and seed.

    Two rows are no methods of their own: the labels of the paper's LEXIS before refinement, and the best labels that the
    rooms of the Hydra-like method could have. Raises `SimError` for houses that a method was trained on.
    """
    if set(seeds) & set(TRAINING_SEEDS):
        raise SimError(
            f"{seeds_text(seeds)}: the method {_COUNTED!r} learns from some of these houses; valid: other seeds "
            f"than {TRAINING_SEEDS[0]} to {TRAINING_SEEDS[-1]}"
        )
    encoder = load_encoder(Scenario.encoder)
    for preset in presets:
        for scenario in for_seeds(Scenario(preset=preset, fidelity=fidelity, frame_rate_hz=usual_rate_hz(fidelity)), seeds):
            runs = run_side_by_side(scenario, methods(scenario, encoder))
            found = {
                "LEXIS, baseline (paper)": (evaluate(runs[_REFINED]).labels.accuracy_baseline, None),
                **{name: _figures(each) for name, each in runs.items()},
                "Hydra-like, best labels": _figures(with_best_labels(runs[_COUNTED])),
            }
            yield [LabelRow(preset, scenario.seed, name, *figures) for name, figures in found.items()]


def _figures(run: Run) -> tuple[float | None, float | None]:
    """Return the label accuracy over keyframes and over found rooms."""
    labels, rooms = run.estimate.labels, run.estimate.rooms
    over_rooms = None if labels is None or rooms is None else room_accuracy(labels, rooms, run.true_labels)
    return evaluate(run).labels.accuracy, over_rooms


def with_best_labels(run: Run) -> Run:
    """Return the run with labels that are the most frequent true label of each estimated room."""
    if run.estimate.rooms is None:
        return run
    return replace(run, estimate=replace(run.estimate, labels=_most_frequent(run.true_labels, run.estimate.rooms)))


def room_accuracy(labels: Int[np.ndarray, "n"], rooms: Int[np.ndarray, "n"], truth: Int[np.ndarray, "n"]) -> float:
    """Return the share of found rooms whose most frequent label is the most frequent true label of their keyframes."""
    _, first = np.unique(rooms, return_index=True)
    return float((_most_frequent(labels, rooms)[first] == _most_frequent(truth, rooms)[first]).mean())


def _most_frequent(values: Int[np.ndarray, "n"], rooms: Int[np.ndarray, "n"]) -> Int[np.ndarray, "n"]:
    """Return, for every keyframe, the most frequent value in its room; values are -1 or more."""
    _, room = np.unique(rooms, return_inverse=True)
    counts = np.zeros((room.max() + 1, values.max() + 2), int)
    np.add.at(counts, (room, values + 1), 1)
    return np.asarray(counts.argmax(axis=1)[room] - 1)


def means(rows: Sequence[LabelRow]) -> dict[str, dict[str, LabelMean]]:
    """Average over houses, by method and preset."""
    found: dict[str, dict[str, LabelMean]] = {}
    for (method, preset), mine in grouped(rows, "method", "preset").items():
        over_rooms, _ = mean_and_std(row.rooms for row in mine)
        found.setdefault(method, {})[preset] = LabelMean(*mean_and_std(row.accuracy for row in mine), over_rooms)
    return found
