"""LEXIS beside other methods, on the same walks.

`room_methods` compares methods for labels and rooms, and `openness_sweep` LEXIS with the baselines for rooms while inner
walls are opened. `trajectories` compares the trajectories that follow from methods of place recognition,
and `labels` the room labels. `side_by_side` gives the observations of one walk to several systems.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
