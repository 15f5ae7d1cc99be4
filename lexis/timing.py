"""Measurement of the wall time spent in each stage. The times are only reported; no decision depends on them."""

from collections.abc import Iterator
from contextlib import contextmanager
from time import perf_counter


class StageTimer:
    """Sums the wall time that `with` blocks spend in each stage."""

    def __init__(self) -> None:
        """Create a timer without stages."""
        self.seconds: dict[str, float] = {}

    @contextmanager
    def __call__(self, stage: str) -> Iterator[None]:
        """Add the wall time of a `with` block to the total of `stage`, also if the block raises an exception."""
        start = perf_counter()
        try:
            yield
        finally:
            self.seconds[stage] = self.seconds.get(stage, 0.0) + perf_counter() - start
