"""Safe reading of untrusted files, and atomic writing: a file or folder is written completely or not at all.

`reading` and `arrays` read untrusted files. `replace` (with `swap` and `temporary_folder`) writes a file or folder under a
temporary name in the same place and then renames it. `tum_trajectory` and `camera` read and write two small formats,
and `g2o` reads pose graphs. `models` holds what the models of several JSON files share.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
