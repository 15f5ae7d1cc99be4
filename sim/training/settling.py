"""The last step of training the image tower: only the projection, the tower's last layer, is trained.

The rest of the tower stays as it is. Every image therefore passes through it only once, and this step can use the frames of
more houses than the stages before. The loss has four parts:

1. Captions: rooms, things and the search for images by captions, as in `sim.training.align`.
2. Places: as in `sim.training.align`, with other weights.
3. Pooled evidence: several views of a room name its label together (`sim.training.pooling`).
4. Columns: the columns of an image name the rooms in view (`sim.training.columns`).
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import islice
from pathlib import Path

import numpy as np
import torch
from jaxtyping import Bool, Float, Int
from torch import Tensor

from lexis.types import Poses
from sim.training.align import AlignLearner
from sim.training.batches import PRESENT, chosen_once
from sim.training.columns import columns_loss, contributions
from sim.training.fit import PROCESSOR, resume, save_checkpoint
from sim.training.frames import Frames
from sim.training.places import pairs_of_places, place_loss
from sim.training.pooling import RoomFrames, absent_labels, pooled_loss

STEPS = 2000
"""Number of training steps."""
_BATCH, _RATE = 512, 2e-3
_PLACES_WEIGHT, _PLACES_TEMPERATURE = 8.0, 0.03
"""The place loss has a larger weight here than before, and its low temperature emphasises the most similar other places.
Compared with weight 4 and temperature 0.07, as many revisits are found, and 0.79 instead of 0.77 of the tuning frames get
the right room."""
_ROOMS, _VIEWS = 64, 8
"""Number of rooms whose views are pooled in one step, and number of views of each."""
_OTHERS = 0.25
"""Share of the labels that a house lacks, but with which its images are compared all the same in a step, because the names
that users give may include rooms that are not there."""
_VIEW_WEIGHT, _POOLED_WEIGHT = 2.0, 4.0
"""Weights of the losses of these views, each alone and all views of a room together."""
_COLUMNS_WEIGHT = 0.5


@dataclass(frozen=True, eq=False)
class _SeenFrames:
    """Features of the images of many houses, and the ground truth that the losses need."""

    columns: Float[Tensor, "n columns f"]
    """Features of the columns of each image."""
    features: Float[Tensor, "n f"]
    """Pooled features of each image: the mean over its columns."""
    rooms: Int[np.ndarray, "n"]
    things: Float[Tensor, "n things"]
    """Whether each thing is present in each image, as 0 or 1."""
    views: Float[Tensor, "n labels"]
    """Share of each image that shows rooms of each label."""
    houses: Int[np.ndarray, "n"]
    T_W_B: Poses

    @cached_property
    def absent(self) -> Bool[np.ndarray, "n labels"]:
        """The labels that no frame of an image's house has."""
        return absent_labels(self.houses, self.rooms)

    @staticmethod
    def by(learner: AlignLearner, houses: Iterable[Frames]) -> "_SeenFrames":
        rows = [
            (learner.columns(each), each.rooms, each.shares > PRESENT, each.views, each.houses, each.T_W_B)
            for each in houses
            if len(each.rooms)
        ]
        of_columns, rooms, things, views, numbers, poses = zip(*rows, strict=True)
        columns = torch.cat(of_columns)
        present = torch.from_numpy(np.concatenate(things).astype(np.float32)).to(PROCESSOR)
        shown = torch.from_numpy(np.concatenate(views)).to(PROCESSOR)
        told = np.concatenate(numbers), np.concatenate(poses)
        return _SeenFrames(columns, columns.mean(dim=1), np.concatenate(rooms), present, shown, *told)


def settle(
    learner: AlignLearner, houses: Iterable[Frames], seed: int, steps: int = STEPS, checkpoint: Path | None = None
) -> None:
    """Train the projection and the logit scales on the frames of houses, without augmentation.

    `houses` yields the frames of one house, or of several, at a time, so that they need not fit in memory together. A house
    may have no frames. The result is written to the file `checkpoint`. If this file exists, its weights replace those of the
    learner, and nothing is trained. Raises `SimError` if the file cannot be read.
    """
    if resume(checkpoint, learner.module):
        return
    rng = np.random.default_rng([seed, 4])
    frames = _SeenFrames.by(learner, houses)
    rooms = RoomFrames.of(frames.houses, frames.rooms)
    parameters = [value for name, value in learner.module.named_parameters() if not name.startswith("dense.")]
    optimiser = torch.optim.AdamW(parameters, lr=_RATE, weight_decay=0.02)
    rate = torch.optim.lr_scheduler.OneCycleLR(optimiser, _RATE, total_steps=steps, pct_start=0.15)
    for chosen in islice(_chosen_often(frames.houses, rng), steps):
        of_images = _frame_loss(learner, frames, chosen, rng) + _room_loss(learner, frames, rooms, rng)
        loss = of_images + _COLUMNS_WEIGHT * _columns_loss(learner, frames, chosen, rng)
        optimiser.zero_grad()
        loss.backward()  # type: ignore[no-untyped-call]
        optimiser.step()
        rate.step()
    save_checkpoint(checkpoint, 1, learner.module)


def _frame_loss(
    learner: AlignLearner, frames: _SeenFrames, chosen: Int[np.ndarray, "b"], rng: np.random.Generator
) -> Tensor:
    """Return the weighted sum of the losses of captions and places."""
    embedding = learner.module.embedded(frames.features[chosen])
    own = torch.from_numpy(frames.rooms[chosen]).to(PROCESSOR)
    told = pairs_of_places(frames.T_W_B[chosen], frames.houses[chosen], frames.rooms[chosen])
    same, apart = (torch.from_numpy(pairs).to(PROCESSOR) for pairs in told)
    places = place_loss(embedding @ embedding.T, same, apart, _PLACES_TEMPERATURE)
    return learner.caption_loss(embedding, own, frames.things[chosen], rng) + _PLACES_WEIGHT * places


def _room_loss(learner: AlignLearner, frames: _SeenFrames, rooms: RoomFrames, rng: np.random.Generator) -> Tensor:
    """Return the weighted sum of the losses of several views of a room, each alone and all together."""
    chosen, views = rooms.drawn(_ROOMS, _VIEWS, rng)
    similarities = learner.to_rooms(learner.module.embedded(frames.features[views.ravel()]), rng)
    logits = learner.module.room_scale.exp() * similarities.reshape(*views.shape, -1)
    ignored = rooms.absent[chosen] & (rng.random(logits.shape[2]) >= _OTHERS)
    alone, together = pooled_loss(logits, ignored, rooms.labels[chosen])
    return _VIEW_WEIGHT * alone + _POOLED_WEIGHT * together


def _columns_loss(
    learner: AlignLearner, frames: _SeenFrames, chosen: Int[np.ndarray, "b"], rng: np.random.Generator
) -> Tensor:
    """Return the loss of the columns of some images."""
    parts = contributions(frames.columns[chosen], learner.module.projection)
    similarities = learner.to_rooms(parts.flatten(0, 1), rng).reshape(*parts.shape[:2], -1)
    ignored = frames.absent[chosen] & (rng.random((len(chosen), similarities.shape[2])) >= _OTHERS)
    logits = learner.module.room_scale.exp() * similarities
    return columns_loss(logits, ignored, frames.views[chosen])


def _chosen_often(houses: Int[np.ndarray, "n"], rng: np.random.Generator) -> Iterator[Int[np.ndarray, "b"]]:
    while True:
        yield from chosen_once(houses, min(_BATCH, len(houses)), rng)
