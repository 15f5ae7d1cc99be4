"""LEXIS beside other methods, on the same walks.

`room_methods` compares methods by which LEXIS finds labels and rooms. `difficulty_sweep` compares the rooms found by LEXIS
and by the baselines while houses are opened, or while the runs become more difficult in another way. `trajectories` compares
the trajectories that LEXIS estimates with different methods of place recognition. `labels` compares room labels with
those of Hydra-like rooms, and `side_by_side` gives the observations of one walk to several systems.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
