"""LEXIS beside other methods, on the same walks.

`room_methods` compares methods for labels and rooms, and `openness_sweep` LEXIS with the baselines for rooms while inner
walls are opened. `trajectories` compares the trajectories that follow from methods of place recognition.

`place_methods` compares the methods of place recognition themselves, on the walks of `place_walks`. `place_figures` judges
their answers, `place_picture` draws them, and `place_tuning` tunes the settings of the methods.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
