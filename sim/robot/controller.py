"""`Controller`: pure pursuit of a route, round what the scans show."""

import math

import numpy as np
from jaxtyping import Float64

from sim.robot.body import RADIUS_M
from sim.robot.dead_reckoning import DeadReckoning
from sim.robot.local_map import LocalMap
from sim.robot.route import Route

STEP_S = 0.1
SPEED_M_S = 0.7
_TURN_RATE_RAD_S = 1.5
_TURN_GAIN_HZ = 4.0
_LOOKAHEAD_M = 0.7
HORIZON_M = 1.7
_KEEP_M = RADIUS_M + 0.05
"""Kept from the straight line to the next place of a way, if it can be."""
LEAST_M = RADIUS_M + 0.03
"""No way is nearer to anything."""
_REACH = 6
"""Cells of a way that are looked ahead."""
_EASY_M = RADIUS_M + 0.15
"""With this much room the route itself is followed; with less, a way is sought that has the most room."""
_CLOSE_M = RADIUS_M + 0.02
_REPLAN_M = 0.16
_ARRIVED_M, _NEARLY_M = 0.1, 0.5
"""From the end in the plan, once so much of the route is left."""
_HESITATION_S, _PATIENCE_S = 4.0, 12.0
_SKIP_M = 0.5
"""After some time without progress, so much of the route is left out; after more, the robot gives up."""


class Controller:
    """From the believed pose and what is around to the next step: how far forward [m], how much to the left [rad]."""

    def __init__(self, waypoints: Float64[np.ndarray, "k 3"]) -> None:
        self._route, self._map = Route(waypoints), LocalMap(LEAST_M)
        self._way: Float64[np.ndarray, "_ 2"] = np.zeros((0, 2))
        self._planned_at = np.full(2, np.inf)
        self._best_m, self._since_s = -1.0, 0.0
        self._news = False

    def see(self, hits: Float64[np.ndarray, "hits 2"], pose: DeadReckoning, climbed_m: float) -> None:
        """Take a scan; the legs know how much higher they stand than at the start."""
        self._map.add(hits, pose.x, pose.y, pose.yaw, climbed_m)
        self._news = True

    def step(self, pose: DeadReckoning) -> tuple[float, float] | None:
        """The next `STEP_S`; None where the robot has arrived or has given up."""
        here = np.array([pose.x, pose.y])
        self._route.follow(here)
        if self._has_arrived(here) or self._has_lost_patience():
            return None
        target = self._target(here)
        if target is None:
            return 0.0, 0.0
        bearing = math.atan2(target[1] - pose.y, target[0] - pose.x)
        error = math.remainder(bearing - pose.yaw, math.tau)
        most = _TURN_RATE_RAD_S * STEP_S
        turn = min(max(_TURN_GAIN_HZ * STEP_S * error, -most), most)
        return self._forward(here, pose.yaw + turn / 2, error), turn

    def _has_arrived(self, here: Float64[np.ndarray, "2"]) -> bool:
        # Near the end alone is not enough: a plan may pass below its end, or above.
        left_m = self._route.length_m - self._route.progress_m
        return left_m <= _NEARLY_M and bool(np.linalg.norm(self._route.end - here) <= _ARRIVED_M)

    def _has_lost_patience(self) -> bool:
        self._since_s += STEP_S
        if self._since_s > _HESITATION_S:
            self._route.skip(_SKIP_M)
        if self._route.progress_m > self._best_m + 0.1:
            self._best_m, self._since_s = self._route.progress_m, 0.0
        return self._since_s > _PATIENCE_S

    def _target(self, here: Float64[np.ndarray, "2"]) -> Float64[np.ndarray, "2"] | None:
        """Where to steer to; None where no place is better than this one."""
        carrot = self._route.ahead(_LOOKAHEAD_M)[-1]
        if self._map.clearance(here, carrot) >= _EASY_M:
            self._planned_at = np.full(2, np.inf)
            return np.asarray(carrot)
        nearest = self._nearest(here)
        at_end = nearest + 1 >= len(self._way)
        if np.linalg.norm(here - self._planned_at) >= _REPLAN_M or (at_end and self._news):
            self._way, self._planned_at, self._news = self._map.way(here, self._route.ahead(HORIZON_M)), here, False
            nearest = self._nearest(here)
        if len(self._way) < 2:
            return None
        following = self._way[nearest + 1 :] if nearest + 1 < len(self._way) else self._way[-1:]
        for target in following[_REACH::-2]:
            if self._map.clearance(here, target) >= _KEEP_M:
                return np.asarray(target)
        return np.asarray(following[0])

    def _nearest(self, here: Float64[np.ndarray, "2"]) -> int:
        """Index of the nearest place of the way; 0 where there is no way yet."""
        return int(np.argmin(((self._way - here) ** 2).sum(axis=1))) if len(self._way) else 0

    def _forward(self, here: Float64[np.ndarray, "2"], heading: float, error: float) -> float:
        step = STEP_S * SPEED_M_S * max(0.0, math.cos(error)) ** 2
        ahead = here + step * np.array([math.cos(heading), math.sin(heading)])
        after, now = self._map.clearance(ahead, ahead), self._map.clearance(here, here)
        return 0.0 if after < min(_CLOSE_M, now) else step
