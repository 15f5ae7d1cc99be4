"""`lexis-sim bench pose-graph`: LEXIS's optimiser on pose graphs in g2o files, such as the public benchmarks.

Every file is optimised twice: from odometry, which may end in a wrong minimum, and from the chordal relaxation.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter
from types import MappingProxyType
from typing import NamedTuple

from lexis.config import PoseGraphConfig
from lexis.errors import one_line
from lexis.files.g2o import G2oGraph, read_g2o
from lexis.graph.graph_optimisation import GraphOptimiser
from sim.errors import SimError


class KnownGraph(NamedTuple):
    """A public pose graph whose least cost is known: half of the sum of squared whitened residuals on SE(3)."""

    poses: int
    edges: int
    least_cost: float


KNOWN: Mapping[str, KnownGraph] = MappingProxyType(
    {"sphere2500": KnownGraph(2500, 4949, 675.701), "parking-garage": KnownGraph(1661, 6275, 0.634192)}
)
"""Public pose graphs by the name of the file without its ending."""
_CONFIG = PoseGraphConfig(kernel="none", min_rotation_sigma_rad=1e-9, min_translation_sigma_m=1e-9, max_iterations=100)
"""Settings for least squares without a robust kernel, in which the covariances of the file are used as they are."""
_STARTS: Mapping[str, Callable[[GraphOptimiser], None]] = MappingProxyType(
    {"odometry": lambda graph: None, "chordal": GraphOptimiser.start_chordally}
)


@dataclass(frozen=True)
class PoseGraphRow:
    """One optimisation of one file."""

    file: str
    poses: int
    edges: int
    start: str
    """Where the optimisation started: odometry or chordal."""
    start_cost: float
    """Half of the sum of squared whitened residuals at the start."""
    cost: float
    """Half of the sum of squared whitened residuals after the optimisation."""
    excess: float | None
    """How much higher the cost is than the least known cost: 0.1 if it is 10 % higher. None unless name and size of the
    graph are those of one of `KNOWN`."""
    iterations: int | None
    seconds: float
    """Time to find the start and to optimise [s]; reading the file is not included."""


def optimise_files(paths: Sequence[Path]) -> Iterator[PoseGraphRow]:
    """Optimise every file from both starts. Raises `LexisError` or `SimError` for a file that cannot be used."""
    for path, name in zip(paths, names_of(paths), strict=True):
        graph = read_g2o(path)
        for start, begin in _STARTS.items():
            optimiser = optimiser_of(graph, str(path))
            began = perf_counter()
            try:
                begin(optimiser)
                start_cost = optimiser.cost
                optimiser.optimise()
            except RuntimeError as error:  # of GTSAM, for a system of equations that rounding makes singular
                found = f"{path}: cannot be optimised: {one_line(str(error), 120)}"
                raise SimError(f"{found}; valid: distances and information matrices that differ less") from None
            seconds = perf_counter() - began
            size = len(graph.T_W_B), len(graph.edges)
            known = KNOWN.get(path.stem)
            excess = optimiser.cost / known.least_cost - 1.0 if known and known[:2] == size else None
            yield PoseGraphRow(name, *size, start, start_cost, optimiser.cost, excess, optimiser.iterations, seconds)


def names_of(paths: Sequence[Path]) -> Sequence[str]:
    """Return names that tell files apart: without folder and ending, or else the fewest last parts of the paths that do."""
    longest = max((len(path.parts) for path in paths), default=0)
    names = [path.stem for path in paths]
    for count in range(1, longest + 1):
        if len(set(names)) == len(names):
            break
        names = [str(Path(*path.parts[-count:])) for path in paths]
    return names


def optimiser_of(graph: G2oGraph, name: str) -> GraphOptimiser:
    """Return LEXIS's optimiser with the pose graph of a file.

    The first edge between two consecutive poses counts as their odometry; all other edges count as loops. The initial poses
    are those of the odometry.

    Raises `SimError` if two consecutive poses have no edge, because LEXIS's graphs have odometry between all keyframes.
    """
    steps = {edge.query: edge for edge in reversed(graph.edges) if edge.query == edge.match + 1}
    optimiser, pose = GraphOptimiser(graph.T_W_B[0], _CONFIG), graph.T_W_B[0]
    for k in range(1, len(graph.T_W_B)):
        if k not in steps:
            raise SimError(f"{name}: no edge between poses {k - 1} and {k}; valid: edges between all consecutive poses")
        pose = pose @ steps[k].T_match_query
        optimiser.add_keyframe(pose, steps[k].T_match_query, steps[k].covariance)
    optimiser.add_loops([edge for edge in graph.edges if edge is not steps.get(edge.query)])
    return optimiser
