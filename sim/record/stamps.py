"""Time stamps of recordings: when a recording begins, and how long the body rests before the walk."""

EPOCH_NS = 1_000_000_010 * 10**9
"""Stamp of the first frame [ns], a time in 2001. Tools that split stamps into s and ns expect stamps of 19 digits, also of
the IMU data that are earlier."""
REST_S = 2.0
"""Duration of the rest at the start [s]."""
DAY_S = 86_400
MAX_DAY = 10_000
"""Latest day of a recording. On later days, the seconds of stamps would soon need more than 31 bits."""


def stamp_ns(seconds: float, day: int = 0) -> int:
    """Convert a time since the start of the walk [s] to a stamp [ns] on the given day."""
    return EPOCH_NS + day * DAY_S * 10**9 + round((seconds + REST_S) * 1e9)
