"""Stage 1 of training the image tower: supervision by ground truth from the renderer, for each image and each patch.

Linear heads on the tower's features predict which things are visible in the image and in each patch, how much of the image
shows rooms of each label, which room the camera is in, and whether two images show the same place. The heads are discarded
after stage 2.
"""

from typing import Any, NamedTuple

import numpy as np
import timm
import torch
from jaxtyping import Float, Int
from torch import Tensor, nn

from sim.training.batches import Batch, normalised
from sim.training.fit import PROCESSOR, reduced_precision
from sim.training.frames import THINGS, Frames
from sim.training.places import place_loss
from worlds.labels import ROOM_LABELS

TRUNK = "regnetx_002"
"""Name of the image tower's architecture in timm."""
_SMOOTHING = 0.05
_THINGS_WEIGHT, _PATCHES_WEIGHT, _VIEWS_WEIGHT = 8.0, 8.0, 0.5
"""Weights, relative to the room loss, of the losses for things visible in the image, for things visible in each patch, and
for the room labels in view. The first two weights are large, because their losses are averages over many things, most of
which are absent."""
_PLACES_WEIGHT = 1.0
_PLACE_DIM = 128
_RARE = -4.0
"""Initial logit of the presence of a thing. It is low, since most things are absent from most images."""
_BATCH = 256


class DenseOutput(NamedTuple):
    """Pooled features of images, and the outputs of the linear heads of stage 1 (logits, except for `places`)."""

    pooled: Float[Tensor, "b f"]
    rooms: Float[Tensor, "b labels"]
    views: Float[Tensor, "b labels"]
    things: Float[Tensor, "b things"]
    patches: Float[Tensor, "b things rows columns"]
    places: Float[Tensor, "b p"]
    """Unit vector of each image. The vectors of images of the same place are similar."""


class DenseTower(nn.Module):
    """The image tower without its projection, and the linear heads that predict ground truth in stage 1."""

    def __init__(self, seed: int = 0) -> None:
        super().__init__()
        with torch.random.fork_rng(devices=[]):
            torch.manual_seed(seed)
            trunk: Any = timm.create_model(TRUNK, num_classes=0)
            self.trunk, self.width = trunk, int(trunk.num_features)
            self.rooms, self.views = nn.Linear(self.width, len(ROOM_LABELS)), nn.Linear(self.width, len(ROOM_LABELS))
            self.things, self.patches = nn.Linear(self.width, len(THINGS)), nn.Conv2d(self.width, len(THINGS), 1)
            self.places = nn.Linear(self.width, _PLACE_DIM, bias=False)
        nn.init.constant_(self.things.bias, _RARE)
        nn.init.constant_(self.patches.bias, _RARE)  # type: ignore[arg-type]

    def forward(self, images: Float[Tensor, "b 3 h w"]) -> DenseOutput:
        """Compute the pooled features and the outputs of the heads, and return them in single precision."""
        with reduced_precision():
            maps = self.trunk.forward_features(images)
            pooled = self.trunk.forward_head(maps)
            said = self.rooms(pooled), self.views(pooled), self.things(pooled), self.patches(maps), self.places(pooled)
        rooms, views, things, patches, places = (values.float() for values in said)
        return DenseOutput(pooled.float(), rooms, views, things, patches, nn.functional.normalize(places, dim=-1))

    def columns(self, images: Float[Tensor, "b 3 h w"]) -> Float[Tensor, "b columns f"]:
        """Compute the features of the columns of images. Their mean over an image is its pooled feature."""
        with reduced_precision():
            maps: Tensor = self.trunk.forward_features(images)
        return maps.float().mean(dim=2).swapaxes(1, 2)


def dense_loss(seen: DenseOutput, batch: Batch, weights: Float[Tensor, "labels"]) -> Tensor:
    """Return the weighted sum of the losses of all heads. `weights` are the weights of the labels in the room loss."""
    presence = nn.functional.binary_cross_entropy_with_logits
    return (
        nn.functional.cross_entropy(seen.rooms, batch.rooms, weights, label_smoothing=_SMOOTHING)
        + _VIEWS_WEIGHT * nn.functional.cross_entropy(seen.views, batch.views)
        + _THINGS_WEIGHT * presence(seen.things, batch.things)
        + _PATCHES_WEIGHT * presence(seen.patches, batch.patches)
        + _PLACES_WEIGHT * place_loss(seen.places @ seen.places.T, batch.same_place, batch.apart)
    )


def room_weights(rooms: Int[np.ndarray, "n"]) -> Float[Tensor, "labels"]:
    """Return each label's weight in the room loss, inversely proportional to the root of its number of frames."""
    counts = np.bincount(rooms, minlength=len(ROOM_LABELS))
    weights = np.where(counts > 0, 1.0 / np.sqrt(np.maximum(counts, 1)), 0.0)
    return torch.from_numpy((weights / weights[rooms].mean()).astype(np.float32)).to(PROCESSOR)


class DenseLearner:
    """The learner of stage 1: trains the image tower and its heads on ground truth of images and patches."""

    name = "dense"

    def __init__(self, frames: Frames, seed: int = 0) -> None:
        self.module = DenseTower(seed)
        self._weights = room_weights(frames.rooms)

    def loss(self, batch: Batch, rng: np.random.Generator) -> Tensor:
        """Return the weighted sum of the losses of all heads on a batch."""
        return dense_loss(self.module(batch.images), batch, self._weights)

    def accuracy(self, frames: Frames) -> float:
        """Return the share of frames whose label the room head predicts right, among the labels that occur in `frames`."""
        with torch.inference_mode():
            parts = range(0, len(frames.rooms), _BATCH)
            logits = [self.module(normalised(frames.images[i : i + _BATCH], PROCESSOR)).rooms for i in parts]
        return accuracy_among_present(torch.cat(logits).cpu().numpy(), frames.rooms)


def accuracy_among_present(scores: Float[np.ndarray, "n labels"], rooms: Int[np.ndarray, "n"]) -> float:
    """Return the share of frames whose true label, in `rooms`, has the highest score of all labels that occur there."""
    present = np.unique(rooms)
    return float(np.mean(present[scores[:, present].argmax(axis=1)] == rooms))
