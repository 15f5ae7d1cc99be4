"""Peak memory of a whole run, measured in a separate process: `python -m sim.bench.memory SEED` prints bytes."""

import subprocess
import sys
from pathlib import Path

from sim.errors import SimError


def measure_memory(seed: int) -> int:
    """Return the peak resident memory of a rendered run with LEXIS, less that for importing torch and open_clip [bytes].

    Raises `SimError` if the run fails.
    """
    command = [sys.executable, "-m", "sim.bench.memory", str(seed)]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        said = done.stderr.strip().splitlines() or [f"exit status {done.returncode}"]
        raise SimError(f"a run to measure its memory failed: {said[-1]}")
    return int(done.stdout.split()[-1])


def peak_memory() -> int:
    """Return the peak resident memory of this process so far [bytes].

    `ru_maxrss` cannot be used, because its initial value is the resident memory of the parent process.
    """
    line = next(
        line for line in Path("/proc/self/status").read_text(encoding="utf-8").splitlines() if line.startswith("VmHWM:")
    )
    return int(line.split()[1]) * 1024


def _run(seed: int) -> int:
    import open_clip  # noqa: F401 - loads torch and its dependencies, whose memory is subtracted

    torch_alone = peak_memory()
    from sim.harness import Scenario, run

    run(Scenario(preset="home", seed=seed))
    return peak_memory() - torch_alone


if __name__ == "__main__":
    print(_run(int(sys.argv[1])))
