"""The random streams of a run: what draws from one of them leaves the draws of all others as they are."""

from enum import IntEnum

import numpy as np


class RandomStream(IntEnum):
    """Numbers of the random streams that a run derives from its seed."""

    TOUR = 0
    ODOMETRY = 1
    FAULTS = 2
    DRIVES = 3
    PERCEPTS = 4
    ODOMETRY_FRAME = 5


def random_generator(seed: int, stream: RandomStream, *numbers: int) -> np.random.Generator:
    """Return a new generator of a stream, for a run with this seed.

    `numbers` tell apart several generators of one stream, such as those of the drives of a run.
    """
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(stream, *numbers)))
