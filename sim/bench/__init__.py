"""Benchmarks behind `lexis-sim bench`: each benchmark measures figures over several houses and prints a table.

`speed` (with `memory`, `overlap` and `plain`) measures time, and `throughput` houses per second. `segmentation` measures the
labels, rooms, loops and plans of whole runs, `planning` compares plans that are driven with different pose estimates, and
`queries` asks the `everyday_questions`. `fidelity` compares the feature sensor with renders, and the subpackage `encoders`
compares vision-language models. The subpackage `mutation` grades the suites by planted bugs. `houses` chooses the houses of a benchmark. `shrinking` tests the reducer on the
`failing_scenarios`, in which the SLAM has one of the `planted_bugs`.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
