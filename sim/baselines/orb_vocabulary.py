"""The visual words that encoders are compared with: learned from training houses of all presets and looks."""

from dataclasses import replace
from pathlib import Path
from zipfile import BadZipFile

import numpy as np

from lexis.files import replaced_file
from sim.baselines.orb_words import OrbWords
from sim.errors import SimError
from sim.training.frames import frames_of_house
from sim.training.houses import TRAINING_SEEDS, draw_houses
from sim.training.views import LEXIS_VIEWS

_HOUSES, _SEED = 8, 8
_VIEWS = replace(LEXIS_VIEWS, most=30)
_FILE = "orb-words.npz"


def orb_vocabulary(work: Path | None = None) -> OrbWords:
    """Learned in less than a minute; kept in the work folder if there is one. Raises `SimError` for a damaged file."""
    if work is None:
        return _learned()
    path = work / _FILE
    if not path.exists():
        work.mkdir(parents=True, exist_ok=True)
        vocabulary = _learned()
        with replaced_file(path) as beside, beside.open("wb") as file:
            np.savez(file, words=vocabulary.words, weights=vocabulary.weights)
    try:
        with np.load(path, allow_pickle=False) as data:
            return OrbWords(data["words"], data["weights"])
    except (OSError, ValueError, KeyError, BadZipFile) as error:
        raise SimError(f"{path}: no vocabulary in it: {error}; delete it to have it learned again") from None


def _learned() -> OrbWords:
    draws = draw_houses(_HOUSES, TRAINING_SEEDS, np.random.default_rng(_SEED))
    images = [image for draw in draws for image in frames_of_house(draw, _VIEWS).images]
    return OrbWords.learned(images, np.random.default_rng(_SEED))
