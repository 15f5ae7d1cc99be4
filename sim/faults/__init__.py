"""What breaks: faults of sensors, clocks, odometry and of the world, seeded, composable, recorded in the truth.

Faults of the world change the stage in the order given; then faults of the stream change what comes from it in the order
given, each fed by the one before: a frame that is dropped first cannot be late. Every fault draws from a stream of its own,
by its place in the order, so that no other draw moves.
"""

from collections.abc import Sequence

import numpy as np

from sim.faults.catalogue import FAULTS, parse_fault, written
from sim.faults.fault import Fault, StreamFault
from sim.faults.world import WorldFault, WorldState
from sim.truth import Stream

__all__ = ["FAULTS", "Fault", "StreamFault", "WorldFault", "WorldState", "corrupted", "fault_rng", "parse_fault", "written"]

_STREAM = 2
"""Of faults among the streams that a run's seed spawns; 0 is the tour's, 1 the odometry's."""


def fault_rng(seed: int, place: int) -> np.random.Generator:
    """The stream of the fault at some place of a run's faults."""
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(_STREAM, place)))


def corrupted(stream: Stream, faults: Sequence[Fault], seed: int) -> Stream:
    """A stream with all of the faults that are faults of the stream; the others count for their place only."""
    for place, fault in enumerate(faults):
        if isinstance(fault, StreamFault):
            stream = fault.apply(stream, fault_rng(seed, place))
    return stream
