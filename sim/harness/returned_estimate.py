"""`checked_estimate`: compares the estimate that a SLAM has returned with what the SLAM was given in the run."""

from collections.abc import Collection
from dataclasses import replace

import numpy as np

from sim.errors import EstimateError
from sim.harness.estimate import Estimate


def checked_estimate(returned: object, given: Collection[int], name_count: int) -> Estimate:
    """Return a copy of what `SlamUnderTest.finish` has returned, if it is a valid estimate.

    The copy stays as it is if the SLAM goes on to write into its arrays, such as for planning.

    Raises `EstimateError` for anything but an `Estimate`, for an estimate that the SLAM has made invalid after creating it,
    for frames that are not in `given`, and for indices of room names that are not below `name_count`.
    """
    if not isinstance(returned, Estimate):
        raise EstimateError(f"SLAM under test: finish() returned {type(returned).__name__}; valid: an Estimate")
    returned = replace(returned)  # checks the arrays again, because a SLAM may have written into them since
    for row, frame in enumerate(returned.frames.tolist()):
        if frame not in given:
            raise EstimateError(f"estimate: frames has {frame} in row {row}; valid: {_indices(given)}")
    for name in ("labels", "baseline_labels"):
        values = getattr(returned, name)
        if values is not None and (beyond := np.flatnonzero(values >= name_count)).size:
            bad = f"{name} has {values[beyond[0]]} in row {beyond[0]}"
            raise EstimateError(f"estimate: {bad}; valid: -1 to {name_count - 1}, since there are {name_count} room names")
    columns = name_count if returned.similarities is None else returned.similarities.shape[1]
    if columns != name_count:
        raise EstimateError(f"estimate: similarities has {columns} columns; valid: {name_count}, one for each room name")
    return returned


def _indices(given: Collection[int]) -> str:
    """Return the indices of the observations that the SLAM was given, as text for messages."""
    if not given:
        return "indices of observations that the SLAM was given and did not refuse, of which there are none"
    low, high = min(given), max(given)
    gaps = len(given) <= high - low
    return f"{low} to {high}" + (", without observations that were dropped or that the SLAM refused" if gaps else "")
