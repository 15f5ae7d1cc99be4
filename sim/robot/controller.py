"""`Controller`: steers a robot along a route by pure pursuit, and plans local paths around obstacles in the scans.

At each step:

1. Advance the progress along the route to the point nearest to the robot.
2. If the straight line to the look-ahead point on the route has enough clearance, steer to this point. Otherwise, plan a
   local path in the map of recent scans (`LocalMap`), and again on a finer grid if it ends after a few cells. On stairs,
   the local path leads only as far as the route does not turn back. Steer to the farthest cell of the local path to which
   the straight line has enough clearance.
3. Turn in proportion to the heading error. The larger this error, the slower the robot drives. Stop in front of obstacles.
"""

import math

import numpy as np
from jaxtyping import Float64

from sim.robot.body import RADIUS_M
from sim.robot.dead_reckoning import DeadReckoning
from sim.robot.local_map import FINE_CELL_M, LocalMap
from sim.robot.route import Route

STEP_S = 0.1
"""Time between two control steps [s]."""
SPEED_M_S = 0.7
_TURN_RATE_RAD_S = 1.5
_TURN_GAIN_HZ = 4.0
_LOOKAHEAD_M = 0.7
HORIZON_M = 1.7
"""Greatest length of the part of the route ahead of the robot that local planning considers [m]."""
_KEEP_M = RADIUS_M + 0.05
"""Clearance that the straight line to the next target on a local path has, if possible [m]."""
LEAST_M = RADIUS_M + 0.03
"""Distance that the robot's centre keeps from obstacles on local paths [m], except if no such path exists."""
_EASY_M = RADIUS_M + 0.15
"""Clearance that is enough to follow the route itself [m]. With less clearance, a local path is planned."""
_CLOSE_M = RADIUS_M + 0.02
"""Clearance below which the robot makes no step that brings it closer to an obstacle [m]."""
_REPLAN_M = 0.16
"""Distance that the robot drives before the local path is planned again [m], unless it reaches the end of the path."""
_FEW_CELLS = 5
"""A local path of this many cells or fewer ends where the robot can hardly go on, such as in front of a narrow gap."""
_ARRIVED_M, _NEARLY_M = 0.1, 0.5
"""The robot has arrived if it is at most `_ARRIVED_M` from the route's end, in the plan, and at most `_NEARLY_M` of the
route is left [m]."""
_HESITATION_S, _PATIENCE_S = 4.0, 12.0
_SKIP_M = 0.5
"""Length of route that is skipped after `_HESITATION_S` without progress [m]. A skip counts as progress. The robot gives up
where it cannot skip any further and has made no progress for `_PATIENCE_S`."""


class Controller:
    """Computes the next step of a robot from its estimated pose and its range scans, so that the robot follows waypoints."""

    def __init__(self, waypoints: Float64[np.ndarray, "k 3"]) -> None:
        self._route, self._map = Route(waypoints), LocalMap(LEAST_M)
        self._path: Float64[np.ndarray, "_ 2"] = np.zeros((0, 2))
        self._planned_at = np.full(2, np.inf)
        self._best_m, self._since_s = -1.0, 0.0

    def see(self, hits: Float64[np.ndarray, "hits 2"], pose: DeadReckoning, climbed_m: float) -> None:
        """Add a range scan that was made at the estimated `pose`.

        `hits` are the scanned points in the body frame [m]. `climbed_m` is the robot's height above the start.
        """
        self._map.add(hits, pose.x, pose.y, pose.yaw, climbed_m)

    def step(self, pose: DeadReckoning) -> tuple[float, float] | None:
        """Return forward motion [m] and left turn [rad] for the next `STEP_S`; None if the robot has arrived or gives up."""
        here = np.array([pose.x, pose.y])
        self._route.follow(here)
        if self._has_arrived(here):
            return None
        self._skip_if_stuck()
        if self._since_s > _PATIENCE_S:
            return None
        target = self._target(here)
        if target is None:
            return 0.0, 0.0
        bearing = math.atan2(target[1] - pose.y, target[0] - pose.x)
        error = math.remainder(bearing - pose.yaw, math.tau)
        most = _TURN_RATE_RAD_S * STEP_S
        turn = min(max(_TURN_GAIN_HZ * STEP_S * error, -most), most)
        return self._forward(here, pose.yaw + turn / 2, error, float(np.linalg.norm(target - here))), turn

    def _has_arrived(self, here: Float64[np.ndarray, "2"]) -> bool:
        # Closeness in the plan alone is not enough, because a route may pass below or above its end.
        left_m = self._route.length_m - self._route.progress_m
        return left_m <= _NEARLY_M and bool(np.linalg.norm(self._route.end - here) <= _ARRIVED_M)

    def _skip_if_stuck(self) -> None:
        """Count the time without progress, and skip a part of the route if it has become long."""
        self._since_s += STEP_S
        if self._since_s > _HESITATION_S:
            self._route.skip(_SKIP_M)
        if self._route.progress_m > self._best_m + 0.1:
            self._best_m, self._since_s = self._route.progress_m, 0.0

    def _target(self, here: Float64[np.ndarray, "2"]) -> Float64[np.ndarray, "2"] | None:
        """Return the point to steer to; None if the robot should stay where it is, because the local path ends there."""
        carrot = self._route.ahead(_LOOKAHEAD_M)[-1]
        if self._map.clearance(here, carrot) >= _EASY_M:
            self._planned_at = np.full(2, np.inf)
            return np.asarray(carrot)
        nearest = self._nearest(here)
        at_end = nearest + 1 >= len(self._path)
        if at_end or np.linalg.norm(here - self._planned_at) >= _REPLAN_M:
            self._path, self._planned_at = self._local_path(here), here
            nearest = self._nearest(here)
        if len(self._path) < 2:
            return None
        following = self._path[nearest + 1 :] if nearest + 1 < len(self._path) else self._path[-1:]
        for target in following[::-2]:
            if self._map.clearance(here, target) >= _KEEP_M:
                return np.asarray(target)
        return np.asarray(following[0])

    def _local_path(self, here: Float64[np.ndarray, "2"]) -> Float64[np.ndarray, "j 2"]:
        """Plan a local path along the route, again on the fine grid if the path ends after `_FEW_CELLS` cells."""
        route = self._route.ahead_to_turn(HORIZON_M)
        path = self._map.plan_path(here, route)
        return path if len(path) > _FEW_CELLS else self._map.plan_path(here, route, FINE_CELL_M)

    def _nearest(self, here: Float64[np.ndarray, "2"]) -> int:
        """Return the index of the nearest point of the local path; 0 before the first local path."""
        return int(np.argmin(((self._path - here) ** 2).sum(axis=1))) if len(self._path) else 0

    def _forward(self, here: Float64[np.ndarray, "2"], heading: float, error: float, most_m: float) -> float:
        """Return the length of the next step [m], at most `most_m`, given the heading and the heading error [rad]."""
        step = min(STEP_S * SPEED_M_S * max(0.0, math.cos(error)) ** 2, most_m)
        ahead = here + step * np.array([math.cos(heading), math.sin(heading)])
        after, now = self._map.clearance(ahead, ahead), self._map.clearance(here, here)
        return 0.0 if after < min(_CLOSE_M, now) else step
