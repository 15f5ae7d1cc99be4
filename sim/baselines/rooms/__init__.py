"""Baselines that find rooms in the true map of a house, and reduced variants of LEXIS.

Read `map_rooms` first: it is the adapter by which the harness runs a segmentation of the true map. `true_map` rasterises the
walls of every storey. Four modules segment such a map: `morphological`, `distance_transform` and `voronoi` follow the survey
by Bormann et al. ("Room Segmentation: Survey, Implementation, and Analysis", ICRA 2016), and `hydra_places` follows Hydra
(Hughes et al., RSS 2022). They share the operations in `cells`. `object_votes` labels rooms by the objects in them, which
`object_scores` compares with room names. `lexis_variants` holds LEXIS without language and without some of its rules.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
