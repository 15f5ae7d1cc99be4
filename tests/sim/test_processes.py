"""Worker processes use one thread each for linear algebra, whatever the settings of the parent process are."""

import os

from threadpoolctl import threadpool_info

from sim.processes import process_pool

started = []


def begin(word):
    started.append(word)


def threads():
    import numpy as np

    np.ones((4, 4)) @ np.ones((4, 4))
    return {library["num_threads"] for library in threadpool_info()}, os.environ["OMP_NUM_THREADS"], started


def test_workers_use_one_thread_and_call_the_given_function_first(monkeypatch):
    monkeypatch.setenv("OMP_NUM_THREADS", "3")
    monkeypatch.setenv("OPENBLAS_NUM_THREADS", "3")
    with process_pool(1, begin, ("ready",)) as pool:
        assert pool.submit(threads).result() == ({1}, "1", ["ready"])
