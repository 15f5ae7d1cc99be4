"""`lexis-sim bench kernels`: how well robust kernels of the pose graph reject false loops that are added to finished maps.

LEXIS maps every house once, and lets no keyframe retire. Then false loops are added to the loops of its pose graph, and the
graph is optimised with each kernel.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

import numpy as np
from jaxtyping import Bool

from lexis.config import Config, PoseGraphConfig
from lexis.evaluation.trajectory import ate_rmse
from lexis.graph.pose_graph import PoseGraph
from lexis.graph.trusted_loops import is_trusted
from lexis.types import Keyframe, LoopEdge, Poses
from sim.bench.houses import for_seeds
from sim.bench.pose_graphs.injected_loops import KINDS, injected
from sim.bench.row_files import Curve, draw_panels, grouped, mean_and_std
from sim.harness import Scenario, run
from sim.harness.adapters import Lexis
from sim.harness.loops import edge_truth
from sim.harness.world_tests import FEATURES_FRAME_RATE_HZ

KERNELS: tuple[Literal["dcs", "gnc", "huber", "none"], ...] = ("dcs", "gnc", "huber", "none")
SHARES = (0.0, 0.1, 0.2, 0.3, 0.4, 0.5)
"""Shares of injected (false) loops among all loops."""


@dataclass(frozen=True, eq=False)
class MappedHouse:
    """The pose graph that LEXIS built in one house, and the truth about it."""

    seed: int
    keyframes: tuple[Keyframe, ...]
    loops: tuple[LoopEdge, ...]
    is_true: Bool[np.ndarray, "loops"]
    true_poses: Poses


@dataclass(frozen=True)
class KernelRun:
    """One optimisation of one house with injected loops."""

    seed: int
    kind: str
    share: float
    kernel: str
    ate_m: float | None
    """Absolute trajectory error of the keyframes [m]; None for fewer than 3 keyframes."""
    true_rejected: float | None
    """Share of LEXIS's own true loops that are rejected; None without true loops."""
    false_trusted: float | None
    """Share of the injected loops that are not rejected; None without injected loops."""


@dataclass(frozen=True)
class KernelRow:
    """Means and standard deviations over the houses, for one kernel, one kind and one share of injected loops.

    Each figure is over the houses that have it; see `mean_and_std`.
    """

    kind: str
    share: float
    kernel: str
    houses: int
    """Number of houses into whose graph these loops were injected."""
    ate_m: float | None
    ate_std_m: float | None
    growth: float | None
    """How much the injected loops increase the ATE with this kernel, as a mean over the houses: 0.1 if the ATE is 10 %
    larger than without injected loops."""
    true_rejected: float | None
    true_rejected_std: float | None
    false_trusted: float | None
    houses_without_rejected_true_loops: float | None
    """Share of the houses in which no true loop is rejected."""


def mapped_houses(preset: str, seeds: Sequence[int], settings: Config | None = None) -> Iterator[MappedHouse]:
    """Let LEXIS map a house for each seed on the feature sensor, with these settings or the default ones.

    No keyframe retires, because a retired keyframe cannot be added to another graph: its loops have been dropped from the
    map, and its pose depends on that of its anchor.
    """
    usual = Scenario(preset=preset, fidelity="features", frame_rate_hz=FEATURES_FRAME_RATE_HZ)
    settings = settings or Config()
    slam = Lexis(config=replace(settings, pose_graph=replace(settings.pose_graph, copies=None)))
    for scenario in for_seeds(usual, seeds):
        finished = run(scenario, slam)
        yield MappedHouse(scenario.seed, slam.map.keyframes, slam.map.loops, edge_truth(finished), finished.true_poses)


