"""`Route`: the polyline through a plan's waypoints, and the robot's progress along it; `legs` divides a plan at lifts."""

import numpy as np
from jaxtyping import Float64

from lexis.maths.paths import arc_length
from lexis.maths.ties import rounded
from lexis.stairs import lift_rides

_SAMPLE_M = 0.1
_LEVEL_M = 0.3
"""Largest difference in height of route points that count as on one level [m]. It allows for errors of the map."""
_WINDOW_M = 0.8
"""Length of route ahead in which the point nearest to the robot is searched [m]. It is short, because another part of the
route may pass close by."""


def legs(waypoints: Float64[np.ndarray, "k 3"]) -> list[Float64[np.ndarray, "_ 3"]]:
    """Divide waypoints [m] into the parts before, between and after rides in a lift.

    Rides that share a step are one ride, in which somebody stepped aside.
    """
    start, parts = 0, []
    for ride in lift_rides(waypoints):
        if ride.start >= start:
            parts.append(waypoints[start : ride.start + 1])
        start = ride.stop - 1
    return [*parts, waypoints[start:]]


class Route:
    """The polyline through the waypoints, and the robot's progress along the polyline, which never decreases."""

    def __init__(self, waypoints: Float64[np.ndarray, "k 3"]) -> None:
        along = arc_length(waypoints[:, :2])
        samples = np.append(np.arange(0.0, along[-1], _SAMPLE_M), along[-1])
        x, y, z = (np.interp(samples, along, column) for column in waypoints.T)
        self.points, self._heights = np.stack([x, y], axis=1), z
        self.length_m = float(along[-1])
        self._at = 0

    @property
    def end(self) -> Float64[np.ndarray, "2"]:
        """The last point of the route."""
        return np.asarray(self.points[-1])

    @property
    def progress_m(self) -> float:
        """Length of the route that the robot has passed or skipped [m]."""
        return min(self._at * _SAMPLE_M, self.length_m)

    def follow(self, position: Float64[np.ndarray, "2"]) -> None:
        """Advance the progress to the point of the next part of the route that is nearest to the robot's `position`."""
        window = self.points[self._at : self._at + round(_WINDOW_M / _SAMPLE_M) + 1]
        self._at += int(np.argmin(((window - position) ** 2).sum(axis=1)))

    def skip(self, metres: float) -> None:
        """Advance the progress by `metres`, to skip a part that cannot be followed. Parts on stairs are not skipped."""
        later = min(self._at + round(metres / _SAMPLE_M), len(self.points) - 1)
        if np.ptp(self._heights[self._at : later + 1]) <= _LEVEL_M:
            self._at = later

    def ahead(self, metres: float) -> Float64[np.ndarray, "j 2"]:
        """Return the route's points in the next `metres`, from the present progress."""
        return self.points[self._at : self._at + round(metres / _SAMPLE_M) + 1]

    def ahead_to_turn(self, metres: float) -> Float64[np.ndarray, "j 2"]:
        """Return the route's points in the next `metres`, on stairs only as far as the route does not turn back.

        After a turn of more than 120 degrees, the next flight may be close to the robot, but behind a railing.
        """
        points = self.ahead(metres)
        if np.ptp(self._heights[self._at : self._at + len(points)]) <= _LEVEL_M:
            return points
        steps = np.diff(points, axis=0)
        lengths = np.linalg.norm(steps, axis=1)
        back = np.flatnonzero(rounded(steps @ steps[0]) < rounded(-0.5 * lengths * lengths[0]))
        return points[: back[0] + 1] if len(back) else points
