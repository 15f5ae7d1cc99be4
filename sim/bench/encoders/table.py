"""Accuracy on each preset and inference time of every encoder, as in Table I of the LEXIS paper: rows, CSV file and plot."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np

from sim.bench.encoders.times import Timing
from sim.bench.row_files import mean_and_std, picture, write_records

TRAINED, RANDOM = "trained", "random"
_TICKS_MS = tuple(digit * 10.0**power for power in range(-1, 5) for digit in (1, 2, 5))


@dataclass(frozen=True)
class Accuracy:
    """Label accuracy of one encoder on the runs of one preset."""

    runs: tuple[float, ...]
    """Share of keyframes with the right label, for every run."""

    @property
    def mean(self) -> float:
        """Mean label accuracy over the runs."""
        return float(np.mean(self.runs))

    @property
    def std(self) -> float | None:
        """Standard deviation of the label accuracy over the runs; None for a single run."""
        return mean_and_std(self.runs)[1]


@dataclass(frozen=True, eq=False)
class TableRow:
    """The row of one encoder in the table: accuracy by preset, and times."""

    encoder: str
    weights: str
    """`TRAINED` or `RANDOM`. An encoder with random weights has times but no accuracy."""
    accuracy: Mapping[str, Accuracy]
    """Label accuracy by the preset of the houses."""
    times: Mapping[str, Timing | str]
    """Times by the name in `sim.bench.encoders.times.WAYS`, or the reason why they could not be measured."""

    @property
    def cpu(self) -> Timing | None:
        """Times of the encoder on one core with default options; None if they could not be measured."""
        found = self.times.get("cpu")
        return found if isinstance(found, Timing) else None


def write_csv(rows: Sequence[TableRow], path: Path) -> None:
    """Write one line for each encoder. Figures that an encoder does not have are left empty."""
    write_records([_record(row) for row in rows], path)


def draw_plot(rows: Sequence[TableRow], path: Path) -> None:
    """Plot mean label accuracy on each preset against the time for one image on one core (logarithmic axis), as PNG or SVG.

    Encoders with random weights have no accuracy, so they appear only as ticks on the time axis. Raises `SimError` if
    matplotlib is not installed.
    """
    with picture(path, (7.0, 4.5)) as figure:
        axes = figure.add_subplot()
        presets = list(dict.fromkeys(preset for row in rows for preset in row.accuracy))
        for number, preset in enumerate(presets):
            points = [(row.cpu.image_ms, row.accuracy[preset]) for row in rows if row.cpu and preset in row.accuracy]
            ms, found = [time for time, _ in points], [accuracy for _, accuracy in points]
            spread = np.array([accuracy.std for accuracy in found], float)  # None becomes NaN
            means = [accuracy.mean for accuracy in found]
            shift = 1.0 + 0.04 * (number - (len(presets) - 1) / 2)  # so that the presets' bars stand side by side
            axes.errorbar([time * shift for time in ms], means, spread, fmt="o", capsize=3, label=preset)
        for row in rows:
            _mark(axes, row)
        axes.set(xscale="log", ylim=(0.0, 1.0), xlabel="one image on one core [ms]", ylabel="keyframes labelled rightly")
        axes.set_title("accuracy before refinement (mean ± std over runs) and inference time")
        _label_times(axes, [row.cpu.image_ms for row in rows if row.cpu])
        axes.grid(which="both", alpha=0.25)
        if presets:
            axes.legend(loc="lower left")


def _mark(axes: Any, row: TableRow) -> None:
    """Write the encoder's name into the plot, at its time; with random weights, also draw a tick on the time axis."""
    if row.cpu is None:
        return
    if row.weights == RANDOM:
        axes.axvline(row.cpu.image_ms, ymax=0.04, color="0.4")
        label, height = f"{row.encoder} (random weights)", 0.05
    else:
        label, height = row.encoder, max((accuracy.mean for accuracy in row.accuracy.values()), default=0.0) + 0.06
    upright = row.weights == RANDOM
    axes.annotate(
        label, (row.cpu.image_ms, height), ha="center", va="bottom", rotation=90 if upright else 0, color="0.3", fontsize=8
    )


def _label_times(axes: Any, times_ms: Sequence[float]) -> None:
    """Label the time axis with plain numbers instead of powers of ten."""
    if times_ms:
        low, high = min(times_ms) / 1.5, max(times_ms) * 1.5
        axes.set_xticks([tick for tick in _TICKS_MS if low <= tick <= high])
        axes.set_xlim(low, high)
    axes.xaxis.set_major_formatter("{x:g}")
    axes.minorticks_off()


def _record(row: TableRow) -> dict[str, object]:
    record: dict[str, object] = {"encoder": row.encoder, "weights": row.weights}
    for preset, accuracy in row.accuracy.items():
        record[f"{preset} accuracy mean"] = f"{accuracy.mean:.4f}"
        record[f"{preset} accuracy std"] = "" if accuracy.std is None else f"{accuracy.std:.4f}"
        record[f"{preset} runs"] = len(accuracy.runs)
    for way, found in row.times.items():
        for field in fields(Timing):
            record[f"{way} {field.name}"] = f"{getattr(found, field.name):.3f}" if isinstance(found, Timing) else ""
    return record
