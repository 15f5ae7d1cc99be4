"""Training of pooled evidence: LEXIS labels a place by all images that show it, among the labels of the house.

Single images of a large room often look like images of a small one: many images of an open-plan office show one desk and a
wall. An encoder that is trained on single images alone therefore takes such rooms for offices as a whole. Here, several
images of a room are labelled together.
"""

from dataclasses import dataclass

import numpy as np
import torch
from jaxtyping import Bool, Float, Int
from torch import Tensor, nn

from lexis.config import SightConfig
from sim.training.fit import PROCESSOR
from worlds.labels import ROOM_LABELS


@dataclass(frozen=True, eq=False)
class RoomFrames:
    """The frames of every room label in every house. Rooms of one label in one house count as one room."""

    frames: tuple[Int[np.ndarray, "views"], ...]
    """Indices of the frames of each room."""
    labels: Int[np.ndarray, "rooms"]
    """Label of each room, as an index into `ROOM_LABELS`."""
    absent: Bool[np.ndarray, "rooms labels"]
    """Labels that no frame of the room's house has."""

    @staticmethod
    def of(houses: Int[np.ndarray, "n"], labels: Int[np.ndarray, "n"]) -> "RoomFrames":
        """Group frames by their houses and labels."""
        rooms, room = np.unique(np.column_stack([houses, labels]), axis=0, return_inverse=True)
        order = np.argsort(room, kind="stable")
        frames = np.split(order, np.flatnonzero(np.diff(room[order])) + 1)
        return RoomFrames(tuple(frames), rooms[:, 1], absent_labels(rooms[:, 0], rooms[:, 1]))

    def drawn(
        self, rooms: int, views: int, rng: np.random.Generator
    ) -> tuple[Int[np.ndarray, "rooms"], Int[np.ndarray, "rooms views"]]:
        """Draw rooms, at most all of them, and `views` frames of each; return the rooms and the indices of the frames.

        A frame may occur several times.
        """
        chosen = rng.choice(len(self.frames), min(rooms, len(self.frames)), replace=False)
        return chosen, np.stack([rng.choice(self.frames[room], views) for room in chosen])


def absent_labels(houses: Int[np.ndarray, "n"], labels: Int[np.ndarray, "n"]) -> Bool[np.ndarray, "n labels"]:
    """Return, for each of n frames or rooms, the labels that no frame or room of its house has."""
    _, house = np.unique(houses, return_inverse=True)
    present = np.zeros((house.max() + 1, len(ROOM_LABELS)), bool)
    present[house, labels] = True
    return np.asarray(~present[house])


def pooled_loss(
    logits: Float[Tensor, "rooms views labels"], ignored: Bool[np.ndarray, "rooms labels"], own: Int[np.ndarray, "rooms"]
) -> tuple[Tensor, Tensor]:
    """Return the cross-entropies of the rooms' labels by single views, and by all views of a room together.

    Views are pooled as `lexis.sight.pooled_labels` pools images: by the mean of the logarithms of their probabilities, to
    which a small constant is added.

    Args:
        logits: for several views of each room, the logits of all labels.
        ignored: for each room, the labels with which it is not compared, such as those that its house lacks.
        own: true label of each room.
    """
    never, target = torch.from_numpy(ignored).to(PROCESSOR), torch.from_numpy(own).to(PROCESSOR)
    single = nn.functional.log_softmax(logits.masked_fill(never[:, None], -torch.inf), dim=2)
    pooled = torch.log(single.exp() + SightConfig().least_probability).mean(dim=1).masked_fill(never, -torch.inf)
    alone = nn.functional.nll_loss(single.flatten(0, 1), target.repeat_interleave(logits.shape[1]))
    return alone, nn.functional.cross_entropy(pooled, target)
