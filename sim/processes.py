"""`process_pool`: worker processes that do not compete with each other for processor cores."""

import multiprocessing
import os
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from threading import Thread
from types import TracebackType
from typing import Any

from threadpoolctl import threadpool_limits

ONE_THREAD = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "OMP_WAIT_POLICY": "PASSIVE", "GOMP_SPINCOUNT": "0"}


def process_pool(
    workers: int, start: Callable[..., Any] | None = None, arguments: tuple[Any, ...] = ()
) -> ProcessPoolExecutor:
    """Return a pool of new processes. In each process, BLAS and OpenMP use one thread, so that every process needs one core.

    Each process calls `start(*arguments)` first. `start` and `arguments` have to be picklable. The processes end with this
    process, even if it is killed. A `with` block that ends early, by an exception for example, drops the calls that wait.
    """
    context = multiprocessing.get_context("spawn")  # a forked torch or OpenCV may hang
    return _Pool(workers, context, initializer=_begin, initargs=(start, arguments))


class _Pool(ProcessPoolExecutor):
    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.shutdown(cancel_futures=kind is not None)


def _begin(start: Callable[..., Any] | None, arguments: tuple[Any, ...]) -> None:
    Thread(target=_end_with_parent, daemon=True).start()
    os.environ.update(ONE_THREAD)  # for libraries that are not loaded yet
    threadpool_limits(1)  # for libraries that are loaded already
    if start is not None:
        start(*arguments)


def _end_with_parent() -> None:
    """Wait until the parent process ends, then end this process, which would otherwise wait for work for ever."""
    if (parent := multiprocessing.parent_process()) is not None:
        parent.join()
        os._exit(1)
