"""The confusion matrix of room labels."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Int

from sim.report.data import KeyframeTable


@dataclass(frozen=True, eq=False)
class Confusion:
    """Counts of keyframes by true label (rows) and predicted label (columns).

    The first columns are the labels of the rows, in the same order, so that the diagonal counts correct labels.
    """

    rows: tuple[str, ...]
    columns: tuple[str, ...]
    counts: Int[np.ndarray, "rows columns"]

    @property
    def recalls(self) -> list[float]:
        """Recall of each row's label: the share of keyframes with this true label that were labelled correctly."""
        return [float(share) for share in np.diagonal(self.counts) / self.counts.sum(axis=1)]


def confusion(table: KeyframeTable, label_names: Sequence[str]) -> Confusion:
    """Count keyframes by label. Each label that is true has a row, and each label that is true or predicted has a column.

    `label_names` are `ReportData.shown_labels`, whose last name stands for keyframes without a label.
    """
    n = len(label_names)
    counts = np.zeros((n, n), dtype=np.int64)
    np.add.at(counts, (table.true_labels, table.predicted_labels), 1)
    rows = np.flatnonzero(counts.sum(axis=1))
    others = np.setdiff1d(np.flatnonzero(counts.sum(axis=0)), rows)
    columns = np.concatenate([rows, others])
    return Confusion(
        tuple(label_names[int(i)] for i in rows), tuple(label_names[int(i)] for i in columns), counts[np.ix_(rows, columns)]
    )
