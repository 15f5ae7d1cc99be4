"""Other methods that LEXIS is compared with.

`orb_words` is place recognition by ORB and a bag of visual words, and `orb_vocabulary` learns the visual words. The
subpackage `rooms` finds rooms in the true map of a house, and holds reduced variants of LEXIS. The subpackage `places` holds
methods of place recognition.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
