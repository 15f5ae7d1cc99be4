"""Benchmarks behind `lexis-sim bench`: each module prints one table of figures over several houses.

`speed` (with `memory`, `overlap` and `plain`) measures time; `segmentation` measures the whole chain, `planning` driven
plans, `queries` the `everyday_questions`, `fidelity` the agreement of the feature sensor with renders, and the subpackage
`encoders` the vision-language models. `houses` chooses the houses of a benchmark.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
