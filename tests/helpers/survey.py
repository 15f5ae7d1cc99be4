"""Tries many bad inputs in a child process with limits on time and memory."""

import contextlib
import multiprocessing
import os
import resource
import shutil
import signal
import time
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

MEMORY_BYTES = 1_000_000_000
PROCESSOR_S, WALL_S = 5.0, 60.0
"""Longest time that one input may take: processor time, and wall-clock time on a busy machine [s]."""


@dataclass
class Survey:
    """The combined outcome of all inputs."""

    tried: int = 0
    refused: int = 0
    longest_s: float = 0.0
    """Longest processor time that one input took [s]."""
    peak_bytes: int = 0
    """Largest amount of memory beyond that in use before [bytes]."""
    foreign: Counter = field(default_factory=Counter)
    """Number of unexpected exceptions by class, and of processes that had to be ended."""
    examples: list = field(default_factory=list)

    def __str__(self):
        return (
            f"{self.tried} tried, {self.refused} refused, foreign {dict(self.foreign)}, longest {self.longest_s:.2f} s, "
            f"peak {self.peak_bytes / 1e6:.0f} MB"
        )


def survey(attempt, cases, seed, expected, folder):
    """Call `attempt(rng, folder)` once for each of `cases` inputs; it may raise `expected` and nothing else."""
    found, context, start = Survey(), multiprocessing.get_context("fork"), 0
    while start < cases:
        receiver, sender = context.Pipe(duplex=False)
        child = context.Process(target=_work, args=(attempt, range(start, cases), seed, expected, Path(folder), sender))
        child.start()
        sender.close()
        last = start - 1
        with contextlib.suppress(EOFError):
            while True:
                last, kind, said, seconds, peak = receiver.recv()
                found.tried += 1
                found.refused += kind == "refused"
                found.longest_s, found.peak_bytes = max(found.longest_s, seconds), max(found.peak_bytes, peak)
                if kind == "foreign":
                    _note(found, last, said)
        child.join()
        start = last + 1
        if start < cases:  # the child process ended before all of its cases
            _note(found, start, f"ended by {signal.Signals(-child.exitcode).name if child.exitcode < 0 else child.exitcode}")
            found.tried += 1
            start += 1
    return found


def _note(found, case, said):
    found.foreign[said.split(":")[0]] += 1
    found.examples.append(f"case {case}: {said}")


def _work(attempt, cases, seed, expected, folder, sender):
    size = int(Path("/proc/self/statm").read_text(encoding="utf-8").split()[0]) * os.sysconf("SC_PAGE_SIZE")
    resource.setrlimit(resource.RLIMIT_AS, (size + MEMORY_BYTES, resource.RLIM_INFINITY))
    resource.setrlimit(resource.RLIMIT_FSIZE, (100_000_000_000, resource.RLIM_INFINITY))
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    for case in cases:
        place = folder / f"case{case}"
        place.mkdir()
        # The default action of these signals ends the process, so that no handler can swallow them.
        signal.setitimer(signal.ITIMER_PROF, PROCESSOR_S)
        signal.setitimer(signal.ITIMER_REAL, WALL_S)
        start = time.process_time()
        kind, said = "accepted", ""
        try:
            attempt(np.random.default_rng((seed, case)), place)
        except expected:
            kind = "refused"
        except Exception as error:
            kind, said = "foreign", f"{type(error).__name__}: {str(error)[:150]} ({_where(error)})"
        seconds = time.process_time() - start
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.setitimer(signal.ITIMER_REAL, 0)
        shutil.rmtree(place, ignore_errors=True)
        peak = (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) * 1024
        sender.send((case, kind, said, seconds, peak))


def _where(error):
    trace = error.__traceback__
    frames = []
    while trace is not None:
        frames.append(f"{Path(trace.tb_frame.f_code.co_filename).name}:{trace.tb_lineno}")
        trace = trace.tb_next
    return " ".join(frames[-4:])
