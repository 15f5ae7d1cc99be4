"""A finished map: its folder on disk, pictures, summaries, directions for people, and other room names.

`folder` saves and loads a map (`arrays` converts it to arrays). `info` summarises it, `picture` and `export` show it
to other programs, `path_directions` describes a plan in words, `relabelling` assigns other room names without encoding an
image again, and `encoder_check` compares encoders by their weights. The subpackage `interchange` holds the formats of
scene graphs and robots' maps.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
