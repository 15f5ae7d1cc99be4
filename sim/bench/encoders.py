"""`lexis-sim bench encoders`: what an encoder tells of single frames of test houses, beside what can be known from them.

Every figure is of images alone, before LEXIS refines anything. The ceiling is a classifier on the true visible share of
every thing, trained on the frames that `train-encoder` left in its work folder.
"""

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Bool, Float, Float32, Int
from scipy.special import softmax

from lexis.encoder import OpenClipEncoder, load_encoder
from lexis.query import BEST_VIEWS
from sim.errors import SimError
from sim.training.frames import THINGS, Frames, Views, frames_in, frames_of_house
from sim.training.houses import HouseDraw
from sim.training.phrases import (
    HELD_OUT_NAMES,
    PLACE_FRAMES,
    ROOM_ACTIVITIES,
    ROOM_NAMES,
    Table,
    framed,
    object_caption,
)
from sim.training.temperature import calibration_error
from worlds.labels import ROOM_LABELS

VIEWS = Views(size=(480, 360), supersampling=1, spacing_m=1.0, most=150, glances=False)
"""As LEXIS sees houses in runs."""
_NAME_SETS = 6
_SEEN = 0.01
"""Share of an image from which on a thing is seen well enough to be looked for."""
_TREES = 100


@dataclass(frozen=True)
class EncoderRow:
    """The figures of one house; shares unless a unit is given."""

    accuracy: float
    """Zero-shot, over the labels of the house."""
    ceiling: float | None
    """Of the classifier on what is truly visible; None without training frames."""
    trained_names: float
    """Mean accuracy with other trained names of the rooms."""
    held_out_names: float
    """And with names that were never trained on."""
    things_found: float | None
    """Questions for a thing that rank a room with it first; None where no thing is in one kind of room alone."""
    activities_found: float
    """Questions for what is done in a room that rank it first."""
    calibration_error: float
    """Expected, of the probabilities that the model's own temperature makes; of one house, few frames make it larger."""
    image_ms: float
    """Median time of one image on one thread [ms]."""


@dataclass(frozen=True, eq=False)
class Measured:
    """A house's figures, and its answers one by one."""

    seed: int
    row: EncoderRow
    confidence: Float[np.ndarray, "n"]
    """Of every frame's label."""
    right: Bool[np.ndarray, "n"]


Scores = Callable[[Frames], Float[np.ndarray, "n labels"]]


def measure(encoder: OpenClipEncoder, preset: str, seeds: Sequence[int], ceiling: Scores | None) -> Iterator[Measured]:
    """The houses of the preset, one by one."""
    for seed in seeds:
        yield _measured(encoder, frames_of_house(HouseDraw(preset, seed), VIEWS), ceiling, seed)


def overall_calibration_error(houses: Sequence[Measured]) -> float:
    """Expected calibration error over the frames of all houses."""
    confidence = np.concatenate([house.confidence for house in houses])
    return calibration_error(confidence, np.concatenate([house.right for house in houses]))


def _measured(encoder: OpenClipEncoder, frames: Frames, ceiling: Scores | None, seed: int) -> Measured:
    rng = np.random.default_rng(seed)
    images, times = _embedded(encoder, frames)
    present, own = np.unique(frames.rooms, return_inverse=True)
    names = [ROOM_LABELS[i] for i in present]
    similarities = images @ encoder.encode_rooms(names).T
    right = similarities.argmax(axis=1) == own
    said = softmax(similarities / encoder.temperature, axis=1)
    best = None if ceiling is None else present[ceiling(frames)[:, present].argmax(axis=1)]
    row = EncoderRow(
        accuracy=float(right.mean()),
        ceiling=None if best is None else float((best == frames.rooms).mean()),
        trained_names=_renamed(encoder, images, names, own, ROOM_NAMES, rng),
        held_out_names=_renamed(encoder, images, names, own, HELD_OUT_NAMES, rng),
        things_found=_things_found(encoder, images, frames, own, rng),
        activities_found=_activities_found(encoder, images, names, own),
        calibration_error=calibration_error(said.max(axis=1), right),
        image_ms=float(np.median(times) * 1e3),
    )
    return Measured(seed, row, said.max(axis=1), right)


