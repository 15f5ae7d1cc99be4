"""`lexis-sim bench speed`: times of houses, scenes, frames and mapping on this machine, each with its required limit."""

import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from lexis.types import Camera, Poses
from sim.bench.memory import measure_memory
from sim.bench.overlap import measure_overlap
from sim.bench.plain import PlainRenderer
from sim.harness.scenario import Scenario
from sim.render.camera import CameraRenderer, fovy_deg, wide_camera
from sim.render.scene import build_scene
from sim.tours.tour import plan_tour
from worlds.house import House, build_house
from worlds.presets import sample_house
from worlds.truth import boundary_lines, objects, openness, room_graph
from worlds.validation import validate
from worlds.walkable import Walkable

_VIEWS, _VIEWS_OF_DEFAULTS = 60, 12
_MANY_ROOMS, _MANY_HOUSES = 40, 5
_FRAME_ROOMS = 10
_RGB, _ALL_THREE, _PLAIN, _DEFAULTS = "RGB", "RGB + depth + ids", "RGB, plain", "RGB, defaults"
_RATE_BARS = {(320, 240): {_ALL_THREE: 60.0}, (480, 360): {_RGB: 90.0}}
_RATIO_BARS = {(320, 240): 1.8, (480, 360): 1.25}
_GREY_LEVELS = 2
"""Pixels of merged and plain rendering count as equal if they differ by at most this in every channel [grey levels]."""
_RUN_FRAMES, _RUNS = 400, 5


@dataclass(frozen=True)
class SpeedFigure:
    """Median and worst value of a figure over repeated measurements, in the unit of its section."""

    name: str
    median: float
    worst: float
    runs: int
    limit: str = ""
    """Required limit, such as "<= 500"; empty for figures without a required limit."""


@dataclass(frozen=True)
class Section:
    """A table of speed figures that share a title and a unit."""

    title: str
    unit: str
    figures: tuple[SpeedFigure, ...]


def measure_speed(preset: str, houses: int, seed: int) -> Iterator[Section]:
    """Measure the speed of the simulator; yield one section after the other.

    The sections, in this order:

    1. the time to make a house, over `houses` houses of the preset with seeds from `seed` upwards,
    2. the time to build the scene of one large home,
    3. frame rates in this home, for two image sizes,
    4. the times of rendering and LEXIS, alone and in parallel, in the run of the demo,
    5. the peak memory of a run with rendering.
    """
    yield _houses(preset, houses, seed)
    house, walk = _furnished(seed)
    yield _scenes(house)
    for size in _RATIO_BARS:
        yield from _frames(house, walk, size)
    yield from _runs()
    yield Section("memory of a run with rendering", "MB", (_memory(seed),))


def complete_house(preset: str, seed: int, rooms: int | None = None) -> House:
    """Make a house completely: sample and build it, compute its truth, such as the room graph, and validate it."""
    house = build_house(sample_house(preset, seed, rooms=rooms))
    for truth in (room_graph, boundary_lines, objects, openness):
        truth(house)
    validate(house)
    return house


def _houses(preset: str, houses: int, seed: int) -> Section:
    complete_house(preset, seed), complete_house("office", seed, _MANY_ROOMS)  # warm-up: the first use fills caches
    seeds, many = range(seed, seed + houses), range(seed, seed + min(houses, _MANY_HOUSES))
    return Section(
        "houses: plan, openings, stairs, furniture, truth and validation, on one core",
        "ms",
        (
            _timing(f"complete house, {preset}", lambda s: complete_house(preset, s), seeds, "<= 40, worst <= 400"),
            _timing(
                f"complete house, {_MANY_ROOMS} rooms", lambda s: complete_house("office", s, _MANY_ROOMS), many, "<= 250"
            ),
        ),
    )


def _furnished(seed: int) -> tuple[House, Poses]:
    """Return a home with at least ten rooms, the first by seeds from `seed` upwards, and poses along a tour through it."""
    candidates = (build_house(sample_house("home", s)) for s in range(seed, seed + 1000))
    house = next(house for house in candidates if len(house.rooms) >= _FRAME_ROOMS)
    tour = plan_tour(house, Walkable(house), np.random.default_rng(seed))
    return house, tour.T_W_B[np.linspace(0, len(tour.T_W_B) - 1, _VIEWS).astype(int)]


def _scenes(house: House) -> Section:
    camera = wide_camera()
    size, fovy = (camera.intrinsics.width, camera.intrinsics.height), fovy_deg(camera.intrinsics)
    title = f"scene of a house of {len(house.rooms)} rooms: geometry, textures, MuJoCo's compiler"
    return Section(title, "ms", (_timing("House to MjModel", lambda _: build_scene(house, size, fovy), range(3), "<= 500"),))


def _frames(house: House, walk: Poses, size: tuple[int, int]) -> Iterator[Section]:
    """Measure frame rates and their ratios for merged rendering, plain rendering and MuJoCo's defaults.

    Merged rendering is the simulator's own. Plain rendering uses `mujoco.Renderer` on unmerged geoms. MuJoCo's defaults add
    shadows and multi-sampling. The renderers take turns at each pose, so that other load on the machine slows all alike.
    """
    measured, name = _render_times(house, walk, wide_camera(*size)), f"{size[0]} x {size[1]}"
    geoms = f"{len(house.rooms)} rooms, {measured.geoms} geoms unless merged"
    rates = _rates({**measured.times, _DEFAULTS: measured.few[_DEFAULTS]}, _RATE_BARS[size])
    yield Section(f"frames at {name}: {geoms}; defaults: shadows and MSAA", "1/s", rates)
    yield Section(f"merged against plain at {name}", "1", _ratios(measured, _RATIO_BARS[size]))


