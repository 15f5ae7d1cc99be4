"""Small mathematical tools that several stages share.

`se3` and `quaternions` are about rigid motions, `projection` about the pinhole camera, `pnp` about its pose from matched
points, and `rig` about several cameras on one body. `paths` measures length along a path,
`stretches` cuts a sequence into stretches of equal values, `groups` groups items that are joined by pairs, `ties` compares
values so that rounding errors decide nothing, and `growing_array` holds an array that grows row by row.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