def _embedded(encoder: OpenClipEncoder, frames: Frames) -> tuple[Float32[np.ndarray, "n e"], Float[np.ndarray, "n"]]:
    embeddings, times = [], []
    for image in frames.images:
        start = time.perf_counter()
        embeddings.append(encoder.encode_image(image))
        times.append(time.perf_counter() - start)
    return np.array(embeddings), np.array(times)


def _renamed(
    encoder: OpenClipEncoder,
    images: Float32[np.ndarray, "n e"],
    names: Sequence[str],
    own: Int[np.ndarray, "n"],
    table: Table,
    rng: np.random.Generator,
) -> float:
    """Mean accuracy over lists in which every room goes by a random name of the table."""
    lists = [[table[name][int(rng.integers(len(table[name])))] for name in names] for _ in range(_NAME_SETS)]
    return float(np.mean([((images @ encoder.encode_rooms(chosen).T).argmax(axis=1) == own).mean() for chosen in lists]))


def _things_found(
    encoder: OpenClipEncoder,
    images: Float32[np.ndarray, "n e"],
    frames: Frames,
    own: Int[np.ndarray, "n"],
    rng: np.random.Generator,
) -> float | None:
    """Over things that are seen in frames of one kind of room alone."""
    seen = frames.shares > _SEEN
    rooms = np.array([np.bincount(own, seen[:, k], minlength=own.max() + 1) for k in range(len(THINGS))])
    wanted = np.flatnonzero(((rooms > 0).sum(axis=1) == 1) & (rooms.max(axis=1) >= 3))
    if not len(wanted):
        return None
    questions = encoder.encode_texts([object_caption(THINGS[k], rng) for k in wanted])
    return float((_ranked_first(images, own, questions) == rooms[wanted].argmax(axis=1)).mean())


def _activities_found(
    encoder: OpenClipEncoder, images: Float32[np.ndarray, "n e"], names: Sequence[str], own: Int[np.ndarray, "n"]
) -> float:
    asked = [(question, i) for i, name in enumerate(names) for question in framed(PLACE_FRAMES[1:2], ROOM_ACTIVITIES[name])]
    questions = encoder.encode_texts([question for question, _ in asked])
    return float((_ranked_first(images, own, questions) == [i for _, i in asked]).mean())


def _ranked_first(
    images: Float32[np.ndarray, "n e"], own: Int[np.ndarray, "n"], questions: Float32[np.ndarray, "q e"]
) -> Int[np.ndarray, "q"]:
    """For every question, the room label whose frames resemble it most, as `lexis query` ranks rooms."""
    best = np.array([_best(images[own == room] @ questions.T) for room in range(own.max() + 1)])
    return np.asarray(best.argmax(axis=0))


def _best(similarities: Float32[np.ndarray, "n q"]) -> Float32[np.ndarray, "q"]:
    return np.asarray(np.sort(similarities, axis=0)[-BEST_VIEWS:].mean(axis=0))


def ceiling_of(work: Path) -> Scores:
    """A random forest on true visible shares, trained on the frames in a work folder. Raises `SimError` without any."""
    frames = frames_in(work / "frames")  # of training and tuning houses, never of test houses
    try:
        from sklearn.ensemble import RandomForestClassifier
    except ImportError:
        raise SimError(
            "the ceiling needs scikit-learn; valid: an environment with the group 'tests', or no --work"
        ) from None
    forest: Any = RandomForestClassifier(_TREES, min_samples_leaf=2, random_state=0)
    forest.fit(frames.shares, frames.rooms)

    def scores(seen: Frames) -> Float[np.ndarray, "n labels"]:
        found = np.zeros((len(seen.rooms), len(ROOM_LABELS)))
        found[:, forest.classes_] = forest.predict_proba(seen.shares)
        return found

    return scores


def loading_seconds(model: str) -> float:
    """Time to load the encoder in a process that has imported everything [s]."""
    start = time.perf_counter()
    load_encoder(model)
    return time.perf_counter() - start
