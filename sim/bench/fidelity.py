"""`lexis-sim bench fidelity`: whether runs on features predict runs on renders, house by house.

Both fidelities map the same walks of the same houses. Label accuracy is compared, since loops change little of it; images
are few, and of the size that LEXIS takes.
"""

import collections
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from scipy.stats import spearmanr

from lexis.config import Config, LandmarkConfig
from lexis.perception import Encoder
from sim.feature_sensor.fit_samples import choices
from sim.feature_sensor.model import MINI_FEATURES, load_features
from sim.feature_sensor.sensor import FeatureSensor
from sim.fidelity import FIDELITIES
from sim.harness import RunConfig, evaluate, run
from sim.harness.parts import house_spec
from sim.harness.walk import walk
from sim.render.rig import make_rig
from worlds.presets import PRESETS
from worlds.spec import HouseSpec

FIGURES = ("accuracy", "baseline", "pq")
"""Of `HousePair`."""
_FRAME_RATE_HZ = 1.3
"""A frame every 0.54 m: every one is a keyframe, but in turns."""
_SPEED_FRAMES, _WARM_UP = 2000, 100
_IMAGE_PX = (480, 360)
_LOOKS = (("texture", "poor"), ("light", "dim"), ("light", "evening"))
"""What the feature sensor knows nothing of."""
_LOOKS_SHARE = 5
"""Of so many houses, one more of every look."""
_NO_LANDMARKS = Config(landmarks=LandmarkConfig(akaze_threshold=0.1, max_features=8))
"""Loops are off, so that key points are of no use."""


@dataclass(frozen=True)
class HousePair:
    """Figures of one house in both fidelities, rendered first."""

    group: str
    """Its family, or its looks where these are unusual."""
    name: str
    accuracy: tuple[float, float]
    baseline: tuple[float, float]
    """Accuracy before refinement."""
    pq: tuple[float, float]


@dataclass(frozen=True)
class Agreement:
    """How well one figure is predicted over several houses."""

    houses: int
    rho: float | None
    """Spearman's; None for fewer than three houses and where a fidelity tells none apart."""
    rendered: float
    """Mean."""
    features: float
    """Mean."""
    off: float
    """Mean absolute difference."""


def mixed_houses(count: int, first_seed: int) -> list[tuple[str, RunConfig]]:
    """Houses of mixed families, openness and clutter, then some more of unusual looks; each with its group."""
    usual = choices(count, first_seed)
    mixed = [(choice.preset, _config(choice.spec())) for choice in usual]
    extra = choices(len(_LOOKS) * (count // _LOOKS_SHARE), first_seed + count)
    for i, choice in enumerate(extra):
        field, look = _LOOKS[i % len(_LOOKS)]
        spec = choice._replace(openness=None, clutter=1.0).spec()
        looks = spec.appearance.model_copy(update={field: look})
        mixed.append((f"{look} {field}", _config(spec.model_copy(update={"appearance": looks}))))
    return mixed


def _config(spec: HouseSpec) -> RunConfig:
    return RunConfig(
        house=spec,
        seed=spec.seed,
        frame_rate_hz=_FRAME_RATE_HZ,
        loops=False,
        lexis=_NO_LANDMARKS,
        rig=make_rig("wide", *_IMAGE_PX),
    )


def compare(
    configs: Sequence[tuple[str, RunConfig]], encoder: Encoder, feature_model: Path | None = None
) -> Iterator[HousePair]:
    """Run every house in both fidelities."""
    for group, config in configs:
        figures = []
        for fidelity in FIDELITIES:
            result = evaluate(run(replace(config, fidelity=fidelity, feature_model=feature_model), encoder), [])
            figures.append((result["labels"]["accuracy"], result["labels"]["accuracy_baseline"], result["rooms"]["pq"]))
        rendered, features = figures
        yield HousePair(group, house_spec(config).name, *zip(rendered, features, strict=True))


def percepts_per_second(first_seed: int, feature_model: Path | None = None) -> float:
    """How many views of a furnished home the sensor looks at and draws embeddings for, per second of one core."""
    walked = walk(RunConfig(preset="home", seed=first_seed, frame_rate_hz=_FRAME_RATE_HZ))
    poses = np.tile(walked.tour.T_W_B, (1 + _SPEED_FRAMES // len(walked.tour.stamps), 1, 1))[:_SPEED_FRAMES]
    sensor = FeatureSensor(load_features(feature_model or MINI_FEATURES), RunConfig().rig.front, first_seed)
    houses = [walked.house] * _SPEED_FRAMES
    collections.deque(sensor.percepts(houses[:_WARM_UP], poses), maxlen=0)
    start = time.process_time()
    collections.deque(sensor.percepts(houses, poses), maxlen=0)
    return _SPEED_FRAMES / (time.process_time() - start)


def agreement(pairs: Sequence[tuple[float, float]]) -> Agreement:
    """Of a figure's pairs."""
    rendered, features = np.array(pairs).T
    ranked = len(pairs) > 2 and np.ptp(rendered) > 0.0 and np.ptp(features) > 0.0
    rho = float(spearmanr(rendered, features).statistic) if ranked else None
    return Agreement(
        len(pairs), rho, float(rendered.mean()), float(features.mean()), float(np.abs(rendered - features).mean())
    )


def summarised(pairs: Sequence[HousePair]) -> Iterator[tuple[str, str, Agreement]]:
    """(houses, figure, agreement): all figures over all houses of usual looks, then accuracy by group."""
    usual = [pair for pair in pairs if pair.group in PRESETS]
    for name in FIGURES:
        yield "usual looks", name, agreement([getattr(pair, name) for pair in usual])
    for group in dict.fromkeys(pair.group for pair in pairs):
        yield group, FIGURES[0], agreement([pair.accuracy for pair in pairs if pair.group == group])
