"""`NearbyBoxes`: the obstacles near each point of a path, to compute exact distances while the points move a little."""

from dataclasses import dataclass

import numpy as np
import shapely
from jaxtyping import Float64, Int

from worlds.free_space import BODY_HIGH_M, BODY_LOW_M, Obstacles


@dataclass(frozen=True, eq=False)
class NearbyBoxes:
    """Pairs of a path point and an upright box (an obstacle) near this point.

    The pairs are found once. The points may move a little afterwards: the methods take the present places of all points.
    """

    points: int
    """Number of path points."""
    point: Int[np.ndarray, "p"]
    """Index of the path point of each pair."""
    centre: Float64[np.ndarray, "p 2"]
    """Centre (x, y) of each pair's box in W [m]."""
    half: Float64[np.ndarray, "p 2"]
    """For each pair of a path point and a nearby box, half the width and half the depth of the box, along its axes [m]."""
    axes: Float64[np.ndarray, "p 2 2"]
    """Unit vectors in W along the two horizontal axes of each pair's box, as rows."""

    @staticmethod
    def of(places: Float64[np.ndarray, "n 3"], obstacles: Obstacles, within_m: float) -> "NearbyBoxes":
        """Pair each place (in W [m]) with the boxes within `within_m` that are at the height of a body standing there."""
        spots = np.asarray(shapely.points(places[:, :2]))
        point, box = obstacles.footprints.query(spots, predicate="dwithin", distance=within_m)
        height = places[point, 2]
        meets = (obstacles.span[box, 0] < height + BODY_HIGH_M) & (obstacles.span[box, 1] > height + BODY_LOW_M)
        point, box = point[meets], box[meets]
        cos, sin = np.cos(obstacles.yaw[box]), np.sin(obstacles.yaw[box])
        axes = np.stack([cos, sin, -sin, cos], axis=-1).reshape(-1, 2, 2)
        return NearbyBoxes(len(places), point, obstacles.centre[box], obstacles.size[box] / 2, axes)

    def and_also(self, other: "NearbyBoxes") -> "NearbyBoxes":
        """Return the pairs of this object and of `other`. Both objects must refer to the same path points."""
        pairs = [(getattr(self, name), getattr(other, name)) for name in ("point", "centre", "half", "axes")]
        return NearbyBoxes(self.points, *(np.concatenate(pair) for pair in pairs))

    def without(self, points: Int[np.ndarray, "k"]) -> "NearbyBoxes":
        """Return a copy without the pairs of the given path points (indices)."""
        keep = ~np.isin(self.point, points)
        return NearbyBoxes(self.points, self.point[keep], self.centre[keep], self.half[keep], self.axes[keep])

    def distance(self, places: Float64[np.ndarray, "n 2"]) -> Float64[np.ndarray, "n"]:
        """Return the distance from each path point, now at `places`, to its nearest box [m]; infinite without boxes."""
        least = np.full(self.points, np.inf)
        x, y = self._offset(places)
        np.minimum.at(least, self.point, np.sqrt(x * x + y * y))
        return least

    def pushed_out(
        self, places: Float64[np.ndarray, "n 2"], distance: Float64[np.ndarray, "n"]
    ) -> Float64[np.ndarray, "n 2"]:
        """Return the places of the path points, moved away from boxes that are closer than `distance` [m].

        A place that is too close moves in a straight line away from its nearest box, until it is `distance` away.
        """
        x, y = self._offset(places)
        length = np.sqrt(x * x + y * y)
        lack = distance[self.point] - length
        most = np.zeros(self.points)
        np.maximum.at(most, self.point, lack)
        worst = np.flatnonzero((lack > 0.0) & (lack >= most[self.point]) & (length > 1e-9))
        moved = places.copy()
        share = lack[worst] / length[worst]
        moved[self.point[worst]] += np.stack([share * x[worst], share * y[worst]], axis=-1)
        return moved

    def _offset(self, places: Float64[np.ndarray, "n 2"]) -> tuple[Float64[np.ndarray, "p"], Float64[np.ndarray, "p"]]:
        """Return, for each pair, x and y in W of the vector from the nearest point of the box to the path point [m]."""
        x, y = (values[self.point] - centre for values, centre in zip(places.T, self.centre.T, strict=True))
        (ux, vx), (uy, vy), (width, depth) = *self.axes.T, self.half.T
        along, across = ux * x + uy * y, vx * x + vy * y
        along -= np.minimum(np.maximum(along, -width), width)
        across -= np.minimum(np.maximum(across, -depth), depth)
        return ux * along + vx * across, uy * along + vy * across
