"""Fits the model of the feature sensor to an encoder, on rendered images of a few houses (`fit_features`)."""

from collections.abc import Callable

import numpy as np

from lexis.perception import Encoder
from sim.feature_fitting.fit_embedding import fit_embedding
from sim.feature_fitting.fit_loops import fit_loops, joined, try_verification
from sim.feature_fitting.fit_samples import choices, sample
from sim.feature_sensor.covisibility_verifier import LoopModel, MeasuredEdges
from sim.feature_sensor.model import FeatureModel, fingerprint
from sim.number_checks import check_count
from sim.training.houses import HouseDraw

FIRST_SEED = 600
"""Seed of the first house to which a model is fitted. The default fit uses the seeds 600 to 671 and 690 to 692."""
HOUSES, FRAMES = 72, 40
"""Default number of houses to which the model of embeddings is fitted, and number of frames in each house."""
WALKS = (
    HouseDraw("apartment", 690), HouseDraw("uh2-apt", 691), HouseDraw("apartment", 692, openness=0.4),
)  # fmt: skip
"""Houses in which LEXIS runs. The model of loop verification is fitted to the loop verifications of these runs."""
_KEPT = 400
"""Largest number of true loop edges that a model keeps, and also largest number of false loop edges."""
_WALK_SHARE = 0.4
"""Approximate share of the fitting time that the runs in `WALKS` take, for the progress display."""


def fit_features(
    encoder: Encoder, houses: int = HOUSES, progress: Callable[[float], None] = lambda share: None
) -> FeatureModel:
    """Fit a feature model to frames of `houses` houses, and to runs of LEXIS in the houses of `WALKS`.

    The same arguments give the same model. `progress` is called with the share of the work that is done, in [0, 1].

    Raises `SimError` for fewer than two houses, since each house is predicted from the others.
    """
    check_count("fit: houses", houses, 2)
    trials = []
    for i, choice in enumerate(WALKS):
        trials.append(try_verification(choice, encoder, seed=0))
        progress(_WALK_SHARE * (i + 1) / len(WALKS))
    samples = []
    for i, choice in enumerate(choices(houses, FIRST_SEED)):
        samples.append(sample(choice, encoder, FRAMES))
        progress(_WALK_SHARE + (1.0 - _WALK_SHARE) * (i + 1) / houses)
    return FeatureModel(fingerprint(encoder), fit_embedding(samples, encoder), _compact(fit_loops(joined(trials))))


def _compact(model: LoopModel) -> LoopModel:
    return LoopModel(
        model.weights, model.query_share, model.false_rate, _thinned(model.true_edges), _thinned(model.false_edges)
    )


def _thinned(edges: MeasuredEdges) -> MeasuredEdges:
    """Choose at most `_KEPT` edges at even intervals."""
    count = len(edges.inliers)
    chosen = np.unique(np.linspace(0, count - 1, min(count, _KEPT)).astype(int)) if count else np.zeros(0, int)
    return edges[chosen]
