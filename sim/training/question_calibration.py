"""Calibrates the probabilities of `lexis query` for an encoder, on tuning houses, and measures how reliable they are."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Bool, Float64, Int, Shaped
from scipy.optimize import minimize
from scipy.stats import rankdata

from lexis.evaluation import calibration_error
from lexis.perception import TextEncoder
from lexis.questions.answers import FITS
from lexis.questions.calibration import Calibration, familiarity, load_calibration, save_calibration
from sim.errors import SimError
from sim.training.houses import TUNING_SEEDS, HouseDraw, draw_houses
from sim.training.random_questions import DOUBTFUL, NO, YES, QuestionBatch, ask, embedded, room_views
from worlds.labels import ROOM_LABELS

_START = (0.2, 0.0, np.log(0.05))
_BOUNDS = ((-2.0, 2.0), (-2.0, 2.0), (np.log(1e-3), np.log(10.0)))
"""Bounds of base, slope and logarithm of the temperature."""


def tuning_houses(count: int, seed: int) -> list[HouseDraw]:
    """Draw houses to which a calibration is fitted, of random presets, with looks and openness as in `lexis-sim run`."""
    draws = draw_houses(count, TUNING_SEEDS, np.random.default_rng([seed, 2]))
    return [HouseDraw(draw.preset, draw.seed) for draw in draws]


def write_calibration(encoder: TextEncoder, weights: Path, houses: int, seed: int) -> None:
    """Fit a calibration to `houses` tuning houses and write it beside the weights.

    This is skipped if the file there already holds a calibration of the same encoder. A training with another seed or other
    tuning houses makes other weights, whose temperature is fitted to these houses, and thus another encoder. A calibration
    of the same encoder is therefore one of the same training, or one that `lexis-sim calibrate-queries` wrote there on
    purpose.
    """
    path = weights.with_suffix(".calibration.json")
    if path.exists() and load_calibration(path).fingerprint == encoder.fingerprint:
        return
    save_calibration(fit_calibration(encoder, asked_in(tuning_houses(houses, seed), encoder, seed)), path)


def asked_in(houses: Iterable[HouseDraw], encoder: TextEncoder, seed: int) -> list[QuestionBatch]:
    """Walk through each house and ask questions about its rooms, in trained words. Houses without a walk are left out."""
    asked = []
    for number, draw in enumerate(houses):
        if (views := room_views(draw)) is not None:
            asked.append(ask(views, embedded(views, encoder), encoder, np.random.default_rng([seed, number])))
    return asked


def fit_calibration(encoder: TextEncoder, asked: Sequence[QuestionBatch]) -> Calibration:
    """Fit a calibration by logistic regression.

    The calibration predicts whether a room is a right answer from two numbers: the similarity of the room's images to the
    question, and how familiar the words of the question are to the encoder.

    For each question, only the most similar room is used, because that room decides whether an answer is given. `measure`
    shows how well the fit holds for all rooms. Raises `SimError` if `asked` is empty.
    """
    if not asked:
        raise SimError("no house to fit to; valid: at least one")
    similarity, known, truth = np.concatenate([_best_rooms(one, encoder) for one in asked]).T

    def surprise(parameters: Float64[np.ndarray, "3"]) -> float:
        base, slope, log_temperature = parameters
        logits = (similarity - base - slope * known) / np.exp(log_temperature)
        return float(np.logaddexp(0.0, np.where(truth == YES, -logits, logits)).mean())

    base, slope, log_temperature = minimize(surprise, _START, bounds=_BOUNDS, method="L-BFGS-B").x
    return Calibration(encoder.fingerprint, ROOM_LABELS, float(base), float(slope), float(np.exp(log_temperature)))


@dataclass(frozen=True)
class CalibrationFigures:
    """How reliable the probabilities of answers are. Half of the questions have an answer in the house."""

    questions: int
    calibration_error: float
    """Expected calibration error of the probabilities of all rooms for all questions."""
    best_calibration_error: float
    """Expected calibration error of the probability of each question's best room, the one with the highest probability."""
    right: float
    """Share of the questions with an answer for which the best room is right. A room whose images show the thing only very
    small counts as right."""
    unknown_auc: float
    """Area under the ROC curve if the best room's probability decides whether a question has an answer."""
    found: float
    """Share of the questions with an answer that are answered with a room instead of "unknown"."""
    unknown: float
    """Share of the questions without an answer that are answered with "unknown"."""


def measure(calibration: Calibration, encoder: TextEncoder, houses: Iterable[QuestionBatch]) -> CalibrationFigures:
    """Measure how reliable the probabilities of a calibration are, over all questions about all houses."""
    every, best, answered = [], [], []
    for asked in houses:
        said = calibration.probabilities(asked.similarities, asked.embeddings, encoder)
        sure = asked.truth != DOUBTFUL
        every.append(np.stack([said[sure], asked.truth[sure] == YES], axis=1))
        first = said.argmax(axis=0)
        # A room that shows the thing only from afar does not count as a wrong answer.
        best.append(np.stack([_of(first, said), _of(first, asked.truth) != NO], axis=1))
        answered.append((asked.truth == YES).any(axis=0))
    (p, true), (top, right), has = np.concatenate(every).T, np.concatenate(best).T, np.concatenate(answered)
    return CalibrationFigures(
        questions=len(has),
        calibration_error=calibration_error(p, true > 0),
        best_calibration_error=calibration_error(top, right > 0),
        right=float(right[has].mean()),
        unknown_auc=_auc(top, has),
        found=float((top[has] >= FITS).mean()),
        unknown=float((top[~has] < FITS).mean()),
    )


def _best_rooms(asked: QuestionBatch, encoder: TextEncoder) -> Float64[np.ndarray, "n 3"]:
    """Return similarity, familiarity and truth of the most similar room of each question.

    Questions for which the truth of this room is `DOUBTFUL` are left out.
    """
    known = familiarity(asked.embeddings, ROOM_LABELS, encoder)
    rows = np.stack([asked.similarities.max(axis=0), known, _of(asked.similarities.argmax(axis=0), asked.truth)], axis=1)
    return np.asarray(rows[rows[:, 2] != DOUBTFUL])


def _of(rooms: Int[np.ndarray, "texts"], values: Shaped[np.ndarray, "rooms texts"]) -> Shaped[np.ndarray, "texts"]:
    """Return, for each text, the value of the room that `rooms` selects."""
    return np.asarray(values[rooms, np.arange(len(rooms))])


def _auc(score: Float64[np.ndarray, "n"], positive: Bool[np.ndarray, "n"]) -> float:
    ranks = rankdata(score)
    yes, no = positive.sum(), (~positive).sum()
    return float((ranks[positive].sum() - yes * (yes + 1) / 2) / (yes * no))
