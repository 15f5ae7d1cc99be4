"""Training of place recognition: finds pairs of frames that show the same place, and computes a contrastive loss over them.

Frames of the same place should have similar embeddings. These embeddings should differ from the embeddings of other places,
above all of other places in the same house.
"""

import numpy as np
import torch
from jaxtyping import Bool, Float, Float64, Int
from torch import Tensor, nn

from lexis.evaluation.place_recognition import PLACE_M, PLACE_RAD
from lexis.types import Poses

_TEMPERATURE = 0.07
_DOUBT = 1.5
"""Two frames show the same place within `PLACE_M` and `PLACE_RAD`, and different places beyond these bounds times `_DOUBT`.
Pairs in between count as neither."""


def pairs_of_places(
    T_W_B: Poses, houses: Int[np.ndarray, "n"], rooms: Int[np.ndarray, "n"]
) -> tuple[Bool[np.ndarray, "n n"], Bool[np.ndarray, "n n"]]:
    """Return two masks of pairs of frames: pairs that show the same place, and pairs that show different places.

    Two frames show the same place if house and room label are the same, and the poses differ by at most `PLACE_M` and
    `PLACE_RAD`. They show different places if the houses differ, or the poses differ by more than 1.5 times `PLACE_M` or
    `PLACE_RAD`. All other pairs, such as close frames on both sides of a doorway, are in neither mask.

    Args:
        T_W_B: poses of the body.
        houses: seed of the house of every frame.
        rooms: label index of the room of every frame.
    """
    away, turned = _distances(T_W_B)
    here = houses[:, None] == houses[None, :]
    one_room = rooms[:, None] == rooms[None, :]
    same = here & one_room & (away <= PLACE_M) & (turned <= PLACE_RAD) & ~np.eye(len(houses), dtype=bool)
    near = here & (away <= _DOUBT * PLACE_M) & (turned <= _DOUBT * PLACE_RAD)
    return same, ~near


def _distances(T_W_B: Poses) -> tuple[Float64[np.ndarray, "n n"], Float64[np.ndarray, "n n"]]:
    """Return the distances [m] and the angles [rad] between all pairs of poses."""
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
    """Return a supervised contrastive loss (Khosla 2020), which is low if frames of the same place are most similar.

    Each pair of frames of the same place is compared with all frames of other places. At a low `temperature`, mostly the
    most similar frames of other places count. The loss is the mean over the frames that show the same place as another
    frame; it is 0 if there are no such frames.
    """
    similarities = cosines / temperature
    others = torch.logsumexp(similarities.masked_fill(~apart, -torch.inf), dim=1, keepdim=True)
    wrong = nn.functional.softplus(others - similarities)
    counts = same.sum(dim=1)
    found = (wrong * same).sum(dim=1)[counts > 0] / counts[counts > 0]
    return found.mean() if len(found) else similarities.sum() * 0.0
