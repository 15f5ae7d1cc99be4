"""`Near`: which boxes the points of a path might touch, and exactly how far away those are."""

from dataclasses import dataclass

import numpy as np
import shapely
from jaxtyping import Float64, Int

from worlds.free_space import BODY_HIGH_M, BODY_LOW_M, Obstacles


@dataclass(frozen=True, eq=False)
class Near:
    """Pairs of a point and an upright box, whose nearest places are known for wherever the point may have moved to."""

    points: int
    """How many there are."""
    point: Int[np.ndarray, "p"]
    """Of each pair."""
    centre: Float64[np.ndarray, "p 2"]
    """Of the box [m]."""
    half: Float64[np.ndarray, "p 2"]
    """Half its size [m]."""
    axes: Float64[np.ndarray, "p 2 2"]
    """Its axes in W, as rows."""

    @staticmethod
    def of(places: Float64[np.ndarray, "n 3"], obstacles: Obstacles, within_m: float) -> "Near":
        """The boxes within a distance that a body would meet that stands there, on the walked surface."""
        spots = np.asarray(shapely.points(places[:, :2]))
        point, box = obstacles.footprints.query(spots, predicate="dwithin", distance=within_m)
        height = places[point, 2]
        meets = (obstacles.span[box, 0] < height + BODY_HIGH_M) & (obstacles.span[box, 1] > height + BODY_LOW_M)
        point, box = point[meets], box[meets]
        cos, sin = np.cos(obstacles.yaw[box]), np.sin(obstacles.yaw[box])
        axes = np.stack([cos, sin, -sin, cos], axis=-1).reshape(-1, 2, 2)
        return Near(len(places), point, obstacles.centre[box], obstacles.size[box] / 2, axes)

    def and_also(self, other: "Near") -> "Near":
        """The pairs of both, of the same points."""
        pairs = [(getattr(self, name), getattr(other, name)) for name in ("point", "centre", "half", "axes")]
        return Near(self.points, *(np.concatenate(pair) for pair in pairs))

    def without(self, points: Int[np.ndarray, "k"]) -> "Near":
        """The pairs of all other points."""
        keep = ~np.isin(self.point, points)
        return Near(self.points, self.point[keep], self.centre[keep], self.half[keep], self.axes[keep])

    def distance(self, places: Float64[np.ndarray, "n 2"]) -> Float64[np.ndarray, "n"]:
        """From where each point is now to the nearest of its boxes; infinite where it has none [m]."""
        least = np.full(self.points, np.inf)
        np.minimum.at(least, self.point, np.linalg.norm(self._offset(places), axis=1))
        return least

    def pushed_out(
        self, places: Float64[np.ndarray, "n 2"], distance: Float64[np.ndarray, "n"]
    ) -> Float64[np.ndarray, "n 2"]:
        """Each place moved straight off the box that it is nearest to, until it keeps the distance from that one."""
        offset = self._offset(places)
        length = np.linalg.norm(offset, axis=1)
        lack = distance[self.point] - length
        most = np.zeros(self.points)
        np.maximum.at(most, self.point, lack)
        worst = np.flatnonzero((lack > 0.0) & (lack >= most[self.point]) & (length > 1e-9))
        moved = places.copy()
        moved[self.point[worst]] += (lack[worst] / length[worst])[:, None] * offset[worst]
        return moved

    def _offset(self, places: Float64[np.ndarray, "n 2"]) -> Float64[np.ndarray, "p 2"]:
        """From the nearest place of the box to the point, in W."""
        x, y = (places[self.point] - self.centre).T
        (ux, uy), (vx, vy) = self.axes[:, 0].T, self.axes[:, 1].T
        along, across = ux * x + uy * y, vx * x + vy * y
        along -= np.clip(along, -self.half[:, 0], self.half[:, 0])
        across -= np.clip(across, -self.half[:, 1], self.half[:, 1])
        return np.stack([ux * along + vx * across, uy * along + vy * across], axis=-1)
