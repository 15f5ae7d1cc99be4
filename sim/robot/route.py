"""`Route`: the line through a plan's waypoints, and how far along it the robot has come."""

import numpy as np
from jaxtyping import Float64

_SAMPLE_M = 0.1
_LEVEL_M = 0.3
"""Heights that differ by no more are of one storey: maps are wrong by some of it."""
_WINDOW_M = 0.8
"""Progress is looked for this far ahead: a way may pass by itself, as on stairs."""


class Route:
    """A polyline, sampled evenly; progress along it only grows."""

    def __init__(self, waypoints: Float64[np.ndarray, "k 3"]) -> None:
        along = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(waypoints[:, :2], axis=0), axis=1)))
        samples = np.append(np.arange(0.0, along[-1], _SAMPLE_M), along[-1])
        x, y, z = (np.interp(samples, along, column) for column in waypoints.T)
        self.points, self._heights = np.stack([x, y], axis=1), z
        self.length_m = float(along[-1])
        self._at = 0

    @property
    def end(self) -> Float64[np.ndarray, "2"]:
        """Where it ends."""
        return np.asarray(self.points[-1])

    @property
    def progress_m(self) -> float:
        """Along the line [m]."""
        return min(self._at * _SAMPLE_M, self.length_m)

    def follow(self, position: Float64[np.ndarray, "2"]) -> None:
        """Go on to the nearest place of the line."""
        window = self.points[self._at : self._at + round(_WINDOW_M / _SAMPLE_M) + 1]
        self._at += int(np.argmin(((window - position) ** 2).sum(axis=1)))

    def skip(self, metres: float) -> None:
        """Leave out a stretch that cannot be followed, but no stairs."""
        later = min(self._at + round(metres / _SAMPLE_M), len(self.points) - 1)
        if np.ptp(self._heights[self._at : later + 1]) <= _LEVEL_M:
            self._at = later

    def ahead(self, metres: float) -> Float64[np.ndarray, "j 2"]:
        """The next stretch of the line, from where the robot is."""
        return self.points[self._at : self._at + round(metres / _SAMPLE_M) + 1]
