from .answers import ask_houses as ask_houses
from .fidelity import compare_fidelities as compare_fidelities
from .planning import drive_houses as drive_houses
from .segmentation import run_houses as run_houses
from .shrinking import prove as prove
from .speed import measure_speed as measure_speed
from .throughput import measure_throughput as measure_throughput
