"""Questions to a map in free words, such as "where can I wash my hands".

`captions` reduces a question to its content, `answers` compares the content with keyframes and rooms, and `calibration`
turns similarities into probabilities. `goals` finds the room that a description names, for plans.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
