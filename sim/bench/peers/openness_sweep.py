"""`lexis-sim bench openness`: rooms by LEXIS and by baselines, in the same houses with more and more open walls."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from types import MappingProxyType

import numpy as np

from lexis.files.replace import replaced_file
from sim.baselines.rooms import (
    LEXIS_VARIANTS,
    DistanceTransform,
    HydraPlaces,
    MapRooms,
    Morphological,
    Voronoi,
    WordlessLexis,
)
from sim.bench.encoders.table import import_matplotlib
from sim.bench.houses import configs
from sim.bench.row_files import write_rows
from sim.errors import SimError
from sim.harness import Scenario, SlamUnderTest, evaluate, run
from sim.harness.adapters import GeometricRooms, Lexis
from sim.harness.world_tests import FEATURES_FRAME_RATE_HZ

OPENNESS = (0.0, 0.3, 0.6, 0.9)
"""Values of openness of every house."""
IMAGES = (".png", ".svg")
"""File endings of plots."""


def _lexis(name: str, scenario: Scenario) -> SlamUnderTest:
    return Lexis(scenario.encoder, LEXIS_VARIANTS[name])


METHODS: Mapping[str, Callable[[Scenario], SlamUnderTest]] = MappingProxyType(
    {name: partial(_lexis, name) for name in LEXIS_VARIANTS}
    | {
        "LEXIS, one label": lambda scenario: WordlessLexis(),
        "positions alone": lambda scenario: GeometricRooms(),
        "morphological": lambda scenario: MapRooms.of(scenario, Morphological()),
        "distance transform": lambda scenario: MapRooms.of(scenario, DistanceTransform()),
        "Voronoi": lambda scenario: MapRooms.of(scenario, Voronoi()),
        "Hydra-like": lambda scenario: MapRooms.of(scenario, HydraPlaces()),
    }
)
"""The SLAM for a scenario, by the name of the method. The last four are given the true map of the scenario's house."""


@dataclass(frozen=True)
class SweepRow:
    """Figures of rooms by one method in the house of one seed, at one openness."""

    method: str
    openness: float
    """Openness that the house was changed to; a house that cannot be opened as far has a lower openness."""
    seed: int
    pq: float
    """Panoptic quality of rooms."""
    splits: int
    """Number of surplus rooms in one true room; see `lexis.evaluation.rooms.RoomScores`."""
    merges: int
    """Number of surplus true rooms in one found room."""


def sweep(preset: str, seeds: Sequence[int], openness: Sequence[float] = OPENNESS) -> Iterator[SweepRow]:
    """Let every method of `METHODS` find rooms in the same houses at each openness, on the feature sensor.

    Raises `WorldsError` for an openness outside [0, 1].
    """
    usual = Scenario(preset=preset, fidelity="features", frame_rate_hz=FEATURES_FRAME_RATE_HZ)
    for value in openness:
        for scenario in configs(usual, seeds, value):
            for name, slam in METHODS.items():
                rooms = evaluate(run(scenario, slam(scenario))).rooms
                yield SweepRow(name, value, scenario.seed, rooms.pq or 0.0, rooms.splits or 0, rooms.merges or 0)


@dataclass(frozen=True)
class SweepMean:
    """Figures of one method at one openness: means over houses, and the standard deviation of the panoptic quality."""

    pq: float
    pq_std: float
    splits: float
    merges: float


def means(rows: Sequence[SweepRow]) -> dict[str, dict[float, SweepMean]]:
    """Average the rows of all houses, by method and openness."""
    found: dict[str, dict[float, SweepMean]] = {}
    for method, openness in dict.fromkeys((row.method, row.openness) for row in rows):
        mine = [(row.pq, row.splits, row.merges) for row in rows if (row.method, row.openness) == (method, openness)]
        (pq, splits, merges), pq_std = np.mean(mine, axis=0).tolist(), float(np.std([row[0] for row in mine]))
        found.setdefault(method, {})[openness] = SweepMean(pq, pq_std, splits, merges)
    return found


def check_files(files: Sequence[Path]) -> None:
    """Check the files to write before the minutes of work. Raises `SimError`."""
    for path in files:
        if not path.parent.is_dir():
            raise SimError(f"{path}: no folder {path.parent}; valid: a file in a folder that exists")
        if path.suffix not in (".csv", *IMAGES):
            raise SimError(f"{path}: unknown ending; valid: .csv, .png or .svg")
        if path.suffix in IMAGES:
            import_matplotlib()


def write_sweep(rows: Sequence[SweepRow], path: Path) -> None:
    """Write the rows as CSV, or draw them, as the ending of the path says. Raises `SimError` without matplotlib."""
    if path.suffix in IMAGES:
        draw_sweep(means(rows), path)
        return
    write_rows(rows, path)


def draw_sweep(found: Mapping[str, Mapping[float, SweepMean]], path: Path) -> None:
    """Draw panoptic quality, splits and merges against openness, as PNG or SVG."""
    matplotlib = import_matplotlib()
    with matplotlib.rc_context({"svg.hashsalt": "lexis"}):
        figure = matplotlib.figure.Figure(figsize=(13.0, 4.6), layout="constrained")
        panels = figure.subplots(1, 3)
        for name, points in found.items():
            style = {"linestyle": "-" if name.startswith("LEXIS") else "--", "linewidth": 2.6 if name == "LEXIS" else 1.3}
            values = list(points)
            spread = [points[each].pq_std for each in values]
            panels[0].errorbar(values, [points[each].pq for each in values], spread, capsize=2, label=name, **style)
            for panel, what in zip(panels[1:], ("splits", "merges"), strict=True):
                panel.plot(values, [getattr(points[each], what) for each in values], marker="o", markersize=3, **style)
        for panel, title in zip(panels, ("panoptic quality of rooms", "splits per house", "merges per house"), strict=True):
            panel.set(title=title, xlabel="openness")
            panel.grid(alpha=0.25)
        panels[0].set(ylim=(0.0, 1.0))
        figure.legend(loc="outside right center")
        with replaced_file(path) as beside:
            figure.savefig(
                beside, format=path.suffix[1:], dpi=110, metadata={"Date": None} if path.suffix == ".svg" else None
            )
