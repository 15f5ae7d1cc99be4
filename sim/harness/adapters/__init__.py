"""SLAM systems that the harness knows: LEXIS, and plain ones to compare with.

`lexis` is the adapter of LEXIS.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
