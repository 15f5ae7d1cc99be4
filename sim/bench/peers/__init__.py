"""LEXIS beside other methods, on the same walks.

`room_methods` compares methods by which LEXIS finds labels and rooms, `responses` compares settings of LEXIS, `certainty`
compares the probabilities that it states for labels with the truth, and `labels` compares its labels with those of Hydra-
like rooms. `difficulty_sweep` compares the rooms found by LEXIS and by the baselines while houses are opened, or while the
runs become more difficult in another way. `trajectories` compares the trajectories that LEXIS estimates with different
methods of place recognition. `side_by_side` gives the observations of one walk to several systems.

`own_methods` puts segmentations and methods of place recognition of the user's own beside the others.

`place_methods` compares methods of place recognition on the walks of `place_walks`. `place_figures` judges their answers,
`place_picture` draws them, and `place_tuning` tunes the settings of the methods.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
