"""`lexis-sim bench fidelity`: how well runs with simulated features predict runs with rendered images, house by house.

LEXIS maps the same walks through the same houses in both fidelities. The benchmark compares label accuracy and panoptic
quality of rooms. LEXIS uses the methods of the paper for labels and rooms, which need embeddings and poses only. Loop
closing is off, since it hardly changes these figures. To save time, the walks have few frames, and images are rendered in
the small size that LEXIS uses.
"""

import collections
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from scipy.stats import spearmanr

from lexis.config import PAPER, Config, LandmarkConfig
from lexis.perception import Encoder
from sim.bench.row_files import mean_and_std
from sim.feature_fitting.fit_samples import choices
from sim.feature_sensor.model import MINI_FEATURES, load_features
from sim.feature_sensor.sensor import FeatureSensor
from sim.fidelity import FIDELITIES
from sim.harness import Scenario, evaluate, run
from sim.harness.adapters import Lexis
from sim.harness.run_settings import house_spec
from sim.harness.walk import walk
from sim.render.rig import RigConfig, build_rig
from worlds.presets import PRESETS
from worlds.spec import HouseSpec

HOUSE_FIGURES = ("accuracy", "baseline", "pq")
"""The figures that are compared: fields of `HousePair`."""
_FRAME_RATE_HZ = 1.3
"""Frames per second [Hz]: one frame per 0.54 m of path, so that every frame becomes a keyframe, except while turning."""
_SPEED_FRAMES, _WARM_UP = 2000, 100
_IMAGE_PX = (480, 360)
_LOOKS = (("texture", "poor"), ("light", "dim"), ("light", "evening"))
"""Unusual looks, which the feature sensor ignores: settings of a house's appearance, as (field, value)."""
_LOOKS_SHARE = 5
"""For every `_LOOKS_SHARE` houses with usual looks, one house with each look of `_LOOKS` is added."""
_NO_LANDMARKS = Config(
    labels=PAPER.labels, segmentation=PAPER.segmentation, landmarks=LandmarkConfig(akaze_threshold=0.1, max_features=8)
)
"""Settings of LEXIS that find hardly any key points, which saves time. The methods of the paper for labels and rooms need no
key points, and loops are off; the usual methods would need the landmarks of both fidelities."""


@dataclass(frozen=True)
class HousePair:
    """Figures of one house in both fidelities, as pairs (rendered, features). A figure that a run cannot have is None."""

    group: str
    """Preset of the house, or the name of its look if the look is unusual."""
    name: str
    accuracy: tuple[float | None, float | None]
    baseline: tuple[float | None, float | None]
    """Label accuracy before refinement."""
    pq: tuple[float | None, float | None]
    """Panoptic quality of rooms."""


@dataclass(frozen=True)
class Agreement:
    """Agreement between runs with features and rendered runs in one figure, over several houses.

    The means are None without a house.
    """

    houses: int
    """Number of houses with the figure in both fidelities; the others are left out."""
    rho: float | None
    """Spearman's rank correlation; None for fewer than three houses, or if one fidelity gives all houses the same value."""
    rendered: float | None
    """Mean of the figure over rendered runs."""
    features: float | None
    """Mean of the compared figure over the runs of fidelity "features" (without images)."""
    mean_absolute_difference: float | None
    """Mean over the houses of the absolute difference between the rendered run and the run with features."""


def mixed_houses(count: int, first_seed: int) -> list[tuple[str, Scenario]]:
    """Draw `count` houses of mixed presets, openness and clutter, then some more with unusual looks.

    Returns pairs (group, scenario); for the group see `HousePair`.
    """
    usual = choices(count, first_seed)
    mixed = [(choice.preset, _scenario(choice.spec())) for choice in usual]
    extra = choices(len(_LOOKS) * (count // _LOOKS_SHARE), first_seed + count)
    for i, choice in enumerate(extra):
        field, look = _LOOKS[i % len(_LOOKS)]
        spec = choice._replace(openness=None, clutter=1.0).spec()
        looks = spec.appearance.model_copy(update={field: look})
        mixed.append((f"{look} {field}", _scenario(spec.model_copy(update={"appearance": looks}))))
    return mixed


def _scenario(spec: HouseSpec) -> Scenario:
    return Scenario(
        house=spec,
        seed=spec.seed,
        frame_rate_hz=_FRAME_RATE_HZ,
        rig=RigConfig("wide", *_IMAGE_PX),
    )


def compare_fidelities(
    scenarios: Sequence[tuple[str, Scenario]], encoder: Encoder, feature_model: Path | None = None
) -> Iterator[HousePair]:
    """Run LEXIS on every scenario twice, on rendered images and on features, and yield the figures of both runs.

    `scenarios` are pairs (name of a group of scenarios, scenario).
    """
    for group, scenario in scenarios:
        figures = []
        for fidelity in FIDELITIES:
            slam = Lexis(encoder, _NO_LANDMARKS, loops=False)
            result = evaluate(run(replace(scenario, fidelity=fidelity, feature_model=feature_model), slam))
            figures.append((result.labels.accuracy, result.labels.accuracy_baseline, result.rooms.pq))
        rendered, features = figures
        yield HousePair(group, house_spec(scenario).name, *zip(rendered, features, strict=True))


def percepts_per_second(first_seed: int, feature_model: Path | None = None) -> float:
    """Measure how many embeddings of views in a furnished home the feature sensor draws per second of processor time."""
    walked = walk(Scenario(preset="home", seed=first_seed, frame_rate_hz=_FRAME_RATE_HZ))
    poses = np.tile(walked.tour.T_W_B, (1 + _SPEED_FRAMES // len(walked.tour.stamps), 1, 1))[:_SPEED_FRAMES]
    sensor = FeatureSensor(load_features(feature_model or MINI_FEATURES), build_rig(Scenario().rig).front, first_seed)
    houses = [walked.house] * _SPEED_FRAMES
    collections.deque(sensor.tour(houses[:_WARM_UP], poses).percepts(), maxlen=0)
    start = time.process_time()
    collections.deque(sensor.tour(houses, poses).percepts(), maxlen=0)
    return _SPEED_FRAMES / (time.process_time() - start)


def agreement(pairs: Sequence[tuple[float | None, float | None]]) -> Agreement:
    """Compute the agreement in one figure from a pair (rendered, features) for each house."""
    rendered, features = np.array([pair for pair in pairs if None not in pair], float).reshape(-1, 2).T
    ranked = len(rendered) > 2 and np.ptp(rendered) > 0.0 and np.ptp(features) > 0.0
    rho = float(spearmanr(rendered, features).statistic) if ranked else None
    means = (mean_and_std(values)[0] for values in (rendered, features, np.abs(rendered - features)))
    return Agreement(len(rendered), rho, *means)


def summarised(pairs: Sequence[HousePair]) -> Iterator[tuple[str, str, Agreement]]:
    """Yield triples (name of a set of houses, name of a figure, agreement in this figure).

    First come all figures over all houses with usual looks, then the label accuracy of each group.
    """
    usual = [pair for pair in pairs if pair.group in PRESETS]
    for name in HOUSE_FIGURES:
        yield "usual looks", name, agreement([getattr(pair, name) for pair in usual])
    for group in dict.fromkeys(pair.group for pair in pairs):
        yield group, HOUSE_FIGURES[0], agreement([pair.accuracy for pair in pairs if pair.group == group])
