"""Draws the houses for training, tuning and testing the encoder. These three sets have different seeds."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from worlds.errors import WorldsError
from worlds.presets import sample_house
from worlds.spec import AppearanceSpec, HouseSpec, LightName, TextureName

TRAINING_SEEDS = range(100_000, 800_000)
"""Seeds of the houses on which the encoder is trained."""
TUNING_SEEDS = range(800_000, 900_000)
"""Seeds of the houses on which training is monitored and softmax temperatures are fitted."""
TEST_SEEDS = range(900_000, 1_000_000)
"""Seeds of the houses for reported figures. Demos use seeds below 100 000, and acceptance tests seeds from 1 000 000."""

PRESET_SHARE = {
    "home": 0.28, "ori": 0.14, "uh2-apt": 0.12, "uh2-office": 0.13, "apartment": 0.07, "office": 0.07, "clinic": 0.06,
    "school": 0.06, "random": 0.07,
}  # fmt: skip

_TEXTURES: tuple[TextureName, ...] = ("rich", "rich", "rich", "rich", "poor", "repeating")
_LIGHTS: tuple[LightName, ...] = ("day", "day", "day", "day", "evening", "dim")
HELD_OUT_LOOKS = (("poor", "dim"), ("repeating", "evening"))
"""Pairs of texture and lighting that never occur in training."""
_OPENED_SHARE, _CLUTTERED_SHARE = 0.4, 0.4


class HouseDraw(NamedTuple):
    """The parameters with which a house is sampled."""

    preset: str
    seed: int
    texture: TextureName = "rich"
    light: LightName = "day"
    openness: float | None = None
    clutter: float = 1.0

    def spec(self) -> HouseSpec:
        """Sample the house. If it cannot have the given `openness`, it gets the usual openness of its preset."""
        try:
            spec = sample_house(self.preset, self.seed, openness=self.openness, clutter=self.clutter)
        except WorldsError:
            spec = sample_house(self.preset, self.seed, clutter=self.clutter)
        return spec.model_copy(update={"appearance": AppearanceSpec(texture=self.texture, light=self.light)})


def draw_houses(count: int, seeds: range, rng: np.random.Generator) -> Iterator[HouseDraw]:
    """Draw `count` houses with different seeds from `seeds`. A larger `count` only adds houses at the end."""
    names, shares = list(PRESET_SHARE), list(PRESET_SHARE.values())
    used: set[int] = set()
    while len(used) < count:
        seed = seeds[int(rng.integers(len(seeds)))]
        preset, look = names[int(rng.choice(len(names), p=shares))], _look(rng)
        openness = float(rng.random()) if rng.random() < _OPENED_SHARE else None
        clutter = float(rng.uniform(0.5, 2.0)) if rng.random() < _CLUTTERED_SHARE else 1.0
        if seed not in used:
            used.add(seed)
            yield HouseDraw(preset, seed, *look, openness, clutter)


def _look(rng: np.random.Generator) -> tuple[TextureName, LightName]:
    while True:
        look = _TEXTURES[int(rng.integers(len(_TEXTURES)))], _LIGHTS[int(rng.integers(len(_LIGHTS)))]
        if look not in HELD_OUT_LOOKS:
            return look
