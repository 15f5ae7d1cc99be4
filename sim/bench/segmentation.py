"""`lexis-sim bench segmentation`: the whole chain on several houses of a preset, with the default encoder unless told."""

from collections.abc import Iterator, Sequence
from dataclasses import astuple, dataclass
from typing import Any

import numpy as np

from lexis.encoder.open_clip_encoder import load_encoder
from sim.bench.houses import configs
from sim.harness import RunConfig, evaluate, run, try_plans
from sim.harness.loops import edge_truth


@dataclass(frozen=True)
class SegmentationRow:
    """The figures of one house."""

    baseline: float
    """Label accuracy before refinement."""
    refined: float
    """And after it."""
    pq: float
    floors: float
    odometry_m: float
    """ATE [m]."""
    ate_m: float
    false_loops: int
    heavy_false_loops: int
    """False edges that keep a weight above 0.5."""
    loop_recall: float | None
    """None where nothing was revisited."""
    plans: float | None
    """Share that reach their room; None where none was asked for."""


def run_houses(
    config: RunConfig, seeds: Sequence[int], openness: float | None = None
) -> Iterator[tuple[int, SegmentationRow]]:
    """One run per seed, all else as in `config`; for `openness` see `sim.bench.houses.configs`."""
    encoder = load_encoder(config.encoder)
    for own in configs(config, seeds, openness):
        finished = run(own, encoder)
        result = evaluate(finished, try_plans(finished))
        is_true = edge_truth(finished)
        yield (
            own.seed,
            SegmentationRow(
                result["labels"]["accuracy_baseline"],
                result["labels"]["accuracy"],
                result["rooms"]["pq"],
                result["floors"]["accuracy"],
                result["trajectory"]["ate_odometry_m"],
                result["trajectory"]["ate_m"],
                result["loops"]["false"],
                int((finished.map.loop_weights[~is_true] > 0.5).sum()),
                result["loops"]["recall"],
                result["planning"]["success"],
            ),
        )


def mean_and_spread(rows: Sequence[Any]) -> tuple[list[float | None], list[float | None]]:
    """Mean and standard deviation of every figure of dataclasses over the houses that have it; None where none has."""
    columns = [[value for value in column if value is not None] for column in zip(*map(astuple, rows), strict=True)]
    return [float(np.mean(c)) if c else None for c in columns], [float(np.std(c)) if c else None for c in columns]
