"""The benchmarks of `lexis-sim bench all`, with their arguments in a quick and in a full extent."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path


@dataclass(frozen=True)
class Extent:
    """How much the benchmarks measure."""

    houses: int
    """Number of houses of each preset."""
    fidelity: str
    """Fidelity of the benchmarks that can do without images."""
    place_walk_m: int
    """Length of the walks on which place recognition is compared [m]."""
    sweep_options: str
    """Options of the sweeps that need images."""
    render_rate_hz: int
    """Frames per second on images, for benchmarks that do not measure time [Hz]."""
    encoder_presets: str
    """Presets of the houses in which encoders are compared."""
    drivers: str
    """Drivers of plans, by their names in `sim.bench.planning`."""
    long_walk_m: int
    """Length of the long walk [m]."""
    long_walk_rooms: int
    """Number of rooms of the house of the long walk."""


QUICK = Extent(
    houses=2,
    fidelity="features",
    place_walk_m=75,
    sweep_options="--length 60",
    render_rate_hz=5,
    encoder_presets="home",
    drivers="LEXIS odometry",
    long_walk_m=1000,
    long_walk_rooms=10,
)
FULL = Extent(
    houses=5,
    fidelity="render",
    place_walk_m=250,
    sweep_options="",
    render_rate_hz=10,
    encoder_presets="ori home",
    drivers="truth LEXIS odometry",
    long_walk_m=10000,
    long_walk_rooms=40,
)


@dataclass(frozen=True)
class Benchmark:
    """One benchmark of the list."""

    name: str
    """Name of its file of text, without the ending."""
    arguments: tuple[str, ...]
    """Arguments of `lexis-sim bench`, for the folder of the collection as the working directory."""
    quick_s: int
    """Processor time in the quick extent [s], by which the remaining time is estimated."""
    is_timing: bool = False
    """Whether the benchmark measures time or uses all cores, so that no other benchmark may run beside it."""
    files: tuple[str, ...] = ()
    """Names of the files that it writes besides its text. Each of them is one of the arguments."""
    inputs: tuple[Path, ...] = ()
    """Files that it reads."""

    def arguments_in(self, out: Path) -> tuple[str, ...]:
        """Return the arguments with which all files are written to the folder `out`."""
        return tuple(str(out / word) if word in self.files else word for word in self.arguments)


POSE_GRAPH = "pose-graph"
"""Name of the benchmark that needs files."""
_PRESETS = ("uh2-apt", "uh2-office", "ori", "home")
"""The presets that are named like the datasets of the paper."""
_OUT = "OUT"
"""Stands for the folder of the collection in the lists below."""
_RENDERED_SWEEP = "--houses {houses} {sweep_options} --rate {render_rate_hz} --seed 500"
"""Arguments of the sweeps that need images."""
_LIST = (
    ("table2", "table2 --presets {presets} --houses {houses} --fidelity {fidelity} --seed 500 --csv {out}/table2.csv", 30),
    (
        "fig5",
        "fig5 --presets ori home --houses {houses} --length {place_walk_m} --rate {render_rate_hz} --seed 500 "
        "--out {out}/fig5.csv",
        105,
    ),
    ("table3", "table3 --presets {presets} --houses {houses} --fidelity {fidelity} --seed 500 --csv {out}/table3.csv", 45),
    ("openness", "openness --houses {houses} --seed 500 --out {out}/openness.csv {out}/openness.png", 25),
    ("clutter", "sweep clutter --houses {houses} --seed 500 --out {out}/clutter.csv {out}/clutter.png", 15),
    ("odometry", "sweep odometry --houses {houses} --seed 500 --out {out}/odometry.csv {out}/odometry.png", 15),
    ("spacing", "sweep spacing --houses {houses} --seed 500 --out {out}/spacing.csv {out}/spacing.png", 20),
    ("light", f"sweep light {_RENDERED_SWEEP} --out {{out}}/light.csv {{out}}/light.png", 80),
    ("texture", f"sweep texture {_RENDERED_SWEEP} --out {{out}}/texture.csv {{out}}/texture.png", 85),
    (
        "place-recognition",
        "place-recognition --presets {presets} --houses {houses} --fidelity {fidelity} --seed 500",
        80,
    ),
    ("kernels", "kernels --houses {houses} --seed 500 --csv {out}/kernels.csv --plot {out}/kernels.png", 15),
    ("failing-odometry", "odometry --houses {houses} --fidelity {fidelity} --seed 500 --csv {out}/failing-odometry.csv", 30),
    ("sessions", "sessions --houses {houses} --seed 500", 25),
    ("planning", "planning --houses {houses} --fidelity {fidelity} --drivers {drivers} --seed 500", 40),
    ("certainty", "certainty --presets {presets} --houses {houses} --fidelity {fidelity} --seed 500", 15),
    ("queries", "queries --houses {houses} --rate {render_rate_hz} --seed 500", 60),
    ("fidelity", "fidelity --houses {houses} --seed 500", 25),
)
"""Names, arguments and quick processor times of the benchmarks that may run beside each other."""
_OF_PRESETS = (
    ("segmentation", "segmentation --preset {preset} --houses {houses} --fidelity {fidelity} --seed 500", 20),
    ("rooms", "rooms --preset {preset} --houses {houses} --seed 500", 15),
)
"""The same for benchmarks of a single preset, which run once for each of `_PRESETS`."""
_TIMINGS = (
    ("rigs", "rigs --houses {houses} --fidelity {fidelity} --seed 500 --csv {out}/rigs.csv", 15),
    ("table1", "encoders --presets {encoder_presets} --encoders mini --houses {houses} --seed 500", 60),
    ("stages", "stages --presets {presets} --houses {houses} --seed 500 --csv {out}/stages.csv", 115),
    ("scale", "scale --rooms {long_walk_rooms} --length {long_walk_m} --seed 300", 15),
    ("speed", "speed --houses {houses} --seed 500", 140),
    ("throughput", "throughput --houses 8 --seed 100", 25),
)
"""The same for benchmarks that run alone."""


def benchmarks(extent: Extent, pose_graphs: Sequence[Path] = ()) -> tuple[Benchmark, ...]:
    """Return all benchmarks: first those that may run beside each other, longest first; then those that measure time.

    Args:
        extent: how much they measure.
        pose_graphs: g2o files to optimise; without any, the benchmark `pose-graph` is left out.
    """
    values = {**asdict(extent), "presets": " ".join(_PRESETS), "out": _OUT}

    def filled(name: str, template: str, seconds: int, preset: str = "", is_timing: bool = False) -> Benchmark:
        words = template.format(**values, preset=preset).split()
        files = tuple(word.removeprefix(f"{_OUT}/") for word in words if word.startswith(_OUT))
        arguments = tuple(word.removeprefix(f"{_OUT}/") for word in words)
        return Benchmark(name, arguments, seconds, is_timing, files)

    together = [filled(*entry) for entry in _LIST]
    together += [
        filled(f"{name}-{preset}", template, seconds, preset)
        for name, template, seconds in _OF_PRESETS
        for preset in _PRESETS
    ]
    timings = [filled(*entry, is_timing=True) for entry in _TIMINGS]
    if pose_graphs:
        arguments = (POSE_GRAPH, *map(str, pose_graphs))
        timings.append(Benchmark(POSE_GRAPH, arguments, 10, is_timing=True, inputs=tuple(pose_graphs)))
    return (*sorted(together, key=lambda each: -each.quick_s), *timings)
