"""Labels of keyframes by sight: from all images that show the place of a keyframe."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float64
from scipy.sparse import csr_array, diags_array
from scipy.special import softmax

from lexis.config import SightConfig
from lexis.maths.ties import rounded
from lexis.room_labels import Refined
from lexis.sight.cameras import mean

_BELIEF_FLOOR = 0.01
"""Constant that is added to beliefs before their logarithm is taken, so that no neighbour can rule out a label."""
_LEAST_SUM = 1e-9
"""Least sum by which a row is divided, so that a row without entries stays empty."""


def pool_labels(
    similarities: Float64[np.ndarray, "n cameras rooms"], seen_by: Sequence[csr_array], config: SightConfig
) -> Refined:
    """Label each keyframe by the images that show its place, and return the labels and how probable all labels are.

    1. Convert the similarities of each image to log probabilities, which are the evidence of the image.
    2. Sum up, for each keyframe, the evidence of all images, weighted by the share of the image's visible space that lies
       near the keyframe. The keyframe's own image counts `own_weight` in addition. The probabilities that follow from this
       sum are the keyframe's beliefs. With several cameras, the evidence is the mean over the cameras, so that cameras with
       overlapping views do not count twice. The calibrated probabilities, which are returned, follow in the same way from
       the share `independence` of the sum.
    3. Let keyframes come to agree, in a few passes of logarithmic opinion pooling. The neighbours of a keyframe are the
       other keyframes that see its place. In each pass, every keyframe adds the mean log belief of its neighbours, times
       `neighbour_weight`, to its evidence.

    Args:
        similarities: cosine similarities of the images of every keyframe, one for each camera, with the room names; -inf for
            a name that a keyframe cannot have, whose probability is then 0.
        seen_by: for each camera, the matrix that `lexis.sight.visible_space.sight` returns.
        config: the weights, the temperature of the probabilities, and the number of passes.

    Returns:
        The label of every keyframe, and the probabilities of all labels from the images alone. A label that the neighbours
        have changed may therefore be improbable.
    """
    images = np.log(softmax(rounded(similarities) / config.temperature, axis=2) + config.least_probability)
    evidence = mean([seen @ own + config.own_weight * own for own, seen in zip(images.swapaxes(0, 1), seen_by, strict=True)])
    evidence = np.where(np.isneginf(similarities).all(axis=1), -np.inf, evidence)
    neighbours = _between_others(mean(seen_by))
    beliefs = softmax(evidence, axis=1)
    for _ in range(config.passes):
        agreed = neighbours @ np.log(beliefs + _BELIEF_FLOOR)
        beliefs = softmax(evidence + config.neighbour_weight * agreed, axis=1)
    return Refined(rounded(beliefs).argmax(axis=1), softmax(config.independence * evidence, axis=1))


def _between_others(seen_by: csr_array) -> csr_array:
    """Return the matrix without its diagonal, with rows scaled to a sum of 1; rows without entries stay empty."""
    others = seen_by - diags_array(seen_by.diagonal())
    return csr_array(diags_array(1.0 / np.maximum(others.sum(axis=1), _LEAST_SUM)) @ others)
