"""Stage 2 of the image tower: alignment with the frozen text tower, through text similarity alone.

Every image is compared with captions, never with class weights: its room over one freshly worded caption per label, the
presence of every thing over a caption that names it. Noise on the text embeddings keeps the image tower from using what
only the trained wordings share. The dense losses stay on, so that nothing that was learned is lost.
"""

import math
from collections.abc import Callable, Sequence

import numpy as np
import torch
from jaxtyping import Float, Float32
from open_clip.transformer import TextTransformer
from torch import Tensor, nn

from lexis.prompts import prompts
from sim.training.batches import Batch, normalised
from sim.training.dense import DenseTower, Seen, dense_loss, room_weights, told_right
from sim.training.fit import PROCESSOR
from sim.training.frames import THINGS, Frames
from sim.training.phrases import object_caption, room_caption
from sim.training.text_tower import encode_texts
from worlds.labels import ROOM_LABELS

TEXT_NOISE = 1.5
"""Length of the noise added to unit text embeddings."""
WORDINGS = (200, 32)
"""Captions drawn of every room label and of every thing, once; of these, every step draws one each."""
_SMOOTHING = 0.05
_THINGS_WEIGHT, _DENSE_WEIGHT = 4.0, 0.5
_BATCH = 256


class AlignedTower(nn.Module):
    """The dense tower with its projection into the text tower's space."""

    def __init__(self, dense: DenseTower, embed_dim: int, seed: int = 0) -> None:
        super().__init__()
        self.dense = dense
        with torch.random.fork_rng(devices=[]):
            torch.manual_seed(seed)
            self.projection = nn.Linear(dense.width, embed_dim, bias=False)
        self.room_scale = nn.Parameter(torch.tensor(math.log(20.0)))
        self.thing_scale = nn.Parameter(torch.tensor(math.log(15.0)))
        self.thing_bias = nn.Parameter(torch.tensor(-5.0))

    def forward(self, images: Float[Tensor, "b 3 h w"]) -> tuple[Float[Tensor, "b e"], Seen]:
        """Unit embeddings, and what the dense heads see."""
        seen = self.dense(images)
        return nn.functional.normalize(self.projection(seen.pooled), dim=-1), seen


class AlignLearner:
    """Stage 2."""

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
        """The losses of rooms and things by captions, and the dense one."""
        embedding, seen = self.module(batch.images)
        rooms, things = _drawn(self._rooms, rng), _drawn(self._things, rng)
        tower = self.module
        by_room = tower.room_scale.exp() * embedding @ rooms.T
        by_thing = tower.thing_scale.exp() * embedding @ things.T + tower.thing_bias
        return (
            nn.functional.cross_entropy(by_room, batch.rooms, self._weights, label_smoothing=_SMOOTHING)
            + _THINGS_WEIGHT * nn.functional.binary_cross_entropy_with_logits(by_thing, batch.things)
            + _DENSE_WEIGHT * dense_loss(seen, batch, self._weights)
        )

    def accuracy(self, frames: Frames) -> float:
        """Zero-shot: the most similar room name among the labels present, each by its ensemble of prompts."""
        return told_right(self.embeddings(frames) @ room_embeddings(self._text, ROOM_LABELS).T, frames.rooms)

    def embeddings(self, frames: Frames) -> Float[np.ndarray, "n e"]:
        """Of images as they are, unit norm."""
        with torch.inference_mode():
            parts = range(0, len(frames.rooms), _BATCH)
            found = [self.module(normalised(frames.images[i : i + _BATCH]).to(PROCESSOR))[0] for i in parts]
        return np.asarray(torch.cat(found).cpu().numpy())


def room_embeddings(text: TextTransformer, names: Sequence[str]) -> Float[np.ndarray, "names e"]:
    """As `lexis.encoder` embeds room names: unit means over prompts."""
    said = encode_texts(text, [prompt for name in names for prompt in prompts(name)])
    means = said.reshape(len(names), -1, said.shape[1]).mean(axis=1)
    return np.asarray(means / np.linalg.norm(means, axis=1, keepdims=True))


def _wordings(
    text: TextTransformer,
    names: Sequence[str],
    caption: Callable[[str, np.random.Generator], str],
    count: int,
    rng: np.random.Generator,
) -> Float32[np.ndarray, "names count e"]:
    """Unit embeddings of `count` captions of every name."""
    drawn = encode_texts(text, [caption(name, rng) for name in names for _ in range(count)])
    return drawn.reshape(len(names), count, -1)


def _drawn(wordings: Float32[np.ndarray, "names count e"], rng: np.random.Generator) -> Float[Tensor, "names e"]:
    """One unit embedding of every name, blurred."""
    names, count, width = wordings.shape
    exact = wordings[np.arange(names), rng.integers(count, size=names)]
    noise = rng.normal(0.0, TEXT_NOISE / math.sqrt(width), exact.shape)
    return nn.functional.normalize(torch.from_numpy((exact + noise).astype(np.float32)), dim=-1).to(PROCESSOR)
