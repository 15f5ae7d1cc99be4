"""How much memory a whole run takes, in a process of its own: `python -m sim.bench.memory SEED` prints bytes."""

import subprocess
import sys
from pathlib import Path

from sim.errors import SimError


def measure_memory(seed: int) -> int:
    """Peak resident memory of a rendered run with LEXIS, less what torch and the encoder's library take alone [bytes]."""
    command = [sys.executable, "-m", "sim.bench.memory", str(seed)]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        raise SimError(f"a run to measure its memory failed: {done.stderr.strip().splitlines()[-1]}")
    return int(done.stdout.split()[-1])


def peak_memory() -> int:
    """Most that was ever resident of this program [bytes].

    Not `ru_maxrss`, which begins with what was resident of the process that started this one.
    """
    line = next(line for line in Path("/proc/self/status").read_text().splitlines() if line.startswith("VmHWM:"))
    return int(line.split()[1]) * 1024


def _run(seed: int) -> int:
    import open_clip  # noqa: F401 - torch and what comes with it, which do not count

    torch_alone = peak_memory()
    from sim.harness import RunConfig, run

    run(RunConfig(preset="home", seed=seed))
    return peak_memory() - torch_alone


if __name__ == "__main__":
    print(_run(int(sys.argv[1])))
