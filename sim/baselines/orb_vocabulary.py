"""The ORB vocabulary of the place recognition baseline, learned from training houses of all presets and looks."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from sim.baselines.orb_words import FEATURES, WORDS, OrbWords
from sim.training.array_cache import cached_arrays, house_origin, origin
from sim.training.frames import frames_of_house, frames_origin
from sim.training.houses import TRAINING_SEEDS, HouseDraw, draw_houses
from sim.training.viewpoints import LEXIS_VIEWS

_HOUSES, _SEED = 8, 8
_VIEWS = replace(LEXIS_VIEWS, most=30)
_FILE = "orb-words.npz"


def flat_orb_words(work: Path | None = None) -> OrbWords:
    """Load the vocabulary from the work folder; if it is missing, learn it (less than a minute) and save it there.

    Without a work folder, the vocabulary is learned and not saved. Raises `SimError` if the file in the folder cannot be
    read, or was made from other houses or with other settings.
    """
    draws = list(draw_houses(_HOUSES, TRAINING_SEEDS, np.random.default_rng(_SEED)))
    if work is None:
        return _learned(draws)
    origins = (origin(frames_origin(_VIEWS), _SEED, WORDS, FEATURES), *map(house_origin, draws))
    return OrbWords(**cached_arrays(work / _FILE, origins, lambda: vars(_learned(draws))))


def _learned(draws: Sequence[HouseDraw]) -> OrbWords:
    images = [image for draw in draws for image in frames_of_house(draw, _VIEWS).images]
    return OrbWords.learned(images, np.random.default_rng(_SEED))
