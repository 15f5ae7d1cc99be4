"""Items are made in advance by one thread, which ends in every case, whatever happens to its consumers."""

import gc
import subprocess
import sys
import threading
from contextlib import closing

import pytest

from sim.prefetch import prefetched

GUARD_S = 20.0
"""Only a thread that hangs takes that long [s]."""


class Source:
    """Yields numbers and records which threads worked on them."""

    def __init__(self, count, error=None):
        self.count, self.error, self.made = count, error, 0
        self.worked, self.closed = set(), threading.Event()

    def __call__(self):
        try:
            for k in range(self.count):
                self.worked.add(threading.get_ident())
                self.made += 1
                yield k
            if self.error:
                raise self.error
        finally:
            self.worked.add(threading.get_ident())
            self.closed.set()


@pytest.mark.parametrize(("count", "depth"), [(0, 1), (1, 4), (50, 1), (50, 7)])
def test_all_items_in_order_made_and_closed_in_one_other_thread(count, depth):
    source = Source(count)
    assert list(prefetched(source, depth)) == list(range(count))
    assert source.closed.is_set() and len(source.worked) == 1 and threading.get_ident() not in source.worked


def test_no_more_than_depth_are_made_before_they_are_taken():
    source = Source(100)
    with closing(prefetched(source, 5)) as items:
        for k in items:
            assert source.made <= k + 5
    assert source.made == 100


def test_errors_come_after_the_items_before_them():
    items = prefetched(Source(3, ValueError("lost context")), 8)
    assert [next(items) for _ in range(3)] == [0, 1, 2]
    with pytest.raises(ValueError, match="lost context"):
        next(items)


def test_closing_early_closes_the_source_in_its_own_thread():
    source = Source(10**9)
    with closing(prefetched(source, 3)) as items:
        next(items)
    assert source.closed.wait(GUARD_S) and len(source.worked) == 1


def test_garbage_is_collected_without_waiting_whoever_collects():
    """Garbage may also be collected by the thread that makes the items, which could not wait for itself."""

    class Collecting(Source):
        def __call__(self):
            for k in super().__call__():
                gc.collect()
                yield k

    source = Collecting(10**9)
    gc.disable()
    try:
        cycle = [prefetched(source, 1000)]
        next(cycle[0])
        cycle.append(cycle)
        del cycle
        assert source.closed.wait(GUARD_S) and len(source.worked) == 1
    finally:
        gc.enable()


def test_the_interpreter_exits_over_iterators_that_nobody_closed():
    program = (
        "import itertools; from sim.prefetch import prefetched\n"
        "def make():\n"
        "    try: yield from itertools.count()\n"
        "    finally: print('closed')\n"
        "items = prefetched(make, 2); print(next(items))"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=GUARD_S)
    assert (done.returncode, done.stdout, done.stderr) == (0, "0\nclosed\n", "")
