"""Train `lexis-mini`: both CLIP towers together, on renders of our own houses, through text similarity alone.

Every image is compared with captions, never with class weights: the room's cross-entropy runs over the similarity of the
image to one freshly worded caption per room label, and the presence of every kind of object over its similarity to a
caption that names the kind. A linear head on the image tower's features, thrown away afterwards, sees the objects too: it
gives the tower dense gradients. Reweighting, augmentation and wording are drawn from one seed.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import open_clip
import torch
from jaxtyping import Float, Int
from safetensors.torch import save_file
from torch import Tensor, nn

from lexis.encoder import MINI_CONFIG, MINI_MEAN, MINI_STD
from lexis.prompts import prompts
from sim.training.frames import OBJECT_KINDS, Frames
from sim.training.phrases import caption, room_caption
from worlds.labels import ROOM_LABELS

_PRESENT = 0.004
"""Share of the image from which on an object counts as present."""


@dataclass(frozen=True)
class TrainingConfig:
    """How long and how hard to train."""

    epochs: int = 9
    batch: int = 128
    learning_rate: float = 3e-3
    weight_decay: float = 0.02
    object_weight: float = 4.0
    """Of the object losses beside the room's."""
    label_smoothing: float = 0.05
    seed: int = 0


@dataclass(frozen=True)
class Progress:
    """What is reported after every epoch."""

    epoch: int
    loss: float
    """Mean over the epoch."""
    accuracy: float
    """Share of tuning frames whose most similar room caption names their room."""


class Towers(nn.Module):
    """The CLIP model with what training needs beside it: logit scales and the dense head."""

    def __init__(self) -> None:
        super().__init__()
        open_clip.add_model_config(MINI_CONFIG)
        self.clip = open_clip.create_model(MINI_CONFIG.stem)
        self.tokenizer = open_clip.get_tokenizer(MINI_CONFIG.stem)
        self.dense = nn.Linear(self.clip.visual.head.proj.in_features, len(OBJECT_KINDS))
        self.room_scale = nn.Parameter(torch.tensor(math.log(10.0)))
        self.object_scale = nn.Parameter(torch.tensor(math.log(10.0)))
        self.object_bias = nn.Parameter(torch.tensor(-5.0))

    def image(self, images: Float[Tensor, "b 3 h w"]) -> tuple[Float[Tensor, "b d"], Float[Tensor, "b kinds"]]:
        """Unit embeddings and the dense head's logits."""
        pooled = self.clip.visual.trunk(images)
        return nn.functional.normalize(self.clip.visual.head(pooled).float(), dim=-1), self.dense(pooled).float()

    def text(self, captions: Sequence[str]) -> Float[Tensor, "c d"]:
        """Unit embeddings of captions."""
        return nn.functional.normalize(self.clip.encode_text(self.tokenizer(list(captions))).float(), dim=-1)


def train(
    frames: Frames,
    tuning: Frames,
    config: TrainingConfig,
    report: Callable[[Progress], None],
    checkpoint: Path | None = None,
) -> Towers:
    """Train on `frames`, report accuracy on `tuning` after every epoch; resume from `checkpoint` where it exists."""
    torch.manual_seed(config.seed)
    towers = Towers().to(memory_format=torch.channels_last)  # convolutions on a CPU are a third faster
    optimiser = torch.optim.AdamW(towers.parameters(), lr=config.learning_rate, weight_decay=config.weight_decay)
    steps = len(frames.rooms) // config.batch
    schedule = torch.optim.lr_scheduler.OneCycleLR(optimiser, config.learning_rate, total_steps=config.epochs * steps)
    start = _resume(checkpoint, towers, optimiser, schedule)
    weights = _room_weights(frames.rooms)
    for epoch in range(start, config.epochs):
        rng = np.random.default_rng([config.seed, epoch])
        losses = []
        towers.train()
        for images, rooms, present in _batches(frames, config.batch, rng):
            loss = _loss(towers, images, rooms, present, weights, config, rng)
            optimiser.zero_grad()
            loss.backward()  # type: ignore[no-untyped-call]
            optimiser.step()
            schedule.step()
            losses.append(float(loss.detach()))
        report(Progress(epoch + 1, float(np.mean(losses)), accuracy(towers, tuning)))
        _save(checkpoint, epoch + 1, towers, optimiser, schedule)
    return towers


