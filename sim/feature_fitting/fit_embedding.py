"""Fits the model of image embeddings to rendered frames that a real encoder has embedded (`fit_embedding`).

1. Fit the expected embedding by ridge regression, with the penalty that has the smallest error on held-out houses.
2. Take the principal directions of the errors on held-out houses.
3. Fit the share of each covariance kernel in the variance of the errors, from the products of the errors of two frames.
4. Scale the errors until drawn embeddings give the right room label as often as the encoder does.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from jaxtyping import Float, Float64
from scipy.optimize import nnls

from lexis.perception import Encoder
from lexis.room_labels import similarities
from sim.feature_fitting.fit_samples import Sample
from sim.feature_sensor.embedding import KERNELS, EmbeddingModel, error_scores, kernel_values

RIDGES = (0.1, 0.3, 1.0, 3.0, 10.0)
"""Ridge penalties that are tried. They apply to inputs (the descriptions of views) that are not scaled."""
RANK = 64
"""Number of principal directions of the errors that the model keeps."""
_FOLDS = 5
_SCALES = np.linspace(0.3, 1.5, 13)
"""Factors that are tried on the error of drawn embeddings; see step 4 of the module's docstring."""
_DRAWS = 3
"""Number of random draws of embeddings over which the label accuracy is averaged, for each scale of the error."""

Rows = Float64[np.ndarray, "n d"]


def fit_embedding(samples: Sequence[Sample], encoder: Encoder) -> EmbeddingModel:
    """Fit the expected embeddings by ridge regression, and the model of their errors to the residuals on held-out houses.

    The residuals are not Gaussian: most are small, and only some change the room label. Gaussian errors of the same
    covariance would change the label more often. The Gaussian errors of the model are therefore scaled until as many labels
    are right as with the encoder.
    """
    described = [sample.views.described().astype(float) for sample in samples]
    embedded = [sample.embeddings.astype(float) for sample in samples]
    means = {ridge: _held_out(described, embedded, ridge) for ridge in RIDGES}
    ridge = min(RIDGES, key=lambda each: _power(_residuals(embedded, means[each])))
    residuals = _residuals(embedded, means[ridge])
    weights, offset = _ridge(np.concatenate(described), np.concatenate(embedded), ridge)
    model = EmbeddingModel(
        weights.astype(np.float32),
        offset.astype(np.float32),
        _directions(np.concatenate(residuals)).astype(np.float32),
        _kernel_shares(samples, residuals),
    )
    scale = _scale(samples, means[ridge], model, encoder)
    return replace(model, errors=(scale * model.errors).astype(np.float32))


def _ridge(
    inputs: Float64[np.ndarray, "n size"], outputs: Rows, ridge: float
) -> tuple[Float64[np.ndarray, "size d"], Float64[np.ndarray, "d"]]:
    middle, target = inputs.mean(axis=0), outputs.mean(axis=0)
    centred = inputs - middle
    gram = centred.T @ centred + ridge * np.eye(inputs.shape[1])
    weights = np.linalg.solve(gram, centred.T @ (outputs - target))
    return weights, target - middle @ weights


def _held_out(
    described: Sequence[Float64[np.ndarray, "_ size"]], embedded: Sequence[Float64[np.ndarray, "_ d"]], ridge: float
) -> list[Rows]:
    """Predict the embeddings of each house by a regression on other houses (cross-validation). One array per house."""
    means: list[Rows] = [np.zeros((0, 0))] * len(described)
    folds = min(_FOLDS, len(described))
    for fold in range(folds):
        others = [i for i in range(len(described)) if i % folds != fold]
        inputs, outputs = (np.concatenate([rows[i] for i in others]) for rows in (described, embedded))
        weights, offset = _ridge(inputs, outputs, ridge)
        for i in range(fold, len(described), folds):
            means[i] = described[i] @ weights + offset
    return means


def _residuals(embedded: Sequence[Rows], means: Sequence[Rows]) -> list[Rows]:
    return [rows - mean for rows, mean in zip(embedded, means, strict=True)]


def _power(residuals: Sequence[Rows]) -> float:
    return float(np.mean(np.concatenate([(rows**2).sum(axis=1) for rows in residuals])))


def _directions(residuals: Rows) -> Float64[np.ndarray, "k d"]:
    """Return the principal directions of residuals. The length of each direction is the standard deviation along it."""
    _, deviations, directions = np.linalg.svd(residuals / np.sqrt(len(residuals)), full_matrices=False)
    return np.asarray(deviations[:RANK, None] * directions[:RANK])


def _kernel_shares(samples: Sequence[Sample], residuals: Sequence[Rows]) -> Float64[np.ndarray, "kernels"]:
    """Fit the shares of the kernels, by non-negative least squares, to products of the errors of two frames of a house."""
    power = _power(residuals)
    columns, products = [], []
    for sample, rows in zip(samples, residuals, strict=True):
        pairs = np.triu_indices(len(rows), 1)
        columns.append(np.stack([values[pairs] for values in kernel_values(sample.views, sample.T_W_B)], axis=1))
        products.append((rows @ rows.T)[pairs] / power)
    shares, _ = nnls(np.concatenate(columns), np.concatenate(products))
    if shares.sum() > 1.0:
        return np.asarray(shares / shares.sum())
    # Variance that no two frames share goes to the kernel of the shortest correlation length.
    shares[KERNELS.index("objects") + 1] += 1.0 - shares.sum()
    return np.asarray(shares)


def _scale(samples: Sequence[Sample], means: Sequence[Rows], model: EmbeddingModel, encoder: Encoder) -> float:
    """Return the scale of errors at which drawn embeddings give the right label as often as the encoder does."""
    texts = [encoder.encode_rooms(sample.around.house.spec.room_labels) for sample in samples]
    wanted = _label_accuracy(samples, [sample.embeddings for sample in samples], texts)
    errors = [
        [error_scores(model, sample.views, sample.T_W_B, (i, draw)) @ model.errors for i, sample in enumerate(samples)]
        for draw in range(_DRAWS)
    ]
    accuracy = [
        np.mean(
            [
                _label_accuracy(samples, [mean + scale * error for mean, error in zip(means, drawn, strict=True)], texts)
                for drawn in errors
            ]
        )
        for scale in _SCALES
    ]
    # Accuracy falls as the scale grows, apart from sampling noise, which is removed here.
    falling = np.minimum.accumulate(accuracy)
    return float(np.interp(-wanted, -falling, _SCALES))


def _label_accuracy(
    samples: Sequence[Sample], embeddings: Sequence[Float[np.ndarray, "_ d"]], texts: Sequence[Float[np.ndarray, "_ d"]]
) -> float:
    right = [
        similarities(rows, text).argmax(axis=1) == sample.true_labels
        for sample, rows, text in zip(samples, embeddings, texts, strict=True)
    ]
    return float(np.mean(np.concatenate(right)))
