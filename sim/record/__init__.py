"""Runs as datasets that other programs read: EuRoC ASL, TUM RGB-D, ROS 2 bags. The truth lies beside, in files of its own.

`lexis run` makes the same map of a recording as LEXIS makes in the live run.
"""

from sim.record.record import FORMATS, record

__all__ = ["FORMATS", "record"]
