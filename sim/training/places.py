"""Frames that show one place: what lets embeddings find it again, among other places of the house above all."""

import numpy as np
import torch
from jaxtyping import Bool, Float, Float64, Int
from torch import Tensor, nn

from lexis.evaluation.place_recognition import PLACE_M, PLACE_RAD
from lexis.types import Poses

_TEMPERATURE = 0.07
_DOUBT = 1.5
"""Up to so many times the bounds of one place, frames are taken neither for the same place nor for another."""


def pairs_of_places(
    T_W_B: Poses, houses: Int[np.ndarray, "n"], rooms: Int[np.ndarray, "n"]
) -> tuple[Bool[np.ndarray, "n n"], Bool[np.ndarray, "n n"]]:
    """Whether two different frames show one place, and whether they show two: of a house, or of two houses.

    On both sides of a doorway they do neither: embeddings have to tell the rooms apart there.

    Args:
        T_W_B: poses.
        houses: in which they are.
        rooms: and in a room of which label.
    """
    away, turned = _distances(T_W_B)
    here = houses[:, None] == houses[None, :]
    one_room = rooms[:, None] == rooms[None, :]
    same = here & one_room & (away <= PLACE_M) & (turned <= PLACE_RAD) & ~np.eye(len(houses), dtype=bool)
    near = here & (away <= _DOUBT * PLACE_M) & (turned <= _DOUBT * PLACE_RAD)
    return same, ~near


def _distances(T_W_B: Poses) -> tuple[Float64[np.ndarray, "n n"], Float64[np.ndarray, "n n"]]:
    """Between all poses [m] [rad]."""
    positions, rotations = T_W_B[:, :3, 3], T_W_B[:, :3, :3].reshape(-1, 9)
    away = np.linalg.norm(positions[:, None] - positions[None, :], axis=2)
    cosines = (rotations @ rotations.T - 1.0) / 2.0  # trace(A^T B) is the sum over products of entries
    return away, np.arccos(np.clip(cosines, -1.0, 1.0))


def place_loss(
    cosines: Float[Tensor, "b b"],
    same: Bool[Tensor, "b b"],
    apart: Bool[Tensor, "b b"],
    temperature: float = _TEMPERATURE,
) -> Tensor:
    """How far every frame is from being likest to those of its own place (1).

    The supervised contrastive loss (Khosla 2020), over the frames that have another one of their place in the batch; each
    of these is weighed against the frames of other places, at a low `temperature` against the likest ones above all.
    """
    similarities = cosines / temperature
    others = torch.logsumexp(similarities.masked_fill(~apart, -torch.inf), dim=1, keepdim=True)
    wrong = nn.functional.softplus(others - similarities)
    counts = same.sum(dim=1)
    found = (wrong * same).sum(dim=1)[counts > 0] / counts[counts > 0]
    return found.mean() if len(found) else similarities.sum() * 0.0
