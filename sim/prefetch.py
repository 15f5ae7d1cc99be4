"""`prefetched`: runs a generator in a background thread, which produces some items before they are requested.

The thread ends by itself: after the last item, when the consumer closes its iterator, or when the main thread ends. No code
ever waits for the thread to end. The reason is garbage collection: an abandoned iterator is closed by whichever thread runs
the collector, at any moment. This other thread may hold a lock, and it may be the producing thread itself, so waiting could
deadlock. Closing therefore only sets a flag and puts an entry into a `SimpleQueue`, whose `put` is reentrant. An executor is
no alternative: when the executor itself is collected, its threads end, and later requests to close are never carried out.
"""

import threading
from collections.abc import Callable, Generator
from contextlib import closing
from dataclasses import dataclass
from queue import Empty, SimpleQueue
from typing import Generic, TypeVar

T = TypeVar("T")

THREAD = "prefetched"
"""Name of the background threads."""
_POLL_S = 0.25
"""Interval at which a waiting thread checks whether the main thread is still alive [s]."""


def prefetched(make: Callable[[], Generator[T, None, None]], depth: int) -> Generator[T, None, None]:
    """Yield the items of the generator `make()`. A background thread produces up to `depth` items before they are requested.

    The background thread creates, runs and closes the generator. Exceptions of the generator are raised in the calling
    thread. A caller that may stop early has to close the returned generator, which ends the background thread.
    """
    shared = _Shared[T](depth)
    threading.Thread(target=_produce, args=(make, shared), name=THREAD).start()
    try:
        while not isinstance(received := shared.items.get(), _End):
            yield received.item
            shared.free_slots.put(None)
        if received.error is not None:
            raise received.error
    finally:
        shared.wanted = False
        shared.free_slots.put(None)  # wakes the thread if it waits for a slot


@dataclass(frozen=True, eq=False)
class _Item(Generic[T]):
    item: T


@dataclass(frozen=True, eq=False)
class _End:
    error: BaseException | None


class _Shared(Generic[T]):
    """State that the calling thread and the background thread share."""

    def __init__(self, depth: int) -> None:
        self.items: SimpleQueue[_Item[T] | _End] = SimpleQueue()
        self.free_slots: SimpleQueue[None] = SimpleQueue()
        """One entry for each item that the background thread may still produce before it has to wait."""
        self.wanted = True
        for _ in range(depth - 1):
            self.free_slots.put(None)


def _produce(make: Callable[[], Generator[T, None, None]], shared: _Shared[T]) -> None:
    error = None
    try:
        with closing(make()) as items:
            for item in items:
                shared.items.put(_Item(item))
                _wait_for_slot(shared)
                if not shared.wanted:
                    break
    except BaseException as raised:
        error = raised
    shared.items.put(_End(error))


def _wait_for_slot(shared: _Shared[T]) -> None:
    while threading.main_thread().is_alive():
        try:
            return shared.free_slots.get(timeout=_POLL_S)
        except Empty:
            continue
    raise RuntimeError("the main thread has ended")
