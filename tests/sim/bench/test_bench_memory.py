"""The reported memory is that of the measured program."""

import subprocess
import sys

import numpy as np

from sim.bench.memory import peak_memory

PRINT_PEAK = "from sim.bench.memory import peak_memory; print(peak_memory())"


def test_a_large_parent_does_not_count():
    held = np.ones(300_000_000 // 8)
    child = subprocess.run([sys.executable, "-c", PRINT_PEAK], capture_output=True, text=True, check=True)
    assert int(child.stdout) + held.nbytes / 2 < peak_memory()


def test_released_memory_counts_in_the_peak():
    """The memory is used in a child process, because this process may have used as much before."""
    before, after = (
        int(subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout)
        for code in (PRINT_PEAK, f"import numpy as np; np.ones(200_000_000 // 8).sum(); {PRINT_PEAK}")
    )
    assert after >= before + 190_000_000
