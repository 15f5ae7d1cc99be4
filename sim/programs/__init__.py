"""Programs in any language as SLAM under test.

`command` records a scenario for a program, runs the program with limits of time and memory, and reads its claims, whose
files `program_files` describes.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
