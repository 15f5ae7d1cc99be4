"""`GrowingArray`: an array to which rows are appended one by one."""

import numpy as np
from jaxtyping import Int, Shaped
from numpy.typing import DTypeLike

_FIRST_ROWS = 64


class GrowingArray:
    """An array that grows by appended rows. Appending takes constant time on average, however many rows there are."""

    def __init__(self, row_shape: tuple[int, ...], dtype: DTypeLike = np.float64) -> None:
        """Create an array without rows."""
        self._count = 0
        self._use(np.empty((_FIRST_ROWS, *row_shape), dtype))

    @property
    def rows(self) -> Shaped[np.ndarray, "n *row"]:
        """The rows so far, as a view that cannot be written to.

        Rows that are appended later do not change the view. Rows that are replaced later may change it: copy rows to keep.
        """
        return self._readable[: self._count]

    def append(self, row: Shaped[np.ndarray, "*row"] | float | int) -> None:
        """Append one row."""
        if self._count == len(self._buffer):
            self._use(np.concatenate([self._buffer, np.empty_like(self._buffer)]))
        self._buffer[self._count] = row
        self._count += 1

    def replace(self, indices: Int[np.ndarray, "k"] | slice, rows: Shaped[np.ndarray, "k *row"] | bool) -> None:
        """Replace the rows with the given indices, in a time that does not depend on the number of all rows."""
        self._buffer[indices] = rows

    def _use(self, buffer: Shaped[np.ndarray, "capacity *row"]) -> None:
        self._buffer, self._readable = buffer, buffer.view()
        self._readable.flags.writeable = False
