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
    before = peak_memory()
    np.ones(200_000_000 // 8).sum()
    assert peak_memory() >= max(before, 200_000_000)
