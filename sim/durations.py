"""Durations as users write them: 90s, 3m or 1h. This module loads nothing heavy, since pytest loads it at every start."""

import argparse
import re

_UNITS_S = {"": 1.0, "s": 1.0, "m": 60.0, "h": 3600.0}
_LONGEST_S = 1e7


def duration_s(text: str) -> float:
    """Convert a text such as 90s, 3m or 1h to seconds, as a `type=` of argparse. A number without a unit is in seconds."""
    match = re.fullmatch(r"(\d+(?:\.\d+)?|\.\d+)([smh]?)", text, re.ASCII)
    seconds = float(match[1]) * _UNITS_S[match[2]] if match else 0.0
    if not 0.0 < seconds < _LONGEST_S:
        raise argparse.ArgumentTypeError(f"{text!r:.60}; valid: a time such as 90s, 3m or 1h")
    return seconds
