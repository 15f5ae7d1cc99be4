"""Fits the softmax temperature that converts similarities to probabilities."""

import numpy as np
from jaxtyping import Float, Int
from open_clip.transformer import TextTransformer
from scipy.optimize import minimize_scalar
from scipy.special import log_softmax

from sim.training.align import room_embeddings
from worlds.labels import ROOM_LABELS

_RANGE = (0.005, 0.5)


def fit_temperature(embeddings: Float[np.ndarray, "n e"], text: TextTransformer, rooms: Int[np.ndarray, "n"]) -> float:
    """Return the softmax temperature with the lowest cross-entropy of the true room labels.

    `embeddings` are those of images. `rooms` holds their true labels, as indices into `ROOM_LABELS`. Only labels that occur
    in `rooms` are candidates.
    """
    present, own = np.unique(rooms, return_inverse=True)
    similarities = embeddings @ room_embeddings(text, [ROOM_LABELS[i] for i in present]).T
    return best_temperature(similarities, own)


def best_temperature(similarities: Float[np.ndarray, "n c"], own: Int[np.ndarray, "n"]) -> float:
    """Return the temperature that maximises the likelihood of the true classes.

    Probabilities of classes are softmax(similarities / temperature). `own` holds the true class of each row.
    """

    def surprise(log_temperature: float) -> float:
        said = log_softmax(similarities / np.exp(log_temperature), axis=1)
        return -float(said[np.arange(len(own)), own].mean())

    return float(np.exp(minimize_scalar(surprise, bounds=tuple(np.log(_RANGE)), method="bounded").x))
