"""`lexis-sim bench speed`: how long a house, its scene and its frames take on this machine."""

import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from sim.camera import CameraRenderer, fovy_deg, wide_camera
from sim.scene import build_scene
from sim.tour import plan_tour
from worlds.house import House, build_house
from worlds.presets import sample_house
from worlds.validation import validate
from worlds.walkable import Walkable

_FRAMES = 60


@dataclass(frozen=True)
class Timing:
    """A figure over repetitions [ms]."""

    name: str
    median_ms: float
    worst_ms: float
    runs: int


def measure_speed(preset: str, houses: int, seed: int) -> list[Timing]:
    """Time every step from seed to frame over `houses` houses of a preset, from `seed` upwards."""
    seeds = range(seed, seed + houses)
    _house(preset, seeds[0])  # first use fills the caches of patterns and modules
    built = [_house(preset, s) for s in seeds]
    timings = [
        _timing("spec, geometry and furniture", lambda s: _house(preset, s), seeds),
        _timing("validation", validate, built),
        _timing("tour", lambda house: plan_tour(house, Walkable(house), np.random.default_rng(seed)), built[:3]),
    ]
    for width, height in ((320, 240), (480, 360)):
        camera = wide_camera(width, height)
        fovy = fovy_deg(camera.intrinsics)
        compile_scene = partial(build_scene, size_px=(width, height), fovy_deg=fovy)
        timings.append(_timing(f"scene, {width} x {height}", compile_scene, built[:3]))
        timings.append(_frames(built[0], width, height, seed))
    return timings


def _house(preset: str, seed: int) -> House:
    return build_house(sample_house(preset, seed))


def _frames(house: House, width: int, height: int, seed: int) -> Timing:
    camera = wide_camera(width, height)
    tour = plan_tour(house, Walkable(house), np.random.default_rng(seed))
    poses = tour.T_W_B[np.linspace(0, len(tour.T_W_B) - 1, _FRAMES).astype(int)]
    with CameraRenderer(build_scene(house, (width, height), fovy_deg(camera.intrinsics)), camera) as renderer:
        renderer.rgb(poses[0])  # the first frame uploads the textures
        return _timing(f"RGB frame, {width} x {height}", renderer.rgb, poses)


def _timing(name: str, work: Callable[[Any], object], items: Iterable[Any]) -> Timing:
    seconds = []
    for item in items:
        start = time.perf_counter()
        work(item)
        seconds.append(time.perf_counter() - start)
    return Timing(name, 1e3 * float(np.median(seconds)), 1e3 * max(seconds), len(seconds))
