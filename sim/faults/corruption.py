"""Applies the faults of a run in the order given, each with a random generator of its own."""

from collections.abc import Sequence

import numpy as np

from sim.faults.fault import Fault, StreamFault
from sim.random_streams import RandomStream, random_generator
from sim.truth import Stream


def fault_rng(seed: int, place: int) -> np.random.Generator:
    """Return the random generator of the fault at position `place` among all faults of a run with this seed."""
    return random_generator(seed, RandomStream.FAULTS, place)


def corrupted(stream: Stream, faults: Sequence[Fault], seed: int) -> Stream:
    """Return the stream of observations after all faults of the stream, in their order.

    Faults of the world are skipped. They still count in the positions of the faults, on which the random numbers depend.
    """
    for place, fault in enumerate(faults):
        if isinstance(fault, StreamFault):
            stream = fault.apply(stream, fault_rng(seed, place))
    return stream
