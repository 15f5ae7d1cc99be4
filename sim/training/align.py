"""Stage 2 of training the image tower: alignment with the frozen text tower.

Images are compared only with embeddings of captions, never with learned class weights. The loss has five parts:

1. Room: cross-entropy over one randomly drawn caption per room label.
2. Things: for every kind of thing, binary cross-entropy of its presence, by the similarity to a caption with its name.
3. Search: every caption is compared with all images of a batch, since questions are answered by the images that fit best.
4. Places: a contrastive loss that makes images of the same place similar.
5. Dense: the losses of stage 1 are kept, so that the tower does not forget stage 1.

Noise is added to the text embeddings, so that the image tower does not rely on details that only the trained wordings share.
At the end, `sim.training.settling` trains only the tower's last layer, the projection.
"""

import math
from collections.abc import Callable, Sequence

import numpy as np
import torch
from jaxtyping import Float, Float32, Int
from open_clip.transformer import TextTransformer
from torch import Tensor, nn

from lexis.encoder.prompts import prompts
from sim.training.batches import Batch, normalised
from sim.training.dense import DenseOutput, DenseTower, accuracy_among_present, dense_loss, room_weights
from sim.training.fit import PROCESSOR
from sim.training.frames import THINGS, Frames
from sim.training.phrases import object_caption, room_caption
from sim.training.places import place_loss
from sim.training.text_tower import encode_texts
from worlds.labels import ROOM_LABELS

TEXT_NOISE = 1.25
"""Expected length of the noise vector that is added to unit text embeddings."""
WORDINGS = (200, 32)
"""Numbers of captions that are drawn in advance for each room label, and for each thing. A training step uses one caption
for each label and one for each thing."""
_SMOOTHING = 0.05
_THINGS_WEIGHT, _DENSE_WEIGHT = 4.0, 0.5
_PLACES_WEIGHT = 1.0
_ROOM_SEARCH_WEIGHT, _THING_SEARCH_WEIGHT = 0.5, 1.0
"""Weights of the search losses for captions of rooms and of things."""
_BATCH = 256


class AlignedTower(nn.Module):
    """The tower of stage 1 with a projection into the text tower's embedding space, and scales of the losses' logits."""

    def __init__(self, dense: DenseTower, embed_dim: int, seed: int = 0) -> None:
        super().__init__()
        self.dense = dense
        with torch.random.fork_rng(devices=[]):
            torch.manual_seed(seed)
            self.projection = nn.Linear(dense.width, embed_dim, bias=False)
        self.room_scale = nn.Parameter(torch.tensor(math.log(20.0)))
        self.thing_scale = nn.Parameter(torch.tensor(math.log(15.0)))
        self.thing_bias = nn.Parameter(torch.tensor(-5.0))
        self.search_scale = nn.Parameter(torch.tensor(math.log(15.0)))

    def forward(self, images: Float[Tensor, "b 3 h w"]) -> tuple[Float[Tensor, "b e"], DenseOutput]:
        """Return the unit embeddings of images, and the output of the heads of stage 1."""
        seen = self.dense(images)
        return self.embedded(seen.pooled), seen

    def embedded(self, pooled: Float[Tensor, "b f"]) -> Float[Tensor, "b e"]:
        """Project pooled features of images to unit embeddings."""
        return nn.functional.normalize(self.projection(pooled), dim=-1)


