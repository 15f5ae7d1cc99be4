"""Faults of sensors, clocks, odometry and the world. Faults are seeded, can be combined, and are recorded in the truth.

`fault` is the base class. `catalogue` lists the faults and reads them from text such as "blur:0.5". Faults of the world
(`world`, `closing_doors`, `moved_furniture`, `person`) change the house, or add moving people and doors. Faults of the
stream (`images`, `poses`, `stamps`, `delivery`) change observations. `corruption` applies the faults of the stream in the
order given. Each fault receives the output of the fault before it, so a frame that was dropped cannot be late.

Every fault has a random generator of its own, which depends on the run's seed and on the fault's position among the faults.
A fault that is added at the end therefore does not change the random numbers of the other faults.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
