"""Options that several benchmarks share, and the way in which all of them print their tables."""

import argparse
import math
import sys
from collections.abc import Callable, Iterator
from dataclasses import astuple
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

from rich.console import Console
from rich.table import Table

from lexis.command_line import ENCODER_HELP, Command, positive
from sim.commands.arguments import (
    CONFIG_HELP,
    FEATURE_MODEL_HELP,
    FIDELITY_HELP,
    PRESET_HELP,
    EachOnce,
    argument,
    number,
    seeing_encoder,
)
from sim.commands.console import standard_output
from sim.fidelity import FIDELITIES
from sim.report.figures import shown
from worlds.presets import PRESETS

if TYPE_CHECKING:
    from sim.bench.stage_costs import StageGain

Tables: TypeAlias = Callable[[argparse.Namespace], Iterator[Table]]

PRESET = argument("--preset", choices=PRESETS, default="home", metavar="NAME", help=PRESET_HELP)
SEVERAL_PRESETS = argument(
    "--presets", nargs="+", action=EachOnce, choices=PRESETS, default=["home"], metavar="NAME", help=PRESET_HELP
)
FIDELITY = argument("--fidelity", choices=FIDELITIES, default="features", help=FIDELITY_HELP)
RATE = argument(
    "--rate", type=number(2.0, 120.0), metavar="HZ", help="frames per second (default: the usual number of the fidelity)"
)
OPENNESS = argument(
    "--openness",
    type=float,
    metavar="X",
    help="open or close inner walls of every house to X in [0, 1] (default: as sampled)",
)
HOUSES = argument("--houses", type=positive, default=5, help="number of houses, from --seed upwards (default: %(default)s)")
ENCODER = argument("--encoder", type=seeing_encoder, default="mini", metavar="MODEL", help=ENCODER_HELP)
CONFIG = argument("--config", type=Path, metavar="FILE", help=CONFIG_HELP)
CSV = argument("--csv", type=Path, metavar="FILE", help="write the table to this file")
PLOT = argument("--plot", type=Path, metavar="FILE", help="draw the figures in this file, .png or .svg")
FILES = argument("--out", nargs="+", type=Path, default=[], metavar="FILE", help="write .csv, .png or .svg files")
FEATURE_MODEL = argument("--feature-model", type=Path, metavar="FILE", help=FEATURE_MODEL_HELP)


def seeds_of(arguments: argparse.Namespace) -> range:
    """Return the seeds of the houses that `--seed` and `--houses` ask for."""
    return range(arguments.seed, arguments.seed + arguments.houses)


def mean_std_text(mean: float | None, std: float | None, form: str) -> str:
    """Return the text of a mean and its standard deviation, each in the format `form`; None becomes a dash.

    Without a mean, the text is a single dash.
    """
    return shown(mean, form) if mean is None else f"{shown(mean, form)} ± {shown(std, form)}"


def known(value: float) -> float | None:
    """Return a figure, or None for NaN, so that `shown` gives a dash for it."""
    return None if math.isnan(value) else value


def gain_texts(name: str, gain: "StageGain") -> Iterator[str]:
    """Yield the texts of a gain in each figure, with a sign unless `name` says that nothing was replaced.

    A figure that no house has becomes a dash, and so does the standard error of a single house.
    """
    from sim.bench.stage_costs import UNCHANGED

    sign = "" if name == UNCHANGED else "+"
    for mean, error in zip(astuple(gain.mean), astuple(gain.error), strict=True):
        text = shown(known(mean), f"{{:{sign}.3f}}")
        yield text if math.isnan(mean) else f"{text} ± {shown(known(error), '{:.3f}')}"


def printing(tables: Tables) -> Command:
    """Make a command that prints every table as soon as it is complete."""

    def command(arguments: argparse.Namespace) -> int:
        out = console()
        for table in tables(arguments):
            out.print(table)
        return 0

    return command


def console() -> Console:
    """Return standard output as a console. It is 250 columns wide if it is no terminal; rich would cut figures off at 80."""
    return standard_output(None if sys.stdout.isatty() else 250)
