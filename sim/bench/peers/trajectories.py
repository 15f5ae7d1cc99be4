"""`lexis-sim bench table3`: trajectory errors of odometry and of LEXIS with each method of place recognition (Table III)."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

from lexis.config import Config, PlaceRecognitionConfig
from sim.bench.houses import for_seeds
from sim.bench.peers.side_by_side import run_side_by_side
from sim.bench.row_files import grouped, mean_and_std
from sim.fidelity import Fidelity
from sim.harness import Scenario, SlamUnderTest, evaluate
from sim.harness.adapters import Lexis, OdometryOnly
from sim.harness.adapters.true_stages import TrueStages
from sim.harness.world_tests import usual_rate_hz

PAPER_ATE_M: Mapping[str, Mapping[str, float]] = MappingProxyType(
    {
        "ORB-SLAM3": {"ori": 0.22, "home": 0.10},
        "VINS-Fusion": {"ori": 0.10, "home": 0.08},
        "LEXIS": {"ori": 0.16, "home": 0.10},
    }
)
"""Table III of the paper: absolute trajectory error by method and data set [m], in houses other than ours."""


def _proposing(method: PlaceRecognitionConfig) -> Callable[[Scenario], SlamUnderTest]:
    return lambda scenario: Lexis(scenario.encoder, Config(place_recognition=method))


def _with_true_loops(scenario: Scenario) -> SlamUnderTest:
    truth = TrueStages.of(scenario)
    return Lexis(scenario.encoder, place_recogniser=truth.propose, verifier=truth.verify)


METHODS: Mapping[str, Callable[[Scenario], SlamUnderTest]] = MappingProxyType(
    {
        "odometry": lambda scenario: OdometryOnly(),
        "LEXIS, by room": _proposing(PlaceRecognitionConfig(method="room")),
        "LEXIS, by similarity": _proposing(PlaceRecognitionConfig(method="similarity")),
        "LEXIS": _proposing(PlaceRecognitionConfig()),
        "LEXIS, true loops": _with_true_loops,
    }
)
"""The SLAM for a scenario, by the name of the method. The last one is told which keyframes show one place,
and the true relative poses of these keyframes."""


@dataclass(frozen=True)
class TrajectoryRow:
    """The trajectory of one method in one house."""

    preset: str
    seed: int
    method: str
    ate_m: float | None
    """Absolute trajectory error [m]; None if there are too few keyframes."""
    odometry_m: float | None
    """Absolute trajectory error of the odometry on the same walk [m]; None if there are too few keyframes."""


@dataclass(frozen=True)
class TrajectoryMean:
    """Absolute trajectory errors of one method, over the houses of one preset."""

    ate_m: float | None
    """Mean of the errors [m]. All figures are None if no house has them."""
    std_m: float | None
    """Standard deviation of the errors [m]."""
    ratio_to_odometry: float | None
    """Mean over the houses of the error, divided by that of the odometry on the same walk."""


def compare_trajectories(presets: Sequence[str], seeds: Sequence[int], fidelity: Fidelity) -> Iterator[TrajectoryRow]:
    """Let every method of `METHODS` follow the same walks, one for each preset and seed."""
    for preset in presets:
        for scenario in for_seeds(Scenario(preset=preset, fidelity=fidelity, frame_rate_hz=usual_rate_hz(fidelity)), seeds):
            slams = {name: slam(scenario) for name, slam in METHODS.items()}
            for name, finished in run_side_by_side(scenario, slams).items():
                errors = evaluate(finished).trajectory
                yield TrajectoryRow(preset, scenario.seed, name, errors.ate_m, errors.ate_odometry_m)


def means(rows: Sequence[TrajectoryRow]) -> dict[str, dict[str, TrajectoryMean]]:
    """Average over the houses that have the figures, by method and preset."""
    found: dict[str, dict[str, TrajectoryMean]] = {}
    for (method, preset), mine in grouped(rows, "method", "preset").items():
        share, _ = mean_and_std(row.ate_m / row.odometry_m for row in mine if row.ate_m is not None and row.odometry_m)
        found.setdefault(method, {})[preset] = TrajectoryMean(*mean_and_std(row.ate_m for row in mine), share)
    return found
