"""`lexis-sim train-encoder`: trains the encoder, from rendered houses to weights. An interrupted training resumes.

The steps are: train the text tower, render frames, train the image tower in two stages, settle its projection, write and
calibrate the weights.
"""

import json
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, field
from itertools import chain
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import torch
from annotated_types import Ge
from open_clip.transformer import TextTransformer
from rich.console import Console

from lexis.encoder.model_source import MINI_CONFIG
from lexis.encoder.open_clip_encoder import load_encoder
from lexis.files.reading import FileKind, read_json
from lexis.files.replace import replaced_file
from lexis.settings import Settings
from sim.errors import SimError
from sim.training.align import WORDINGS, AlignLearner
from sim.training.dense import DenseLearner, DenseTower
from sim.training.export import export, start_trunk_from
from sim.training.fit import Progress, Schedule, fit
from sim.training.frames import BARE, Frames, rendered
from sim.training.houses import TRAINING_SEEDS, TUNING_SEEDS, HouseDraw, draw_houses
from sim.training.question_calibration import write_calibration
from sim.training.settling import STEPS, settle
from sim.training.teacher import load_teacher
from sim.training.temperature import fit_temperature
from sim.training.text_tower import (
    EMBED_DIM,
    TEXT_CFG,
    DistilConfig,
    DistilProgress,
    distil,
    load_text_tower,
    save_text_tower,
)

MINI_WEIGHTS = MINI_CONFIG.with_suffix(".safetensors")
_SETTINGS = "settings.json"
_SETTINGS_FILE = FileKind(
    "those of this run; else delete it", 1_000_000, SimError, missing="no settings in it", unusable="no settings in it"
)


@dataclass(frozen=True)
class TrainingRun(Settings, place="training", error=SimError):
    """Settings of one training of the encoder, from rendered houses to weights."""

    houses: Annotated[int, Ge(1)] = 520
    """Number of houses to train on."""
    tuning_houses: Annotated[int, Ge(1)] = 24
    """Number of further houses, for monitoring the training and for fitting the temperature and the calibration."""
    epochs: tuple[int, int] = (10, 4)
    """Numbers of epochs of stage 1 (dense supervision) and stage 2 (alignment) of the image tower."""
    settling_houses: Annotated[int, Ge(1)] | None = None
    """Number of houses on whose frames the projection settles: the houses to train on, and further ones. None: twice as many
    as the houses to train on."""
    settling_steps: Annotated[int, Ge(1)] = STEPS
    """Number of training steps at the end in which only the projection, the image tower's last layer, is trained."""
    seed: int = 0
    work: Path = Path("encoder-training")
    """Folder for frames, text tower and checkpoints. An interrupted training resumes from the files in it."""
    out: Path = MINI_WEIGHTS
    """File of the weights, whose name ends in ".safetensors"; the model's configuration is written beside it."""
    workers: Annotated[int, Ge(1)] = 2
    """Number of rendering processes, and number of threads for training."""
    start: Path | None = None
    """Weights of an earlier `lexis-mini` with which the image tower starts. None: the image tower starts untrained."""
    teacher: Path | None = None
    """Folder with the sentence encoder that the text tower learns to imitate. None: the installed package."""
    batch: Annotated[int, Ge(1)] = 128
    """Number of images in a batch."""
    wordings: tuple[int, int] = WORDINGS
    """Numbers of captions that are drawn for each room label, and for each thing."""
    distillation: DistilConfig = field(default_factory=DistilConfig)

    def __post_init__(self) -> None:
        """Raise SimError for values that are not valid."""
        super().__post_init__()
        for name in ("epochs", "wordings"):
            if min(getattr(self, name)) < 1:
                self.refuse(name, "at least 1 each")
        if self.settling_houses is not None and self.settling_houses < self.houses:
            self.refuse("settling_houses", f"at least the number of houses to train on, {self.houses}")
        if self.out.suffix != MINI_WEIGHTS.suffix:
            raise SimError(f"training.out is {self.out}; valid: a name that ends in {MINI_WEIGHTS.suffix}")


