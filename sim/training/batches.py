"""Makes batches of training frames: normalised and augmented images, and the things that are visible after cropping."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import torch
from jaxtyping import Bool, Float, Int, UInt8
from torch import Tensor, nn

from lexis.encoder.preprocessing import MINI_MEAN, MINI_STD
from sim.training.frames import Frames
from sim.training.places import pairs_of_places

PRESENT = 0.004
"""A thing counts as present in an image if it fills more than this share of the image."""
PATCH_PRESENT = 0.02
"""A thing counts as present in a patch of an image if it fills more than this share of the patch."""
STRETCH = 4
"""Number of consecutive frames of a walk that stay together in a batch. Batches thus contain several views of a house."""


class Batch(NamedTuple):
    """Input and targets of one training step. Presence is given as 0 or 1."""

    images: Float[Tensor, "b 3 h w"]
    rooms: Int[Tensor, "b"]
    views: Float[Tensor, "b labels"]
    """Share of each image that shows rooms of each label, before cropping. The shares of an image are scaled to sum to 1."""
    things: Float[Tensor, "b things"]
    """Whether each thing is present in each image."""
    patches: Float[Tensor, "b things rows columns"]
    """Whether each thing is present in each patch of each image."""
    same_place: Bool[Tensor, "b b"]
    """Whether each pair of frames shows the same place, as decided by `places.pairs_of_places`."""
    apart: Bool[Tensor, "b b"]
    """Whether each pair of frames shows different places, as decided by `places.pairs_of_places`. Some pairs are neither in
    `same_place` nor in `apart`."""


def batches(frames: Frames, size: int, rng: np.random.Generator, device: torch.device) -> Iterator[Batch]:
    """Yield batches that contain each frame once, in random order. Frames that do not fill a last batch are left out."""
    for chosen in chosen_once(frames.houses, size, rng):
        _, house = np.unique(frames.houses[chosen], return_inverse=True)
        grid = _crops(house, rng).to(device)
        tint = _tints(house, rng, device)
        images = _sampled(normalised(frames.images[chosen], device), grid, "reflection") * tint[0] + tint[1]
        shares = torch.from_numpy(frames.things[chosen]).permute(0, 3, 1, 2).to(device).float() / 255.0
        patches = _sampled(shares, grid, "zeros")
        views = torch.from_numpy(frames.views[chosen]).to(device) + 1e-4
        same, apart = pairs_of_places(frames.T_W_B[chosen], frames.houses[chosen], frames.rooms[chosen])
        yield Batch(
            images.contiguous(memory_format=torch.channels_last),
            torch.from_numpy(frames.rooms[chosen]).to(device),
            views / views.sum(dim=1, keepdim=True),
            (patches.mean(dim=(2, 3)) > PRESENT).float(),
            (patches > PATCH_PRESENT).float(),
            torch.from_numpy(same).to(device),
            torch.from_numpy(apart).to(device),
        )


def normalised(images: UInt8[np.ndarray, "b h w 3"], device: torch.device | str) -> Float[Tensor, "b 3 h w"]:
    """Normalise RGB images of the encoder's input size with the encoder's mean and standard deviation, on a device."""
    pixels = torch.from_numpy(images).to(device).permute(0, 3, 1, 2).float() / 255.0  # bytes are a quarter of the floats
    mean, std = (torch.tensor(values, device=device)[:, None, None] for values in (MINI_MEAN, MINI_STD))
    return (pixels - mean) / std


def chosen_once(houses: Int[np.ndarray, "n"], size: int, rng: np.random.Generator) -> Iterator[Int[np.ndarray, "size"]]:
    """Yield the indices of the frames of each batch, in ascending order. No frame occurs in two batches.

    The frames are cut into groups of `STRETCH` consecutive frames. The groups are shuffled and joined to batches. All frames
    of a group are from one walk, except that a group at the end of a walk may continue with frames of another walk.
    """
    walks = np.split(np.arange(len(houses)), np.flatnonzero(np.diff(houses)) + 1)
    joined = np.concatenate([np.roll(walks[i], rng.integers(len(walks[i]))) for i in rng.permutation(len(walks))])
    stretches = np.array_split(joined, range(STRETCH, len(joined), STRETCH))
    order = np.concatenate([stretches[i] for i in rng.permutation(len(stretches))])
    return (np.sort(order[i : i + size]) for i in range(0, len(order) - size + 1, size))


def _crops(house: Int[np.ndarray, "n"], rng: np.random.Generator) -> Float[Tensor, "n 2 3"]:
    """Draw random affine crops: each frame is zoomed and shifted a little.

    Either all or none of a house's frames are mirrored, since a place and its mirror image would count as the same place.
    """
    n = len(house)
    zoom, mirrored = rng.uniform(0.75, 1.0, n), rng.choice([-1.0, 1.0], house.max() + 1)
    theta = np.zeros((n, 2, 3), np.float32)
    theta[:, 0, 0] = zoom * mirrored[house]
    theta[:, 1, 1] = zoom
    theta[:, :, 2] = rng.uniform(-1.0, 1.0, (n, 2)) * (1.0 - zoom)[:, None]
    return torch.from_numpy(theta)


def _sampled(maps: Float[Tensor, "b c h w"], theta: Float[Tensor, "b 2 3"], padding: str) -> Float[Tensor, "b c h w"]:
    grid = nn.functional.affine_grid(theta, list(maps.shape), align_corners=False)
    return nn.functional.grid_sample(maps, grid, align_corners=False, padding_mode=padding)


def _tints(
    house: Int[np.ndarray, "n"], rng: np.random.Generator, device: torch.device
) -> tuple[Float[Tensor, "n 3 1 1"], Float[Tensor, "n 1 1 1"]]:
    """Draw random gains per channel and random offsets.

    All frames of a house get the same gains and offset, so that frames of the same place keep the same colours.
    """
    houses = house.max() + 1
    gain = rng.uniform(0.7, 1.25, (houses, 1, 1, 1)) * rng.uniform(0.9, 1.1, (houses, 3, 1, 1))
    offset = rng.normal(0.0, 0.15, (houses, 1, 1, 1))
    gains, offsets = (torch.from_numpy(tint[house].astype(np.float32)).to(device) for tint in (gain, offset))
    return gains, offsets
