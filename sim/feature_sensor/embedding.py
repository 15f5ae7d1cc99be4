"""Simulated image embeddings: the expected embedding of the true view, plus an error that is similar for similar views.

The error is a Gaussian process over poses. In the space of embeddings, the error has a low rank. Over poses, the covariance
of the error is a sum of six kernels: a kernel that is constant in a house (appearance of the house), a kernel for the rooms
in view, a kernel for the objects in view, and three smooth kernels with different correlation lengths. Errors are therefore
correlated as with the real encoder: keyframes that are neighbours in the pose graph have similar errors, and a revisited
place has a similar error again.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Float32, Float64

from lexis.types import Poses
from sim.feature_sensor.surroundings import OBJECTS
from sim.feature_sensor.visible_shares import VisibleShares

FIELDS = ((0.3, 0.2), (1.0, 0.6), (3.0, 1.5))
"""Correlation lengths of the error of embeddings, for each of the three smooth kernels: in position [m] and in direction of
view [rad]."""
KERNELS = ("house", "rooms", "objects", *(f"{metres:g} m, {radians:g} rad" for metres, radians in FIELDS))
_WAVES = 256
"""Number of random Fourier features that approximate a smooth kernel."""


@dataclass(frozen=True, eq=False)
class EmbeddingModel:
    """A fitted model of the embeddings, of d dimensions, that an encoder computes from images."""

    weights: Float32[np.ndarray, "size d"]
    """Linear map from a view's description (`VisibleShares.described`) to its expected embedding."""
    offset: Float32[np.ndarray, "d"]
    errors: Float32[np.ndarray, "k d"]
    """Principal directions of the error. The length of each direction is the error's standard deviation along it."""
    kernels: Float64[np.ndarray, "kernels"]
    """Share of each of `KERNELS` in the variance of the error. The shares sum to 1."""

    def expected(self, views: VisibleShares) -> Float32[np.ndarray, "n d"]:
        """Return the expected embeddings of views, without the random error."""
        return np.asarray(views.described() @ self.weights + self.offset)

    def draw(self, views: VisibleShares, T_W_B: Poses, seed: tuple[int, ...]) -> Float32[np.ndarray, "n d"]:
        """Draw embeddings (unit vectors) of the views from body poses `T_W_B`.

        Each embedding depends only on the pose, the house and the seed.
        """
        rows = self.expected(views) + error_scores(self, views, T_W_B, seed) @ self.errors
        return np.asarray(rows / np.linalg.norm(rows, axis=1, keepdims=True), np.float32)


def error_scores(
    model: EmbeddingModel, views: VisibleShares, T_W_B: Poses, seed: tuple[int, ...]
) -> Float32[np.ndarray, "n k"]:
    """Draw the error of each view, as independent coordinates of unit variance along the `k` rows of `model.errors`."""
    rng, k = np.random.default_rng(seed), len(model.errors)
    parts = [bases @ rng.standard_normal((bases.shape[1], k), np.float32) for bases in _bases(views, T_W_B, rng)]
    return np.asarray(sum(np.float32(np.sqrt(share)) * part for share, part in zip(model.kernels, parts, strict=True)))


def _bases(views: VisibleShares, T_W_B: Poses, rng: np.random.Generator) -> Iterator[Float32[np.ndarray, "n m"]]:
    """Yield for each kernel a matrix with one row per view.

    The inner product of two rows is the value of the kernel for these two views. For smooth kernels, this is approximate.
    """
    yield np.ones((len(T_W_B), 1), np.float32)
    yield _units(views.of_rooms()).astype(np.float32)
    yield _units(_objects(views)).astype(np.float32)
    for metres, radians in FIELDS:
        frequency = rng.standard_normal((5, _WAVES))
        phase = rng.uniform(0.0, 2 * np.pi, _WAVES)
        waves = np.cos(_coordinates(T_W_B, metres, radians) @ frequency + phase)
        yield (np.sqrt(2 / _WAVES) * waves).astype(np.float32)


def kernel_values(views: VisibleShares, T_W_B: Poses) -> Iterator[Float64[np.ndarray, "n n"]]:
    """Yield, for each of `KERNELS` in order, the matrix of the kernel's values for all pairs of views."""
    yield np.ones((len(T_W_B), len(T_W_B)))
    for rows in (_units(views.of_rooms()), _units(_objects(views))):
        yield rows @ rows.T
    for metres, radians in FIELDS:
        at = _coordinates(T_W_B, metres, radians)
        squared = ((at[:, None] - at[None]) ** 2).sum(axis=2)
        yield np.exp(-0.5 * squared)


def _objects(views: VisibleShares) -> Float[np.ndarray, "n things"]:
    return np.where(views.around.kind < len(OBJECTS), views.shares, np.float32(0.0))


def _units(rows: Float[np.ndarray, "n m"]) -> Float[np.ndarray, "n m_plus_1"]:
    """Scale rows to unit length. Zero rows (nothing in view) become a unit vector in one added dimension."""
    rows = np.column_stack([rows, ~rows.any(axis=1)])
    return np.asarray(rows / np.linalg.norm(rows, axis=1, keepdims=True))


def _coordinates(T_W_B: Poses, metres: float, radians: float) -> Float64[np.ndarray, "n 5"]:
    """Return position and direction of view (cosine, sine) in units of the correlation lengths `metres` and `radians`."""
    heading = np.arctan2(T_W_B[:, 1, 0], T_W_B[:, 0, 0])
    turn = np.column_stack([np.cos(heading), np.sin(heading)])
    return np.concatenate([T_W_B[:, :3, 3] / metres, turn / radians], axis=1)