def train_encoder(run: TrainingRun, console: Console) -> list[Progress]:
    """Run the steps that are not done yet, and write weights and configuration. Return the progress after their epochs.

    Raises `SimError` if the work folder belongs to a run with other settings, or if `run.start` holds no image tower.
    """
    run.work.mkdir(parents=True, exist_ok=True)
    _check_settings(run)
    if run.start is not None:
        start_trunk_from(run.start, DenseTower())  # checks the file, which is used only after hours
    _keep_settings(run)
    torch.set_num_threads(run.workers)
    text = _text_tower(run, console)
    tuning = _frames(run, console, "tuning", run.tuning_houses, TUNING_SEEDS)
    training = _furnished(_frames(run, console, "training", run.houses, TRAINING_SEEDS))
    console.print(f"{len(training.rooms)} frames to train on, less those of bare walls; {len(tuning.rooms)} to tune on")
    history: list[Progress] = []

    settled = run.work / "settled.pt"

    def report(progress: Progress) -> None:
        history.append(progress)
        settled.unlink(missing_ok=True)  # it was settled for the tower before this epoch
        console.print(
            f"{progress.stage} epoch {progress.epoch}: loss {progress.loss:.3f}, tuning accuracy {progress.accuracy:.3f}"
        )

    dense = DenseLearner(training, run.seed)
    if run.start is not None:
        start_trunk_from(run.start, dense.module)
    first, second = _schedules(run)
    fit(dense, training, tuning, first, report, run.work / "dense.pt")
    align = AlignLearner(dense.module, text, training, run.seed, run.wordings)
    fit(align, training, tuning, second, report, run.work / "align.pt")
    settling = _draws(run, run.settling_houses or 2 * run.houses, TRAINING_SEEDS)
    more = _rendered(run, console, "more training", settling[run.houses :])
    settle(align, chain([training], map(_furnished, more)), run.seed, run.settling_steps, settled)
    console.print(f"projection settled: tuning accuracy {align.accuracy(tuning):.3f}")
    temperature = fit_temperature(align.embeddings(tuning), text, tuning.rooms)
    console.print(f"temperature {temperature:.4f}, fitted on the tuning frames")
    export(align.module, text, temperature, run.out)
    write_calibration(load_encoder(f"{MINI_CONFIG.stem}:{run.out}"), run.out, run.tuning_houses, run.seed)
    console.print("probabilities of queries calibrated on the tuning houses")
    return history


def _schedules(run: TrainingRun) -> tuple[Schedule, Schedule]:
    gentle = run.start is not None
    first = Schedule(run.epochs[0], 1.5e-3 if gentle else 3e-3, run.batch, seed=run.seed)
    return first, Schedule(run.epochs[1], 1e-3, run.batch, seed=run.seed + 1)


def _check_settings(run: TrainingRun) -> None:
    """Raise `SimError` if the work folder holds the settings of another run, or something else in their place."""
    path = run.work / _SETTINGS
    if not path.exists():
        return
    before, asked = read_json(path, _SETTINGS_FILE), json.loads(json.dumps(_deciding(run)))
    if not isinstance(before, dict):
        raise _SETTINGS_FILE.refusal(path, "is no object")
    differs = [f"{key} {before.get(key)}, not {value}" for key, value in asked.items() if before.get(key) != value]
    if differs:
        raise SimError(f"{run.work} belongs to a run with {'; '.join(differs)}; valid: the same settings, or another folder")


def _keep_settings(run: TrainingRun) -> None:
    """Write the settings into the work folder, unless they are there."""
    path = run.work / _SETTINGS
    if not path.exists():
        with replaced_file(path) as beside:
            beside.write_text(json.dumps(_deciding(run)) + "\n", encoding="utf-8")


def _deciding(run: TrainingRun) -> dict[str, Any]:
    """Return all settings that affect the result, except the teacher: a text tower that is finished is used as it is."""
    names = ("houses", "settling_houses", "tuning_houses", "epochs", "settling_steps", "seed", "batch", "wordings")
    own = {name: getattr(run, name) for name in names} | {"start": run.start and str(run.start)}
    return own | {"distillation": asdict(run.distillation), "text": {**TEXT_CFG, "embed_dim": EMBED_DIM}}


def _text_tower(run: TrainingRun, console: Console) -> TextTransformer:
    path = run.work / "text-tower.safetensors"
    if not path.exists():

        def report(progress: DistilProgress) -> None:
            console.print(f"text epoch {progress.epoch}: cosine to the teacher {progress.cosine:.3f}")

        save_text_tower(distil(load_teacher(run.teacher), run.distillation, report), path)
    return load_text_tower(path)


def _frames(run: TrainingRun, console: Console, name: str, houses: int, seeds: range) -> Frames:
    """Render, or load, the frames of `houses` houses that are drawn with the seed of the run."""
    return Frames.joined(list(_rendered(run, console, name, _draws(run, houses, seeds))))


def _draws(run: TrainingRun, houses: int, seeds: range) -> list[HouseDraw]:
    stream = (TRAINING_SEEDS, TUNING_SEEDS).index(seeds)
    return list(draw_houses(houses, seeds, np.random.default_rng([run.seed, stream])))


def _rendered(run: TrainingRun, console: Console, name: str, draws: Sequence[HouseDraw]) -> Iterator[Frames]:
    """Yield the frames of each house, which are rendered or loaded, and report the progress."""
    for count, frames in enumerate(rendered(draws, run.work / "frames", run.workers), 1):
        if count % 20 == 0 or count == len(draws):
            console.print(f"{name} frames of {count} of {len(draws)} houses")
        yield frames


def _furnished(frames: Frames) -> Frames:
    """Leave out the frames that show almost nothing but bare walls."""
    return frames[frames.content >= BARE]
