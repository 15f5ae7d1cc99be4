"""Batches of frames: normalised, augmented, with what is present in them after the crop."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import torch
from jaxtyping import Float, Int, UInt8
from torch import Tensor, nn

from lexis.preprocessing import MINI_MEAN, MINI_STD
from sim.training.frames import Frames

PRESENT = 0.004
"""Share of the image from which on a thing counts as present."""
PATCH_PRESENT = 0.02
"""And share of a patch."""


class Batch(NamedTuple):
    """What one step learns from; presence is 0 or 1."""

    images: Float[Tensor, "b 3 h w"]
    rooms: Int[Tensor, "b"]
    views: Float[Tensor, "b labels"]
    """Share of the image by room label, summing to one."""
    things: Float[Tensor, "b things"]
    patches: Float[Tensor, "b things rows columns"]


def batches(frames: Frames, size: int, rng: np.random.Generator, device: torch.device) -> Iterator[Batch]:
    """All frames once, in random order, less those that do not fill the last batch."""
    order = rng.permutation(len(frames.rooms))
    for i in range(0, len(order) - size + 1, size):
        chosen = np.sort(order[i : i + size])
        grid = _crops(size, rng).to(device)
        tint = _tints(size, rng, device)
        images = _sampled(normalised(frames.images[chosen]).to(device), grid, "reflection") * tint[0] + tint[1]
        shares = torch.from_numpy(frames.things[chosen]).permute(0, 3, 1, 2).to(device).float() / 255.0
        patches = _sampled(shares, grid, "zeros")
        views = torch.from_numpy(frames.views[chosen]).to(device) + 1e-4
        yield Batch(
            images.contiguous(memory_format=torch.channels_last),
            torch.from_numpy(frames.rooms[chosen]).to(device),
            views / views.sum(dim=1, keepdim=True),
            (patches.mean(dim=(2, 3)) > PRESENT).float(),
            (patches > PATCH_PRESENT).float(),
        )


def normalised(images: UInt8[np.ndarray, "b h w 3"]) -> Float[Tensor, "b 3 h w"]:
    """Images of the encoder's size as it wants them."""
    pixels = torch.from_numpy(images).permute(0, 3, 1, 2).float() / 255.0
    return (pixels - torch.tensor(MINI_MEAN)[:, None, None]) / torch.tensor(MINI_STD)[:, None, None]


def _crops(n: int, rng: np.random.Generator) -> Float[Tensor, "n 2 3"]:
    """Mirror, zoom and shift a little."""
    zoom = rng.uniform(0.75, 1.0, n)
    theta = np.zeros((n, 2, 3), np.float32)
    theta[:, 0, 0] = zoom * rng.choice([-1.0, 1.0], n)
    theta[:, 1, 1] = zoom
    theta[:, :, 2] = rng.uniform(-1.0, 1.0, (n, 2)) * (1.0 - zoom)[:, None]
    return torch.from_numpy(theta)


def _sampled(maps: Float[Tensor, "b c h w"], theta: Float[Tensor, "b 2 3"], padding: str) -> Float[Tensor, "b c h w"]:
    grid = nn.functional.affine_grid(theta, list(maps.shape), align_corners=False)
    return nn.functional.grid_sample(maps, grid, align_corners=False, padding_mode=padding)


def _tints(
    n: int, rng: np.random.Generator, device: torch.device
) -> tuple[Float[Tensor, "n 3 1 1"], Float[Tensor, "n 1 1 1"]]:
    """Gains per channel and an offset."""
    gain = rng.uniform(0.7, 1.25, (n, 1, 1, 1)) * rng.uniform(0.9, 1.1, (n, 3, 1, 1))
    offset = rng.normal(0.0, 0.15, (n, 1, 1, 1))
    return torch.from_numpy(gain.astype(np.float32)).to(device), torch.from_numpy(offset.astype(np.float32)).to(device)
