"""`lexis-sim bench openness` and `bench sweep`: rooms by LEXIS and by baselines, while one difficulty of the runs grows.

All methods follow the same walks in the same houses. Between the values of a difficulty, nothing else changes, except that
walks go through open walls and around furniture.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from types import MappingProxyType
from typing import Any, TypeAlias, get_args

import numpy as np
from jaxtyping import Float64

from sim.baselines.rooms import (
    LEXIS_VARIANTS,
    DistanceTransform,
    HydraPlaces,
    MapRooms,
    Morphological,
    Voronoi,
    WordlessLexis,
)
from sim.bench.houses import for_seeds, varied
from sim.bench.peers.own_methods import OwnSegmentation, naming_run
from sim.bench.peers.side_by_side import run_side_by_side
from sim.bench.row_files import grouped, is_picture, mean_and_std, picture, write_rows
from sim.fidelity import Fidelity
from sim.harness import Scenario, SlamUnderTest, evaluate
from sim.harness.adapters import GeometricRooms, Lexis
from sim.harness.run_settings import house_spec, in_house
from sim.harness.walk import with_walk_m
from sim.harness.world_tests import RENDER_FRAME_RATE_HZ, usual_rate_hz
from worlds.spec import LightName, TextureName
from worlds.variant import in_light, in_texture

Value: TypeAlias = float | str
Method: TypeAlias = Callable[[Scenario], SlamUnderTest]
"""A function that makes the SLAM for a scenario."""
_NO_SEGMENTATIONS: Mapping[str, OwnSegmentation] = MappingProxyType({})


def _lexis(name: str, scenario: Scenario) -> SlamUnderTest:
    return Lexis(scenario.encoder, LEXIS_VARIANTS[name])


METHODS: Mapping[str, Method] = MappingProxyType(
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
class Difficulty:
    """One property of a run that a sweep changes."""

    values: tuple[Value, ...]
    changed: Callable[[Scenario, Any], Scenario]
    """Returns a scenario in which the property has the value."""
    methods: tuple[str, ...]
    """Names of the methods that are compared."""
    fidelity: Fidelity = "features"
    """Fidelity of the runs: "render" for a property that shows in images only, as lighting and textures do."""
    frame_rate_hz: float | None = None
    """Frames per second [Hz]; None: the usual rate of the fidelity, with which keyframes on features are 0.7 m apart."""
    adjusted: Callable[[SlamUnderTest, Any], SlamUnderTest] = lambda slam, value: slam
    """Returns the SLAM with the settings that belong to the value, for a property of the SLAM rather than of the run."""


def _spaced(slam: SlamUnderTest, spacing_m: float) -> SlamUnderTest:
    """Return a LEXIS with the same settings that selects keyframes at another distance."""
    if not isinstance(slam, Lexis):
        return slam
    return Lexis(slam.encoder, replace(slam.config, keyframes=replace(slam.config.keyframes, spacing_m=spacing_m)))


_WITHOUT_MAP = ("LEXIS", "LEXIS, paper", "positions alone")
DIFFICULTIES: Mapping[str, Difficulty] = MappingProxyType(
    {
        "openness": Difficulty(
            (0.0, 0.3, 0.6, 0.9),
            lambda scenario, value: varied(scenario, openness=value),
            tuple(METHODS),
        ),
        "clutter": Difficulty(
            (0.0, 1.0, 2.0, 4.0),
            lambda scenario, value: varied(scenario, clutter=value),
            (*_WITHOUT_MAP, "distance transform", "Voronoi"),
        ),
        "odometry": Difficulty(
            ("perfect", "multicam", "mono", "degraded"),
            lambda scenario, value: replace(scenario, odometry=value),
            _WITHOUT_MAP,
        ),
        "spacing": Difficulty(
            (0.25, 0.5, 1.0, 2.0),
            lambda scenario, value: scenario,
            tuple(LEXIS_VARIANTS),
            adjusted=_spaced,
            frame_rate_hz=RENDER_FRAME_RATE_HZ,
        ),
        "light": Difficulty(
            get_args(LightName),
            lambda scenario, value: in_house(scenario, in_light(house_spec(scenario), value)),
            _WITHOUT_MAP,
            "render",
        ),
        "texture": Difficulty(
            get_args(TextureName),
            lambda scenario, value: in_house(scenario, in_texture(house_spec(scenario), value)),
            _WITHOUT_MAP,
            "render",
        ),
    }
)
"""The difficulties by name; "spacing" is the distance between keyframes [m]. The true map depends on openness only: clutter,
light and drift do not change it."""


@dataclass(frozen=True)
class SweepRow:
    """Figures of one method in the house of one seed, at one value of the difficulty."""

    preset: str
    fidelity: Fidelity
    method: str
    value: Value
    """The value to which the run was changed; a house that cannot be opened as far as this has a lower openness."""
    seed: int
    labels: float | None
    """Share of the keyframes with the right label; None for a method that estimates no labels."""
    pq: float | None
    """Panoptic quality of rooms; None, as are the next two, for a run that has no figures of rooms."""
    splits: int | None
    """Number of surplus rooms in one true room; see `lexis.evaluation.rooms.RoomScores`."""
    merges: int | None
    """Number of surplus true rooms in one found room."""


def _segmenting(segmentation: OwnSegmentation, scenario: Scenario) -> SlamUnderTest:
    return MapRooms.of(scenario, segmentation)


def sweep(
    preset: str,
    seeds: Sequence[int],
    difficulty: Difficulty = DIFFICULTIES["openness"],
    length_m: float | None = None,
    rate_hz: float | None = None,
    own: Mapping[str, OwnSegmentation] = _NO_SEGMENTATIONS,
) -> Iterator[SweepRow]:
    """Let every method of the difficulty, and the segmentations `own`, find rooms in the same houses at each of its values.

    `length_m` is the length of the walks [m], see `with_walk_m`. None: the usual length of a scenario. `rate_hz` is the
    number of frames per second [Hz]. None: that of the difficulty. Raises `OwnMethodError`, which names the house, if a
    segmentation of `own` raises an exception, or returns what is not valid.
    """
    rate_hz = rate_hz or difficulty.frame_rate_hz or usual_rate_hz(difficulty.fidelity)
    usual = Scenario(preset=preset, fidelity=difficulty.fidelity, frame_rate_hz=rate_hz)
    methods: dict[str, Method] = {name: METHODS[name] for name in difficulty.methods}
    methods |= {name: partial(_segmenting, each) for name, each in own.items()}
    for value in difficulty.values:
        for scenario in for_seeds(usual, seeds):
            if length_m is not None:
                scenario = with_walk_m(scenario, length_m)
            changed = difficulty.changed(scenario, value)
            slams = {name: difficulty.adjusted(method(changed), value) for name, method in methods.items()}
            with naming_run(f"{preset}, seed {scenario.seed}, at the value {value}"):
                runs = run_side_by_side(changed, slams)
            for name, finished in runs.items():
                found = evaluate(finished)
                rooms = found.rooms.pq, found.rooms.splits, found.rooms.merges
                yield SweepRow(preset, difficulty.fidelity, name, value, scenario.seed, found.labels.accuracy, *rooms)


@dataclass(frozen=True)
class SweepMean:
    """Figures of one method at one value: means over houses, and the standard deviation of the panoptic quality.

    Each figure is over the houses that have it; see `mean_and_std`.
    """

    labels: float | None
    pq: float | None
    pq_std: float | None
    splits: float | None
    merges: float | None


def means(rows: Sequence[SweepRow]) -> dict[str, dict[Value, SweepMean]]:
    """Average the rows of all houses, by method and value."""
    found: dict[str, dict[Value, SweepMean]] = {}
    for (method, value), mine in grouped(rows, "method", "value").items():
        (labels, _), (pq, pq_std), (splits, _), (merges, _) = (
            mean_and_std(getattr(row, name) for row in mine) for name in ("labels", "pq", "splits", "merges")
        )
        found.setdefault(method, {})[value] = SweepMean(labels, pq, pq_std, splits, merges)
    return found


def write_sweep(rows: Sequence[SweepRow], name: str, houses: str, path: Path) -> None:
    """Write the rows as CSV, or draw them, as the ending of the path says.

    `name` is the difficulty's. `houses` describes the houses, as the title of the picture.

    Raises `SimError` without matplotlib.
    """
    if is_picture(path):
        draw_sweep(means(rows), name, houses, path)
        return
    write_rows(rows, path)


def draw_sweep(found: Mapping[str, Mapping[Value, SweepMean]], x_name: str, title: str, path: Path) -> None:
    """Draw panoptic quality, splits and merges against the values of a difficulty, as PNG or SVG.

    A figure that is None is not drawn.
    """

    def drawn(points: Mapping[Value, SweepMean], figure: str) -> Float64[np.ndarray, "values"]:
        return np.array([getattr(each, figure) for each in points.values()], float)  # None becomes NaN

    with picture(path, (13.0, 4.6)) as figure:
        panels = figure.subplots(1, 3)
        for name, points in found.items():
            style = {"linestyle": "-" if name.startswith("LEXIS") else "--", "linewidth": 2.6 if name == "LEXIS" else 1.3}
            style |= {"marker": "o", "markersize": 3}
            values = list(points)
            panels[0].errorbar(values, drawn(points, "pq"), drawn(points, "pq_std"), capsize=2, label=name, **style)
            for panel, what in zip(panels[1:], ("splits", "merges"), strict=True):
                panel.plot(values, drawn(points, what), **style)
        for panel, what in zip(panels, ("panoptic quality of rooms", "splits per house", "merges per house"), strict=True):
            panel.set(title=what, xlabel=x_name)
            panel.grid(alpha=0.25)
        panels[0].set(ylim=(0.0, 1.0))
        figure.suptitle(title)
        figure.legend(loc="outside right center")
