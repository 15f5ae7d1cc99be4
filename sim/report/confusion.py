"""The confusion matrix of labels."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Int

from sim.report.data import KeyframeTable


@dataclass(frozen=True, eq=False)
class Confusion:
    """Counts of keyframes; rows are true labels, columns are predicted ones. The columns begin with the rows."""

    rows: tuple[str, ...]
    columns: tuple[str, ...]
    counts: Int[np.ndarray, "rows columns"]

    @property
    def recalls(self) -> list[float]:
        """Per row: the share of its keyframes that carry its label."""
        return [float(share) for share in np.diagonal(self.counts) / self.counts.sum(axis=1)]


def confusion(table: KeyframeTable, label_names: Sequence[str]) -> Confusion:
    """Rows for the labels that occur in truth, columns for these and for the others that were predicted."""
    n = len(label_names)
    counts = np.zeros((n, n), dtype=np.int64)
    np.add.at(counts, (table.true_labels, table.predicted_labels), 1)
    rows = np.flatnonzero(counts.sum(axis=1))
    others = np.setdiff1d(np.flatnonzero(counts.sum(axis=0)), rows)
    columns = np.concatenate([rows, others])
    return Confusion(
        tuple(label_names[int(i)] for i in rows), tuple(label_names[int(i)] for i in columns), counts[np.ix_(rows, columns)]
    )
