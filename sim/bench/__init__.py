"""Benchmarks behind `lexis-sim bench`: each benchmark measures figures over several houses and prints a table.

`speed` (with `memory`, `overlap` and `plain`) measures times, and `throughput` measures houses per second. `segmentation`
measures the labels, rooms, loops and plans of whole runs. The subpackage `peers` compares LEXIS with other methods on the
same walks, and `places` compares LEXIS's own methods of place recognition. `scale` measures how time and memory grow along
one long walk. `odometry` measures maps with odometry that drifts and fails. `sessions` measures
whether a robot that returns to a house recognises where it is. `rigs` measures whether a robot that walks back along its
path recognises places from the opposite direction.

The subpackage `pose_graphs` measures the optimiser alone. `planning` compares drives along the same plans with different
pose estimates, and `answers` asks the `everyday_questions`. `fidelity` compares runs on simulated features with runs on
rendered images, and the subpackage `encoders` compares vision-language models. `houses` chooses the houses of a benchmark,
and `row_files` writes a benchmark's rows as a CSV file and as a picture. `collection` runs all benchmarks of the
`benchmark_list`. `stage_costs` measures what each stage of LEXIS costs.

Two benchmarks judge the harness itself. `shrinking` tests the reducer on the `failing_scenarios`, in which the SLAM has one
of the `planted_bugs`. The subpackage `mutation` plants bugs into LEXIS and counts how many bugs a suite finds.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
