"""`lexis-sim train-encoder`: frames, training with checkpoints, the shipped weights."""

from collections.abc import Iterable
from dataclasses import dataclass, field, fields
from pathlib import Path

import numpy as np
import torch
from rich.console import Console
from rich.progress import track

from lexis.encoder import MINI_CONFIG
from sim.errors import SimError
from sim.training.frames import Frames, render_frames
from sim.training.train import Progress, TrainingConfig, export, train

MINI_WEIGHTS = MINI_CONFIG.with_suffix(".safetensors")
_TUNING_SHARE = 0.06


@dataclass(frozen=True)
class TrainingRun:
    """What `train_encoder` is asked for."""

    houses: int = 300
    training: TrainingConfig = field(default_factory=TrainingConfig)
    work: Path = Path("encoder-training")
    """Folder for the rendered frames and the checkpoint; a run that was stopped goes on from there."""
    out: Path = MINI_WEIGHTS
    workers: int = 2
    """Processes that render."""

    def __post_init__(self) -> None:
        """Raise SimError where a value cannot work."""
        if self.houses < 2:
            raise SimError(f"--houses {self.houses}: needs at least 2, one to train and one to tune on")


def train_encoder(run: TrainingRun, console: Console) -> list[Progress]:
    """Render frames (or take those of an earlier run), train, write the weights; the history is returned."""
    run.work.mkdir(parents=True, exist_ok=True)
    torch.set_num_threads(1)  # two threads on two shared cores were no faster than one
    sets = _frames(run, console)
    tuning_houses = max(1, round(_TUNING_SHARE * len(sets)))
    tuning, training = Frames.joined(sets[:tuning_houses]), Frames.joined(sets[tuning_houses:])
    console.print(
        f"{len(training.rooms)} frames of {len(sets) - tuning_houses} houses; {len(tuning.rooms)} frames to tune on"
    )
    history: list[Progress] = []

    def report(progress: Progress) -> None:
        history.append(progress)
        console.print(f"epoch {progress.epoch}: loss {progress.loss:.3f}, zero-shot accuracy {progress.accuracy:.3f}")

    towers = train(training, tuning, run.training, report, run.work / "checkpoint.pt")
    export(towers, run.out)
    return history


def _frames(run: TrainingRun, console: Console) -> list[Frames]:
    cache = run.work / f"frames-{run.houses}-{run.training.seed}.npz"
    if cache.exists():
        return _load(cache)
    rendered: Iterable[Frames] = render_frames(run.houses, run.training.seed, run.workers)
    if console.is_terminal:
        rendered = track(rendered, "rendering", total=run.houses, console=console)
    sets = list(rendered)
    beside = cache.with_suffix(".part.npz")
    np.savez(beside, **{f"{f.name}-{i}": getattr(s, f.name) for i, s in enumerate(sets) for f in fields(Frames)})
    beside.replace(cache)
    return sets


def _load(cache: Path) -> list[Frames]:
    with np.load(cache, allow_pickle=False) as data:
        count = len(data.files) // len(fields(Frames))
        return [Frames(*(data[f"{f.name}-{i}"] for f in fields(Frames))) for i in range(count)]
