"""A finished map: its folder on disk, pictures, summaries, directions for people, and other room names.

`folder` saves and loads a map (`arrays` converts it to arrays, `other_views` what the further cameras of a rig saw). `info`
summarises a map, `picture` draws it, and `export` writes it for other programs. `path_directions` describes a plan in words,
`relabelling` assigns other room names without encoding an image again, and `encoder_check` checks that an encoder is the one
that made a map. The subpackage `interchange` reads and writes scene graphs, and writes occupancy grids and boxes of rooms.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
