"""`estimated_frames`: the part of a SLAM's estimate that shows on a plan why a run is wrong."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Literal

import numpy as np
from jaxtyping import Int

from lexis.evaluation.trajectory import aligned
from lexis.maths.se3 import inverse
from lexis.types import Poses
from sim.harness.diagnosis.first_wrong import WITH_LABELS, WrongFrame, wrong_labels, wrong_numbers
from sim.harness.finished_run import Run
from sim.harness.results import group_of
from sim.report.data import NO_LABEL
from sim.report.frame_picture import FrameEstimates
from sim.report.palette import instance_colours, label_colours


def estimated_frames(run: Run, figure: str | None, wrong: WrongFrame) -> FrameEstimates:
    """Return the estimated path and what else the figure is about: the estimated rooms, floors or labels, or nothing.

    If `wrong` is a wrong motion, the estimated path is moved as a whole so that it agrees with the truth where this motion
    begins. Otherwise it is aligned with the true path as for the absolute trajectory error.
    """
    kind = group_of(figure)
    named = run.estimate.labels is not None and kind in WITH_LABELS
    estimates = FrameEstimates(run.estimate.frames, _in_world(run, wrong), names_labels=named)
    if kind == "rooms" and run.estimate.rooms is not None:
        names = {number: f"estimated {name}" for number, name in run.estimated_rooms.items()}
        return _numbered(run, estimates, "rooms", run.estimate.rooms, names, "in no estimated room")
    if kind == "floors" and run.estimate.floors is not None:
        names = {floor: f"estimated floor {floor}" for floor in sorted(set(run.estimate.floors.tolist())) if floor >= 0}
        return _numbered(run, estimates, "floors", run.estimate.floors, names, "estimated on no floor")
    return _labelled(run, estimates, figure) if kind in WITH_LABELS else estimates


def _in_world(run: Run, wrong: WrongFrame) -> Poses | None:
    if run.estimate.T_W_B is None:
        return None
    estimated, truth = np.asarray(run.estimate.T_W_B, np.float64), run.true_poses
    if wrong.since is None:
        return aligned(estimated, truth)
    row = int(np.searchsorted(run.estimate.frames, wrong.since))
    return np.asarray(truth[row] @ inverse(estimated[row]) @ estimated)


def _labelled(run: Run, estimates: FrameEstimates, figure: str | None) -> FrameEstimates:
    """Add the labels, unless none is wrong for the figure."""
    wrong = wrong_labels(run, figure)
    if run.estimate.labels is None or not wrong.any():
        return estimates
    names = (*run.room_names, NO_LABEL)  # index -1, for no label, is the last entry
    said = tuple(NO_LABEL if k < 0 else f"labelled {names[k]}" for k in run.estimate.labels.tolist())
    colours = {name if name == NO_LABEL else f"labelled {name}": colour for name, colour in label_colours(names).items()}
    return replace(estimates, groups=said, wrong=wrong, colours=colours)


def _numbered(
    run: Run,
    estimates: FrameEstimates,
    name: Literal["rooms", "floors"],
    numbers: Int[np.ndarray, "n"],
    names: Mapping[int, str],
    none: str,
) -> FrameEstimates:
    """Add estimates that are numbers from 0, each with its name in `names`, or -1 for `none`."""
    said = tuple(names.get(k, none) for k in numbers.tolist())
    colours = instance_colours([*names.values(), *([none] if none in said else [])], none)
    return replace(estimates, groups=said, wrong=wrong_numbers(run, name), colours=colours)
