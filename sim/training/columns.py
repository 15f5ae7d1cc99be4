"""Training of what the parts of an image show: the rooms in view, column by column.

An image shows more than the room in which the camera stands: the next room through a door, or across an open boundary. The
renderer tells which share of an image shows rooms of each label. Here, every column of the image tower's last feature map
names a label by itself, and the mean over the columns has to be those shares. With this loss, the embeddings of whole images
tell rooms apart better, most of all in open floor plans.
"""

import numpy as np
import torch
from jaxtyping import Bool, Float
from torch import Tensor, nn

from sim.training.fit import PROCESSOR

_LEAST = 1e-4
"""Constant that is added to probabilities before their logarithm is taken, so that one column cannot dominate the loss."""


def contributions(columns: Float[Tensor, "b columns f"], projection: nn.Linear) -> Float[Tensor, "b columns e"]:
    """Project the features of image columns so that the mean over an image's columns is the image's unit embedding."""
    projected: Tensor = projection(columns)
    length: Tensor = projected.mean(dim=1, keepdim=True).norm(dim=2, keepdim=True)
    return projected / length


def columns_loss(
    logits: Float[Tensor, "b columns labels"], ignored: Bool[np.ndarray, "b labels"], shown: Float[Tensor, "b labels"]
) -> Tensor:
    """Return the cross-entropy between the labels in view and the mean over the probabilities of an image's columns.

    Args:
        logits: for every column of each image, the logits of all labels.
        ignored: for each image, the labels with which it is not compared. Labels in view are never ignored.
        shown: share of each image that shows rooms of each label.
    """
    never = torch.from_numpy(ignored).to(PROCESSOR) & (shown <= 0.0)
    named = nn.functional.softmax(logits.masked_fill(never[:, None], -torch.inf), dim=2).mean(dim=1)
    return -(shown * torch.log(named + _LEAST)).sum(dim=1).mean()
