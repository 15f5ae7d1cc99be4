"""Arguments that several commands take."""

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeAlias

from lexis.command_line import seed
from worlds.presets import PRESETS

Argument: TypeAlias = Callable[[argparse.ArgumentParser], object]
"""Adds itself to a parser."""

ENCODER_HELP = "mini, MODEL[:PRETRAINED] or MODEL:PATH of open_clip (default: %(default)s)"
PRESET_HELP = f"family of houses: {', '.join(PRESETS)} (default: %(default)s)"


def argument(*names: str, **options: Any) -> Argument:
    """An argument by what `add_argument` takes, for tables of commands."""
    return lambda parser: parser.add_argument(*names, **options)


def folder(text: str) -> Path:
    """The name of a folder to write, for `type=`; whether it can be written is not looked at."""
    if not text.strip():
        raise argparse.ArgumentTypeError("is blank; valid: the name of a folder")
    try:
        Path(text).resolve()
    except (OSError, RuntimeError) as error:  # a RuntimeError is a loop of symbolic links
        raise argparse.ArgumentTypeError(f"{text}: {error}; valid: the name of a folder") from None
    return Path(text)


def out_file(metavar: str) -> Argument:
    """The file that a command writes."""
    return argument("-o", "--out", type=Path, required=True, metavar=metavar)


SEED = argument("--seed", type=seed, default=0, help="default: %(default)s")