def kernel_runs(house: MappedHouse, settings: PoseGraphConfig | None = None) -> Iterator[KernelRun]:
    """Optimise the graph of a house with every kernel, kind and share of injected loops.

    A share above 0 is left out if no loop can be injected: for example, if LEXIS found no loop in the house. `settings` are
    those of the graph, except for the kernel; None: defaults.
    """
    for kind in KINDS:
        for share in SHARES:
            rng = np.random.default_rng((house.seed, list(KINDS).index(kind), round(100 * share)))
            count = round(share / (1.0 - share) * len(house.loops))
            false = injected(kind, count, house.true_poses, house.loops, rng)
            if share and not false:
                continue
            for kernel in KERNELS:
                config = replace(settings or PoseGraphConfig(), kernel=kernel)
                yield KernelRun(house.seed, kind, share, kernel, *_optimised(house, false, config))


def _optimised(
    house: MappedHouse, false: Sequence[LoopEdge], config: PoseGraphConfig
) -> tuple[float | None, float | None, float | None]:
    """Optimise the graph with the loops `false` added, starting at the odometry.

    Returns the ATE [m], the share of LEXIS's own true loops that are rejected, and the share of `false` that are not.
    """
    graph = PoseGraph(config)
    for keyframe in house.keyframes:
        graph.add_keyframe(keyframe)
    graph.add_loops([*house.loops, *false])
    graph.optimise_if_due(final=True)
    rejected = ~is_trusted(graph.loop_weights)
    own, added = rejected[: len(house.loops)][house.is_true], rejected[len(house.loops) :]
    ate_m = ate_rmse(graph.T_W_B[:, :3, 3], house.true_poses[:, :3, 3])
    return ate_m, float(own.mean()) if len(own) else None, float((~added).mean()) if len(added) else None


def summarised(runs: Sequence[KernelRun]) -> Iterator[KernelRow]:
    """Yield means and standard deviations over the houses, in the order of kinds, shares and kernels."""
    clean = {(each.seed, each.kind, each.kernel): each.ate_m for each in runs if each.share == 0.0}
    groups = grouped(runs, "kind", "share", "kernel")
    kinds = list(KINDS)
    for kind, share, kernel in sorted(groups, key=lambda key: (kinds.index(key[0]), key[1], KERNELS.index(key[2]))):
        found = groups[kind, share, kernel]
        rejected = [each.true_rejected for each in found]
        growth, _ = mean_and_std(_growth(each.ate_m, clean[each.seed, kind, kernel]) for each in found)
        trusted, _ = mean_and_std(each.false_trusted for each in found)
        without, _ = mean_and_std(None if each is None else each == 0.0 for each in rejected)
        ate_m, ate_std_m = mean_and_std(each.ate_m for each in found)
        figures = ate_m, ate_std_m, growth, *mean_and_std(rejected), trusted, without
        yield KernelRow(kind, share, kernel, len(found), *figures)


def _growth(ate_m: float | None, clean_m: float | None) -> float | None:
    """Relative increase of an ATE; None if the ATE without injected loops is 0, or if either of the two [m] is None."""
    return None if ate_m is None or not clean_m else ate_m / clean_m - 1.0


def draw_kernels(rows: Sequence[KernelRow], path: Path) -> None:
    """Draw the ATE and the share of rejected true loops against the share of injected loops, as PNG or SVG.

    A figure that is None is not drawn.
    """

    def curve(kind: str, kernel: str, figure: str, spread: str) -> Curve:
        mine = [row for row in rows if (row.kind, row.kernel) == (kind, kernel)]
        points = [(row.share, getattr(row, figure), getattr(row, spread)) for row in mine]
        return [(x, y, half) for x, y, half in np.array(points, float).tolist()]  # None becomes NaN

    def curves(kind: str, figure: str, spread: str) -> dict[str, Curve]:
        return {kernel: curve(kind, kernel, figure, spread) for kernel in KERNELS}

    figures = ("ate_m", "ate_std_m"), ("true_rejected", "true_rejected_std")
    panels = [[(f"{kind} false loops", curves(kind, *names)) for kind in KINDS] for names in figures]
    draw_panels(panels, ("share of injected loops", ("ATE [m]", "true loops rejected")), path)
