"""Figures that compare a run with the truth: pure functions of arrays, without the simulator.

There is a module for each aspect of a run: `labels`, `rooms` (with `partitions`), `floors`, `loops` and `place_recognition`
(with `relative`), `trajectory`, `planning`, `coverage` of the walk by keyframes, and
`certainty`, for whether stated probabilities are calibrated.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
