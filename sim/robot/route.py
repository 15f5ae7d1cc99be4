"""`Route`: the line through a plan's waypoints, and how far along it the robot has come."""

import numpy as np
from jaxtyping import Float64

_SAMPLE_M = 0.1
_WINDOW_M = 0.8
"""Progress is looked for this far ahead: a way may pass by itself, as on stairs."""


class Route:
    """A polyline, straight on `beyond_m` past its end, sampled evenly; progress along it only grows."""

    def __init__(self, waypoints: Float64[np.ndarray, "k 2"], beyond_m: float = 0.0) -> None:
        waypoints = np.concatenate([waypoints, _beyond(waypoints, beyond_m)])
        along = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(waypoints, axis=0), axis=1)))
        samples = np.append(np.arange(0.0, along[-1], _SAMPLE_M), along[-1])
        self.points = np.stack([np.interp(samples, along, waypoints[:, axis]) for axis in (0, 1)], axis=1)
        self.length_m = float(along[-1])
        self._at = 0

    @property
    def end(self) -> Float64[np.ndarray, "2"]:
        """The last waypoint."""
        return np.asarray(self.points[-1])

    @property
    def progress_m(self) -> float:
        """Along the line [m]."""
        return min(self._at * _SAMPLE_M, self.length_m)

    def follow(self, position: Float64[np.ndarray, "2"]) -> None:
        """Go on to the nearest place of the line."""
        window = self.points[self._at : self._at + round(_WINDOW_M / _SAMPLE_M) + 1]
        self._at += int(np.argmin(((window - position) ** 2).sum(axis=1)))

    def ahead(self, metres: float) -> Float64[np.ndarray, "j 2"]:
        """The next stretch of the line, from where the robot is."""
        return self.points[self._at : self._at + round(metres / _SAMPLE_M) + 1]


def _beyond(waypoints: Float64[np.ndarray, "k 2"], metres: float) -> Float64[np.ndarray, "_ 2"]:
    """A place in the direction of the last leg; none where no leg has a length."""
    legs = np.diff(waypoints, axis=0)
    lengths = np.linalg.norm(legs, axis=1)
    if not (lengths > 0.0).any():
        return np.zeros((0, 2))
    last = int(np.flatnonzero(lengths > 0.0)[-1])
    return np.asarray(waypoints[-1:] + metres * legs[last] / lengths[last])
