"""Time stamps of recordings: when a recording begins, and how long the body rests before the walk."""

from sim.errors import SimError

EPOCH_NS = 1_000_000_010 * 10**9
"""Stamp of the first frame [ns], a time in 2001. Tools that split stamps into s and ns expect stamps of 19 digits, also of
the IMU data that are earlier."""
REST_S = 2.0
"""Duration of the rest at the start [s]."""
DAY_S = 86_400
MAX_DAY = 10_000
"""Latest day of a recording. On later days, the seconds of stamps would soon need more than 31 bits."""
_END_NS = 2**31 * 10**9
"""The first stamp that is too late for ROS, whose messages hold 31 bits of seconds [ns]."""


def stamp_ns(seconds: float, day: int = 0) -> int:
    """Convert a time since the start of the walk [s] to a stamp [ns] on the given day.

    Raises `SimError` for a stamp before 1970 or beyond 31 bits of seconds, which a fault of the clock may cause.
    """
    stamp = EPOCH_NS + day * DAY_S * 10**9 + round((seconds + REST_S) * 1e9)
    if not 0 <= stamp < _END_NS:
        raise SimError(
            f"recording: a frame has the stamp {stamp / 1e9:.1f} s, which not every format holds; "
            f"valid: from 0 to below {_END_NS // 10**9} s, with a smaller fault of the clock"
        )
    return stamp