class _RenderTimes(NamedTuple):
    """The times that renderers need for images along a walk [s], by the kind of image."""

    times: dict[str, list[float]]
    """Times of merged and of plain rendering at all poses."""
    few: dict[str, list[float]]
    """Times of merged rendering and of MuJoCo's defaults at a few poses."""
    equal: list[float]
    """Share of pixels in which merged and plain rendering agree, at all poses."""
    geoms: int
    """Number of geoms of plain rendering."""


def _render_times(house: House, walk: Poses, camera: Camera) -> _RenderTimes:
    size = camera.intrinsics.width, camera.intrinsics.height
    scene, few = build_scene(house, size, fovy_deg(camera.intrinsics)), walk[:: len(walk) // _VIEWS_OF_DEFAULTS]
    with (
        closing(PlainRenderer(house, camera)) as plain,
        closing(PlainRenderer(house, camera, defaults=True)) as defaults,
        CameraRenderer(scene, camera) as merged,
    ):
        return _RenderTimes(
            _interleaved({_RGB: merged.rgb, _ALL_THREE: merged.frame, _PLAIN: plain.rgb}, walk),
            _interleaved({_RGB: merged.rgb, _DEFAULTS: defaults.rgb}, few),
            [_equal_share(merged.rgb(pose), plain.rgb(pose)) for pose in walk],
            plain.model.ngeom,
        )


def _rates(times: Mapping[str, Sequence[float]], bars: Mapping[str, float]) -> tuple[SpeedFigure, ...]:
    """Return the frame rates for the times of frames; `bars` are the required rates."""
    limits = {name: f">= {bar:g}" for name, bar in bars.items()}
    rates = {name: 1 / np.array(seconds) for name, seconds in times.items()}
    return tuple(
        SpeedFigure(name, float(np.median(rate)), float(rate.min()), len(rate), limits.get(name, ""))
        for name, rate in rates.items()
    )


def _ratios(measured: _RenderTimes, bar: float) -> tuple[SpeedFigure, ...]:
    """Return by how much merged rendering is faster, and whether its images are equal.

    `bar` is the required ratio to plain rendering.
    """
    times, few, equal = measured.times, measured.few, measured.equal
    agreement = f"pixels within {_GREY_LEVELS} grey levels"
    return (
        _ratio("faster than plain", times[_PLAIN], times[_RGB], bar),
        _ratio("faster than defaults", few[_DEFAULTS], few[_RGB], 12.0),
        SpeedFigure(agreement, float(np.median(equal)), min(equal), len(equal), ">= 0.999"),
    )


def _runs() -> Iterator[Section]:
    """Measure the times of rendering alone, LEXIS alone, and both in parallel.

    The three measurements take turns, so that other load on the machine slows all of them alike.
    """
    runs = measure_overlap(Scenario(), _RUN_FRAMES, _RUNS)
    parts = {
        "rendering alone": [run.rendering for run in runs],
        "LEXIS alone": [run.lexis for run in runs],
        "both at once": [run.both for run in runs],
    }
    title = f"{_RUN_FRAMES} frames of the demo"
    yield Section(f"{title}: wall time", "s", tuple(_most(name, [t.wall for t in of]) for name, of in parts.items()))
    yield Section(f"{title}: processor time", "s", tuple(_most(n, [t.processor for t in of]) for n, of in parts.items()))
    yield Section(
        "rendering and LEXIS at once, on two cores that nobody else uses",
        "1",
        (
            _most(
                "wall time of both / time of the slower one in this run",
                [run.wall_over_slower_within for run in runs],
                "<= 1.15",
            ),
            _most(
                "wall time of both / wall time of the slower one alone",
                [run.wall_over_slower_alone for run in runs],
                "<= 1.15",
            ),
            _most("processor time / the sum of each alone", [run.extra_work for run in runs]),
        ),
    )


def _interleaved(work: Mapping[str, Callable[[np.ndarray], object]], poses: Poses) -> dict[str, list[float]]:
    for draw in work.values():
        draw(poses[0])  # the first frame uploads textures and compiles shaders
    times: dict[str, list[float]] = {name: [] for name in work}
    for pose in poses:
        for name, draw in work.items():
            times[name].append(_seconds(draw, pose))
    return times


def _ratio(name: str, slow: Sequence[float], fast: Sequence[float], bar: float) -> SpeedFigure:
    """Return the ratio of two lists of times, `slow` / `fast`, with one time for each pose.

    The median of the figure is the ratio of the two median times; its worst value is the smallest ratio at any pose.
    """
    single = np.array(slow) / np.array(fast)
    return SpeedFigure(name, float(np.median(slow) / np.median(fast)), float(single.min()), len(single), f">= {bar:g}")


def _equal_share(image: np.ndarray, other: np.ndarray) -> float:
    return float(np.mean(np.abs(image.astype(int) - other).max(axis=-1) <= _GREY_LEVELS))


def _memory(seed: int) -> SpeedFigure:
    megabytes = measure_memory(seed) / 1e6
    return SpeedFigure("peak resident, apart from torch", megabytes, megabytes, 1, "<= 1200")


def _most(name: str, values: Sequence[float], bar: str = "") -> SpeedFigure:
    return SpeedFigure(name, float(np.median(values)), max(values), len(values), bar)


def _timing(name: str, work: Callable[[int], object], items: Iterable[int], bar: str = "") -> SpeedFigure:
    milliseconds = [1e3 * _seconds(work, item) for item in items]
    return _most(name, milliseconds, bar)


def _seconds(work: Callable[..., object], item: object) -> float:
    start = time.perf_counter()
    work(item)
    return time.perf_counter() - start
