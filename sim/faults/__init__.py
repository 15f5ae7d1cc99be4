"""Faults of sensors, clocks, odometry and the world: seeded, composable, and recorded in the truth.

`fault` is the base class. `catalogue` lists the faults and reads them from text such as "blur:0.5". Faults of the world
(`world`, `closing_doors`, `moved_furniture`, `person`) change what there is to see; faults of the stream (`images`,
`poses`, `stamps`, `delivery`) change observations. `corruption` applies the faults of a run in the order given: each
receives the output of the fault before it, so a frame that was dropped cannot be late. Every fault has a random stream of
its own, chosen by its position in that order, so that adding a fault leaves the draws of the others alone.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
