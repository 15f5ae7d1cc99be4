"""Grades the harness by the bugs it finds: bugs are planted into LEXIS one at a time, and the suite `pr` looks for them.

A mutant is a small change of the text of one module of LEXIS. The mutants of each stage have a module of their own:
`keyframe_mutants`, `graph_mutants`, `place_mutants`, `image_mutants`, `label_mutants` and `room_mutants`. `mutants` lists
them all. `planting` makes a copy of LEXIS with one mutant in it, and `grading` lets the suite check the copy as a black
box.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
