"""Runs a program in any language as the SLAM under test.

`program` records a scenario for a program, runs the program in a `limited_process`, and reads the program's estimate.
`program_files` describes the files of the estimate, and `loop_file` the one with loop closures.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
