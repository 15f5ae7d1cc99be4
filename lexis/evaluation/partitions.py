"""Overlap of two partitions of the same keyframes, from which all room metrics are computed."""

import numpy as np
from jaxtyping import Float64, Int


def overlap(predicted: Int[np.ndarray, "n"], truth: Int[np.ndarray, "n"]) -> Int[np.ndarray, "p t"]:
    """Count the keyframes that each predicted instance (row) shares with each true instance (column).

    Rows and columns are in ascending order of the ids of the instances.
    """
    _, rows = np.unique(predicted, return_inverse=True)
    _, columns = np.unique(truth, return_inverse=True)
    table = np.zeros((rows.max(initial=-1) + 1, columns.max(initial=-1) + 1), int)
    np.add.at(table, (rows, columns), 1)
    return table


def iou(table: Int[np.ndarray, "p t"], sizes: Int[np.ndarray, "1 t"]) -> Float64[np.ndarray, "p t"]:
    """Intersection over union of every predicted instance with every true instance.

    `table` is that of `overlap`, with or without its rows of keyframes in no predicted instance. `sizes` holds the number of
    keyframes of every true instance.
    """
    union = table.sum(axis=1, keepdims=True) + sizes - table
    return np.asarray(table / np.maximum(union, 1))
