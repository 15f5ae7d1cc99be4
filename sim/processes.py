"""`process_pool`: worker processes that do not compete for processor cores; `usable_cores`: how many there are for them."""

import multiprocessing
import os
import signal
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from multiprocessing.context import SpawnContext, SpawnProcess
from threading import Thread
from types import TracebackType
from typing import Any

from threadpoolctl import threadpool_limits

from lexis.__main__ import INTERRUPTED, locate_crashes

ONE_THREAD = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "OMP_WAIT_POLICY": "PASSIVE", "GOMP_SPINCOUNT": "0"}


def process_pool(
    workers: int, start: Callable[..., Any] | None = None, arguments: tuple[Any, ...] = ()
) -> ProcessPoolExecutor:
    """Return a pool of new processes. In each process, BLAS and OpenMP use one thread, so that every process needs one core.

    Each process calls `start(*arguments)` first. `start` and `arguments` have to be picklable. The processes end with this
    process, even if it is killed. A `with` block that ends early, by an exception for example, drops the calls that wait.
    Processes that are still starting print no traceback when Ctrl-C ends them.
    """
    return _Pool(workers, _Context(), initializer=_begin, initargs=(start, arguments))


def usable_cores() -> int:
    """Return the number of processor cores that this process may use, which may be fewer than the machine has."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


class _Worker(SpawnProcess):
    """A process that ends without a traceback if Ctrl-C comes while it is starting, or while it waits for a call."""

    def start(self) -> None:
        """Start the process with Ctrl-C blocked, because Python would print a traceback before `run` is called."""
        before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
        try:
            super().start()
        finally:
            try:
                signal.pthread_sigmask(signal.SIG_SETMASK, before)
            except KeyboardInterrupt:  # the pool does not know this process yet, and would never end it
                self.terminate()
                raise

    def run(self) -> None:
        """Handle the calls of the pool."""
        try:
            signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
            super().run()
        except KeyboardInterrupt:
            os._exit(INTERRUPTED)


class _Context(SpawnContext):
    """Starts new processes, because a forked torch or OpenCV may hang."""

    Process = _Worker


class _Pool(ProcessPoolExecutor):
    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.shutdown(cancel_futures=kind is not None)


def _begin(start: Callable[..., Any] | None, arguments: tuple[Any, ...]) -> None:
    locate_crashes()
    Thread(target=_end_with_parent, daemon=True).start()
    os.environ.update(ONE_THREAD)  # for libraries that are not loaded yet
    threadpool_limits(1)  # for libraries that are loaded already
    try:
        if start is not None:
            start(*arguments)
    except KeyboardInterrupt:  # of which the pool would print a traceback
        os._exit(INTERRUPTED)


def _end_with_parent() -> None:
    """Wait until the parent process ends, then end this process, which would otherwise wait for work for ever."""
    if (parent := multiprocessing.parent_process()) is not None:
        parent.join()
        os._exit(1)
