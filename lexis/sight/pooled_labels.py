"""Labels of keyframes from the images of all keyframes that look at their places."""

import numpy as np
from jaxtyping import Float64, Int
from scipy.sparse import csr_array, diags_array
from scipy.special import softmax

from lexis.config import SightConfig
from lexis.maths.ties import rounded

_BELIEF_FLOOR = 0.01
"""Is added to beliefs before their logarithm is taken, so that no neighbour can rule out a label."""
_NEVER = 1e-9


def pool_labels(
    similarities: Float64[np.ndarray, "n rooms"], sees: csr_array, config: SightConfig
) -> tuple[Int[np.ndarray, "n"], Float64[np.ndarray, "n rooms"]]:
    """Label each keyframe by the images that show its place, and return the labels and the probabilities of all labels.

    1. Convert the similarities of each image to log probabilities, which are its evidence.
    2. Sum up, for each keyframe, the evidence of all images, weighted by the share of the image's visible space that lies
       near the keyframe. The keyframe's own image counts `own_weight` in addition.
    3. Let the keyframes that are connected by sight come to agree, in a few passes of logarithmic opinion pooling: each
       keyframe adds the mean log belief of its neighbours, times `neighbour_weight`, to its evidence.

    Args:
        similarities: cosine similarities of the images (rows) with the room names.
        sees: the matrix that `lexis.sight.visible_space.sight` returns.
        config: the weights, the temperature of the probabilities, and the number of passes.
    """
    own = np.log(softmax(rounded(similarities) / config.temperature, axis=1) + config.least_probability)
    evidence = sees @ own + config.own_weight * own
    neighbours = _between_others(sees)
    beliefs = softmax(evidence, axis=1)
    for _ in range(config.passes):
        agreed = neighbours @ np.log(beliefs + _BELIEF_FLOOR)
        beliefs = softmax(evidence + config.neighbour_weight * agreed, axis=1)
    return rounded(beliefs).argmax(axis=1), beliefs


def _between_others(sees: csr_array) -> csr_array:
    """The matrix without its diagonal, with rows that add up to 1; rows without entries stay empty."""
    others = sees - diags_array(sees.diagonal())
    return csr_array(diags_array(1.0 / np.maximum(others.sum(axis=1), _NEVER)) @ others)
