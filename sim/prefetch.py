"""`prefetched`: items made by a thread of their own, some before they are asked for.

The thread ends by itself: after the last item, when nobody wants more, or with the main thread. Nobody ever waits for it.
That matters where an iterator is garbage: it is then closed by whichever thread collects, at any moment, perhaps while that
thread holds a lock, perhaps the thread that makes the items. So all that closing does is to leave word, in a queue that may
be entered at such a moment; an executor, whose workers are dismissed when it is collected, would never answer.
"""

import threading
from collections.abc import Callable, Generator
from contextlib import closing
from dataclasses import dataclass
from queue import Empty, SimpleQueue
from typing import Generic, TypeVar

T = TypeVar("T")

THREAD = "prefetched"
"""Name of the threads."""
_POLL_S = 0.25
"""How often a thread that waits looks whether the main thread still lives [s]."""


def prefetched(make: Callable[[], Generator[T, None, None]], depth: int) -> Generator[T, None, None]:
    """What `make` yields, up to `depth` items ahead. That generator runs, and is closed, in one thread of its own.

    Raises what it raises. Close it where it may be left early, for the thread goes on until then.
    """
    order = _Order[T](depth)
    threading.Thread(target=_work, args=(make, order), name=THREAD).start()
    try:
        while not isinstance(made := order.made.get(), _Ended):
            yield made.item
            order.places.put(None)
        if made.error is not None:
            raise made.error
    finally:
        order.wanted = False
        order.places.put(None)


@dataclass(frozen=True, eq=False)
class _Made(Generic[T]):
    item: T


@dataclass(frozen=True, eq=False)
class _Ended:
    error: BaseException | None


class _Order(Generic[T]):
    """What the two threads share."""

    def __init__(self, depth: int) -> None:
        self.made: SimpleQueue[_Made[T] | _Ended] = SimpleQueue()
        self.places: SimpleQueue[None] = SimpleQueue()
        """One entry for every further item that may be made."""
        self.wanted = True
        for _ in range(depth - 1):
            self.places.put(None)


def _work(make: Callable[[], Generator[T, None, None]], order: _Order[T]) -> None:
    error = None
    try:
        with closing(make()) as items:
            for item in items:
                order.made.put(_Made(item))
                _wait_for_place(order)
                if not order.wanted:
                    break
    except BaseException as raised:
        error = raised
    order.made.put(_Ended(error))


def _wait_for_place(order: _Order[T]) -> None:
    while threading.main_thread().is_alive():
        try:
            return order.places.get(timeout=_POLL_S)
        except Empty:
            continue
    raise RuntimeError("the main thread has ended")
