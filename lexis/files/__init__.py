"""Files: read with care where they come from outside, and written whole or not at all.

`reading` and `arrays` read files that nobody vouches for; `replace` (with `swap` and `temporary_folder`) writes a file or
folder beside its place and renames it; `tum_trajectory` and `camera` are two small formats.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
