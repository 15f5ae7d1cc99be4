"""The embedding model that fits frames which a real encoder has seen."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float64
from scipy.optimize import nnls

from sim.features.embedding import KERNELS, EmbeddingModel, kernel_values
from sim.features.samples import Sample

RIDGE = 10.0
"""Weight of the penalty on weights, for descriptions in their own units."""
RANK = 64
_FOLDS = 5


def fit_embedding(samples: Sequence[Sample]) -> EmbeddingModel:
    """Ridge regression for the mean; the errors are those on houses that it was not fitted to."""
    described = [sample.views.described().astype(float) for sample in samples]
    embedded = [sample.embeddings.astype(float) for sample in samples]
    residuals = _held_out(described, embedded)
    weights, offset = _ridge(np.concatenate(described), np.concatenate(embedded))
    scatter = np.concatenate(residuals)
    _, deviations, directions = np.linalg.svd(scatter / np.sqrt(len(scatter)), full_matrices=False)
    kept = min(RANK, len(deviations))
    # What the rank leaves out is not lost: it lengthens the directions that are kept.
    scale = np.sqrt((deviations**2).sum() / (deviations[:kept] ** 2).sum())
    errors = scale * deviations[:kept, None] * directions[:kept]
    shares = _kernel_shares(samples, residuals)
    return EmbeddingModel(weights.astype(np.float32), offset.astype(np.float32), errors.astype(np.float32), shares)


def _ridge(
    inputs: Float64[np.ndarray, "n size"], outputs: Float64[np.ndarray, "n d"]
) -> tuple[Float64[np.ndarray, "size d"], Float64[np.ndarray, "d"]]:
    middle, target = inputs.mean(axis=0), outputs.mean(axis=0)
    centred = inputs - middle
    gram = centred.T @ centred + RIDGE * np.eye(inputs.shape[1])
    weights = np.linalg.solve(gram, centred.T @ (outputs - target))
    return weights, target - middle @ weights


def _held_out(
    described: Sequence[Float64[np.ndarray, "n size"]], embedded: Sequence[Float64[np.ndarray, "n d"]]
) -> list[Float64[np.ndarray, "n d"]]:
    """What regressions on other houses leave of every house."""
    residuals: list[Float64[np.ndarray, "n d"]] = [np.zeros((0, 0))] * len(described)
    folds = min(_FOLDS, len(described))
    for fold in range(folds):
        others = [i for i in range(len(described)) if i % folds != fold]
        weights, offset = _ridge(*(np.concatenate([rows[i] for i in others]) for rows in (described, embedded)))
        for i in range(fold, len(described), folds):
            residuals[i] = embedded[i] - described[i] @ weights - offset
    return residuals


def _kernel_shares(
    samples: Sequence[Sample], residuals: Sequence[Float64[np.ndarray, "n d"]]
) -> Float64[np.ndarray, "kernels"]:
    """Shares of the kernels by non-negative least squares on the products of errors of two frames of a house."""
    power = float(np.mean(np.concatenate([(rows**2).sum(axis=1) for rows in residuals])))
    columns, products = [], []
    for sample, rows in zip(samples, residuals, strict=True):
        pairs = np.triu_indices(len(rows), 1)
        columns.append(np.stack([values[pairs] for values in kernel_values(sample.views, sample.T_W_B)], axis=1))
        products.append((rows @ rows.T)[pairs] / power)
    shares, _ = nnls(np.concatenate(columns), np.concatenate(products))
    if shares.sum() > 1.0:
        return np.asarray(shares / shares.sum())
    # What two frames never share is the shortest field's.
    shares[KERNELS.index("objects") + 1] += 1.0 - shares.sum()
    return np.asarray(shares)
