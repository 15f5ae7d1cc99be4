"""How much memory a whole run takes, in a process of its own: `python -m sim.bench.memory SEED` prints bytes."""

import resource
import subprocess
import sys

from sim.errors import SimError

_KIB_PER_UNIT = 1024 if sys.platform == "linux" else 1
"""Of `ru_maxrss`."""


def measure_memory(seed: int) -> int:
    """Peak resident memory of a rendered run with LEXIS, less what torch and the encoder's library take alone [bytes]."""
    command = [sys.executable, "-m", "sim.bench.memory", str(seed)]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        raise SimError(f"a run to measure its memory failed: {done.stderr.strip().splitlines()[-1]}")
    return int(done.stdout.split()[-1])


def _peak() -> int:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * _KIB_PER_UNIT


def _run(seed: int) -> int:
    import open_clip  # noqa: F401 - torch and what comes with it, which do not count

    torch_alone = _peak()
    from sim.harness import RunConfig, run

    run(RunConfig(preset="home", seed=seed))
    return _peak() - torch_alone


if __name__ == "__main__":
    print(_run(int(sys.argv[1])))