def _loss(
    towers: Towers,
    images: Tensor,
    rooms: Tensor,
    present: Tensor,
    weights: Tensor,
    config: TrainingConfig,
    rng: np.random.Generator,
) -> Tensor:
    with torch.autocast("cpu", torch.bfloat16):
        embedding, dense = towers.image(images)
    text = towers.text([room_caption(label, rng) for label in ROOM_LABELS] + [caption(kind, rng) for kind in OBJECT_KINDS])
    room_text, object_text = text[: len(ROOM_LABELS)], text[len(ROOM_LABELS) :]
    room_logits = towers.room_scale.exp() * embedding @ room_text.T
    object_logits = towers.object_scale.exp() * embedding @ object_text.T + towers.object_bias
    room_loss = nn.functional.cross_entropy(room_logits, rooms, weights, label_smoothing=config.label_smoothing)
    object_loss = nn.functional.binary_cross_entropy_with_logits(object_logits, present)
    dense_loss = nn.functional.binary_cross_entropy_with_logits(dense, present)
    return room_loss + config.object_weight * (object_loss + dense_loss)


def accuracy(towers: Towers, frames: Frames) -> float:
    """Zero-shot share of frames whose room's caption, "a photo of ...", is the most similar one among the labels present."""
    towers.eval()
    with torch.inference_mode():
        text = towers.text([prompts(label)[0] for label in ROOM_LABELS])
        batches = range(0, len(frames.rooms), 256)
        embeddings = torch.cat([towers.image(_normalised(frames.images[i : i + 256]))[0] for i in batches])
    similarity = (embeddings @ text.T).numpy()
    similarity[:, ~np.isin(np.arange(len(ROOM_LABELS)), frames.rooms)] = -np.inf
    return float(np.mean(similarity.argmax(axis=1) == frames.rooms))


def export(towers: Towers, path: Path) -> None:
    """Write the CLIP model alone, in half precision."""
    save_file({name: value.half().contiguous() for name, value in towers.clip.state_dict().items()}, path)


def _batches(frames: Frames, size: int, rng: np.random.Generator) -> Iterator[tuple[Tensor, Tensor, Tensor]]:
    order = rng.permutation(len(frames.rooms))
    for i in range(0, len(order) - size + 1, size):
        chosen = order[i : i + size]
        present = torch.from_numpy((frames.shares[chosen] > _PRESENT).astype(np.float32))
        yield _augmented(_normalised(frames.images[chosen]), rng), torch.from_numpy(frames.rooms[chosen]), present


def _normalised(images: np.ndarray) -> Float[Tensor, "b 3 h w"]:
    pixels = torch.from_numpy(images).permute(0, 3, 1, 2).float() / 255.0
    return (pixels - torch.tensor(MINI_MEAN)[:, None, None]) / torch.tensor(MINI_STD)[:, None, None]


def _augmented(images: Float[Tensor, "b 3 h w"], rng: np.random.Generator) -> Float[Tensor, "b 3 h w"]:
    """Mirror, zoom and shift a little, change gain and tint; per image."""
    n = len(images)
    zoom = rng.uniform(0.75, 1.0, (n, 1))
    theta = np.zeros((n, 2, 3), np.float32)
    theta[:, 0, 0] = (zoom * rng.choice([-1.0, 1.0], (n, 1)))[:, 0]
    theta[:, 1, 1] = zoom[:, 0]
    theta[:, :, 2] = rng.uniform(-1.0, 1.0, (n, 2)) * (1.0 - zoom)
    grid = nn.functional.affine_grid(torch.from_numpy(theta), list(images.shape), align_corners=False)
    moved = nn.functional.grid_sample(images, grid, align_corners=False, padding_mode="reflection")
    gain = torch.from_numpy(rng.uniform(0.85, 1.15, (n, 3, 1, 1)).astype(np.float32))
    offset = torch.from_numpy(rng.normal(0.0, 0.15, (n, 1, 1, 1)).astype(np.float32))
    return (moved * gain + offset).contiguous(memory_format=torch.channels_last)


def _room_weights(rooms: Int[np.ndarray, "n"]) -> Float[Tensor, "labels"]:
    """Rare labels count more, by the square root of their rarity."""
    counts = np.bincount(rooms, minlength=len(ROOM_LABELS))
    weights = np.where(counts > 0, 1.0 / np.sqrt(np.maximum(counts, 1)), 0.0)
    return torch.from_numpy((weights / (weights[rooms].mean())).astype(np.float32))


def _save(path: Path | None, epoch: int, towers: Towers, *others: object) -> None:
    if path is None:
        return
    state = {"epoch": epoch, "towers": towers.state_dict(), "others": [other.state_dict() for other in others]}  # type: ignore[attr-defined]
    beside = path.with_suffix(".part")
    torch.save(state, beside)
    beside.replace(path)


def _resume(path: Path | None, towers: Towers, *others: object) -> int:
    if path is None or not path.exists():
        return 0
    state = torch.load(path, weights_only=True)
    towers.load_state_dict(state["towers"])
    for other, other_state in zip(others, state["others"], strict=True):
        other.load_state_dict(other_state)  # type: ignore[attr-defined]
    return int(state["epoch"])


__all__ = ["Progress", "Towers", "TrainingConfig", "accuracy", "export", "train"]
