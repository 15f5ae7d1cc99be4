"""The training loop of both stages of the image tower: epochs, learning rate schedule, checkpoints."""

import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol, runtime_checkable

import numpy as np
import torch
from torch import Tensor, nn

from lexis.errors import one_line
from lexis.files.replace import replaced_file
from sim.errors import SimError
from sim.training.batches import Batch, batches
from sim.training.frames import Frames

PROCESSOR = "cuda" if torch.cuda.is_available() else "cpu"


def reduced_precision() -> torch.autocast:
    """Return a context in which a GPU computes in bfloat16, and a CPU in single precision as outside of the context.

    Many CPUs have no instructions for bfloat16. With AVX2 alone, the tower takes 14 times as long in bfloat16.
    """
    return torch.autocast(PROCESSOR, torch.bfloat16, enabled=PROCESSOR == "cuda")


@dataclass(frozen=True)
class Schedule:
    """Length of training and parameters of the optimiser."""

    epochs: int
    learning_rate: float
    batch: int = 128
    weight_decay: float = 0.02
    seed: int = 0


@dataclass(frozen=True)
class Progress:
    """The training progress that is reported after an epoch."""

    stage: str
    epoch: int
    loss: float
    """Mean training loss over the epoch."""
    accuracy: float
    """Share of tuning frames (not used for training) whose room label is predicted right."""


@runtime_checkable
class Learner(Protocol):
    """Interface of a training stage: a module to train, its loss and its accuracy."""

    @property
    def name(self) -> str:
        """Name of the training stage."""
        ...

    @property
    def module(self) -> nn.Module:
        """The module whose parameters are trained."""
        ...

    def loss(self, batch: Batch, rng: np.random.Generator) -> Tensor:
        """Return the loss on one batch, which training minimises."""
        ...

    def accuracy(self, frames: Frames) -> float:
        """Return the share of `frames` whose room label is predicted right."""
        ...


def fit(
    learner: Learner,
    frames: Frames,
    tuning: Frames,
    schedule: Schedule,
    report: Callable[[Progress], None],
    checkpoint: Path | None = None,
) -> None:
    """Train on `frames` and report the accuracy on `tuning` after every epoch.

    Training resumes from the file `checkpoint` if it exists, and writes it after every epoch. With one torch thread on a
    CPU, an interrupted and resumed run ends with the same weights as an uninterrupted one. Raises `SimError` if the frames
    do not fill a batch or the checkpoint cannot be read.
    """
    device = torch.device(PROCESSOR)
    module = learner.module.to(device).to(memory_format=torch.channels_last)  # convolutions on a CPU are a third faster
    parameters = [p for p in module.parameters() if p.requires_grad]
    optimiser = torch.optim.AdamW(parameters, lr=schedule.learning_rate, weight_decay=schedule.weight_decay, fused=True)
    steps = len(frames.rooms) // schedule.batch
    if steps == 0:
        raise SimError(f"{len(frames.rooms)} frames do not fill a batch of {schedule.batch}; valid: more houses")
    rate = torch.optim.lr_scheduler.OneCycleLR(
        optimiser, schedule.learning_rate, total_steps=schedule.epochs * steps, pct_start=0.15
    )
    start = resume(checkpoint, module, optimiser, rate)
    for epoch in range(start, schedule.epochs):
        rng = np.random.default_rng([schedule.seed, epoch])
        losses = []
        module.train()
        for batch in batches(frames, schedule.batch, rng, device):
            loss = learner.loss(batch, rng)
            optimiser.zero_grad()
            loss.backward()  # type: ignore[no-untyped-call]
            optimiser.step()
            rate.step()
            losses.append(loss.item())
        module.eval()
        save_checkpoint(checkpoint, epoch + 1, module, optimiser, rate)
        report(Progress(learner.name, epoch + 1, float(np.mean(losses)), learner.accuracy(tuning)))
    module.eval()


def save_checkpoint(path: Path | None, done: int, *parts: object) -> None:
    """Write the states of modules, optimisers and schedules after some epochs. If the path is None, nothing is written."""
    if path is None:
        return
    with replaced_file(path) as beside:
        torch.save({"epoch": done, "parts": [part.state_dict() for part in parts]}, beside)  # type: ignore[attr-defined]


def resume(path: Path | None, *parts: object) -> int:
    """Load the states that `save_checkpoint` wrote. Return the number of epochs that are done; 0 if there is no file.

    Raises `SimError` for a file that cannot be read, or that holds other states.
    """
    if path is None or not os.path.isfile(path):
        return 0
    try:
        state = torch.load(path, weights_only=True, map_location=PROCESSOR)
        for part, values in zip(parts, state["parts"], strict=True):
            part.load_state_dict(values)  # type: ignore[attr-defined]
        return int(state["epoch"])
    except Exception as error:  # torch raises many types for damaged or foreign files
        raise SimError(f"{path}: cannot resume from it: {one_line(error)}; delete it to start the stage again") from None