class AlignLearner:
    """The learner of stage 2: aligns the image tower with the text tower; see the module's docstring for its loss."""

    name = "align"

    def __init__(
        self,
        dense: DenseTower,
        text: TextTransformer,
        frames: Frames,
        seed: int = 0,
        wordings: tuple[int, int] = WORDINGS,
    ) -> None:
        self.module = AlignedTower(dense, text.text_projection.shape[1], seed)
        self._text, self._weights = text, room_weights(frames.rooms)
        rng = np.random.default_rng([seed, 3])
        self._rooms = _wordings(text, ROOM_LABELS, room_caption, wordings[0], rng)
        self._things = _wordings(text, THINGS, object_caption, wordings[1], rng)

    def loss(self, batch: Batch, rng: np.random.Generator) -> Tensor:
        """Return the weighted sum of the losses: captions (rooms, things, search), places, and the dense loss of stage 1."""
        embedding, seen = self.module(batch.images)
        captions = self.caption_loss(embedding, batch.rooms, batch.things, rng)
        places = place_loss(embedding @ embedding.T, batch.same_place, batch.apart)
        return captions + _PLACES_WEIGHT * places + _DENSE_WEIGHT * dense_loss(seen, batch, self._weights)

    def caption_loss(
        self,
        embedding: Float[Tensor, "b e"],
        own: Int[Tensor, "b"],
        shown: Float[Tensor, "b things"],
        rng: np.random.Generator,
    ) -> Tensor:
        """Return the weighted sum of the losses of rooms, of things, and of the search for images by captions.

        `own` is the label of the room that contains the camera, and `shown` is 1 for the things that an image shows.
        """
        tower = self.module
        to_room, to_thing = self.to_rooms(embedding, rng), embedding @ _drawn(self._things, rng).T
        room, search = tower.room_scale.exp() * to_room, tower.search_scale.exp()
        present = tower.thing_scale.exp() * to_thing + tower.thing_bias
        in_room = nn.functional.one_hot(own, len(ROOM_LABELS)).float()
        return (
            nn.functional.cross_entropy(room, own, self._weights, label_smoothing=_SMOOTHING)
            + _THINGS_WEIGHT * nn.functional.binary_cross_entropy_with_logits(present, shown)
            + _ROOM_SEARCH_WEIGHT * _search_loss(search * to_room, in_room)
            + _THING_SEARCH_WEIGHT * _search_loss(search * to_thing, shown)
        )

    def to_rooms(self, embedding: Float[Tensor, "b e"], rng: np.random.Generator) -> Float[Tensor, "b labels"]:
        """Return the similarities of images with one randomly drawn caption for each room label."""
        return embedding @ _drawn(self._rooms, rng).T

    def accuracy(self, frames: Frames) -> float:
        """Return the share of frames whose true room label is the one with the most similar text embedding (zero-shot).

        Only labels that occur in `frames` are compared. `room_embeddings` computes the text embeddings.
        """
        return accuracy_among_present(self.embeddings(frames) @ room_embeddings(self._text, ROOM_LABELS).T, frames.rooms)

    def embeddings(self, frames: Frames) -> Float[np.ndarray, "n e"]:
        """Return the embeddings, of unit norm, of images without augmentation."""
        with torch.inference_mode():
            return np.asarray(self.module.embedded(self.pooled(frames)).cpu().numpy())

    def pooled(self, frames: Frames) -> Float[Tensor, "n f"]:
        """Return the pooled features of images without augmentation."""
        return _in_parts(frames, lambda images: self.module.dense(images).pooled)

    def columns(self, frames: Frames) -> Float[Tensor, "n columns f"]:
        """Return the features of the columns of images without augmentation; see `DenseTower.columns`."""
        return _in_parts(frames, self.module.dense.columns)


def room_embeddings(text: TextTransformer, names: Sequence[str]) -> Float[np.ndarray, "names e"]:
    """Embed room names as `lexis.encoder.open_clip_encoder` does: mean over a name's prompts, scaled to unit norm."""
    said = encode_texts(text, [prompt for name in names for prompt in prompts(name)])
    means = said.reshape(len(names), -1, said.shape[1]).mean(axis=1)
    return np.asarray(means / np.linalg.norm(means, axis=1, keepdims=True))


def _in_parts(frames: Frames, tower: Callable[[Tensor], Tensor]) -> Tensor:
    """Return what a tower computes from images, which it gets in parts that fit in memory."""
    with torch.no_grad():
        parts = range(0, len(frames.rooms), _BATCH)
        return torch.cat([tower(normalised(frames.images[i : i + _BATCH], PROCESSOR)) for i in parts])


def _search_loss(logits: Float[Tensor, "b captions"], shown: Float[Tensor, "b captions"]) -> Tensor:
    """Return the cross-entropy of finding, for each caption, the images of the batch that show it (where `shown` is 1).

    The loss is the mean over all captions that some image shows, so that rare things count as much as common ones; it is 0
    if no image shows any of them, as may happen in a small batch.
    """
    counts = shown.sum(dim=0)
    found = (shown * nn.functional.log_softmax(logits, dim=0)).sum(dim=0)
    some = counts > 0
    return -(found[some] / counts[some]).mean() if some.any() else logits.sum() * 0.0


def _wordings(
    text: TextTransformer,
    names: Sequence[str],
    caption: Callable[[str, np.random.Generator], str],
    count: int,
    rng: np.random.Generator,
) -> Float32[np.ndarray, "names count e"]:
    """Return the unit embeddings of `count` randomly drawn captions for each name."""
    drawn = encode_texts(text, [caption(name, rng) for name in names for _ in range(count)])
    return drawn.reshape(len(names), count, -1)


def _drawn(wordings: Float32[np.ndarray, "names count e"], rng: np.random.Generator) -> Float[Tensor, "names e"]:
    """Return, for each name, the embedding of one of its captions with noise added, scaled to unit norm."""
    names, count, width = wordings.shape
    exact = wordings[np.arange(names), rng.integers(count, size=names)]
    noise = rng.normal(0.0, TEXT_NOISE / math.sqrt(width), exact.shape)
    return nn.functional.normalize(torch.from_numpy((exact + noise).astype(np.float32)), dim=-1).to(PROCESSOR)
