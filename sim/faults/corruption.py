"""The faults of a run, applied in the order given, each with a random stream of its own."""

from collections.abc import Sequence

import numpy as np

from sim.faults.fault import Fault, StreamFault
from sim.truth import Stream

_STREAM = 2
"""Position of the faults among the random streams that the seed of a run spawns; 0 is the tour's, 1 the odometry's."""


def fault_rng(seed: int, place: int) -> np.random.Generator:
    """The random generator of the fault at position `place` among the faults of the run with this seed."""
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(_STREAM, place)))


def corrupted(stream: Stream, faults: Sequence[Fault], seed: int) -> Stream:
    """Apply the faults of the stream, in order. Faults of the world are skipped, but they take a position in the order."""
    for place, fault in enumerate(faults):
        if isinstance(fault, StreamFault):
            stream = fault.apply(stream, fault_rng(seed, place))
    return stream
