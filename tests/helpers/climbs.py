"""Walks that change floor: over stairs and ramps, through a lift, up a spiral, with the drift of an odometry."""

import numpy as np


def profile(*legs, spacing=0.5):
    """Positions every `spacing` [m] along legs of (horizontal length, climb) [m], and the leg of each position."""
    ends = np.cumsum([(0.0, 0.0), *legs], axis=0)
    path = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(ends, axis=0), axis=1))])
    at = np.arange(0.0, path[-1], spacing)
    x, z = (np.interp(at, path, ends[:, k]) for k in (0, 1))
    return np.stack([x, np.zeros_like(x), z], axis=1), np.searchsorted(path, at, side="right") - 1


def wound(positions, radius_m):
    """The same walk on a circle: x becomes the arc length on a circle of the radius [m]."""
    angle = positions[:, 0] / radius_m
    return np.stack([radius_m * np.cos(angle), radius_m * np.sin(angle), positions[:, 2]], axis=1)


def drifting(positions, rng, walk_m=0.04, tilt=0.01):
    """The positions as an odometry measures them.

    Every axis drifts as a random walk with a standard deviation of `walk_m` after 1 m of path. The height also grows by
    `tilt` times the path.
    """
    steps = np.linalg.norm(np.diff(positions, axis=0), axis=1)
    errors = rng.normal(size=(len(steps), 3)) * walk_m * np.sqrt(steps)[:, None]
    errors[:, 2] += tilt * steps
    return positions + np.concatenate([np.zeros((1, 3)), np.cumsum(errors, axis=0)])
