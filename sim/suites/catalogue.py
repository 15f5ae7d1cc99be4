"""The suites that are ready to use. LEXIS passes them; `Suite.with_limits` sets other limits."""

from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType

import numpy as np

from sim.errors import SimError
from sim.faults import parse_fault
from sim.harness.claims import Claim
from sim.harness.scenario import Scenario
from sim.harness.world_tests import FEATURES_FRAME_RATE_HZ, HOUSE_SEEDS
from sim.suites.checks import Check
from sim.suites.consistency import CONSISTENCY, LEVEL_FLOORS, Consistent
from sim.suites.laws import LAWS
from sim.suites.plans import plans_can_be_walked
from sim.suites.suite import Suite, SuitePart, claims
from sim.wording import class_of
from worlds.presets import sample_house
from worlds.spec import HouseSpec
from worlds.valid_names import did_you_mean
from worlds.variant import in_light, variant

OPENNESS = (0.0, 0.25, 0.5, 0.75, 1.0)
"""Values of openness in the suite `open-plan`; each house occurs with all of these values."""
_FAULTS = ("dropped:0.2", "frozen:0.05,burst=4", "late", "out-of-order", "stamp-jitter", "kidnap:20,skip_s=5")
_LENGTH_M, _LONG_M = 80.0, 400.0
_BY_DAY = 0.5
"""Probability of daylight in the suite `images`."""


def _seed(rng: np.random.Generator) -> int:
    return int(rng.integers(HOUSE_SEEDS))


def _on_features(house: HouseSpec, seed: int) -> Scenario:
    """Return a walk on features through a house."""
    return Scenario(house=house, seed=seed, length_m=_LENGTH_M, frame_rate_hz=FEATURES_FRAME_RATE_HZ, fidelity="features")


def _scenario(rng: np.random.Generator, rooms: int, preset: str = "home", storeys: int | None = None) -> Scenario:
    """Draw a walk on features through a house of a preset."""
    seed = _seed(rng)
    return _on_features(sample_house(preset, seed, rooms=rooms, storeys=storeys), seed)


def small_home(rng: np.random.Generator, number: int) -> Scenario:
    """Draw a home of one storey."""
    return _scenario(rng, rooms=int(rng.integers(3, 6)), storeys=1)


def open_plan(rng: np.random.Generator, number: int) -> Scenario:
    """Draw a home with one of the values of `OPENNESS`; successive numbers give the same home with the next value."""
    seed = _seed(rng)
    spec = sample_house("home", seed, rooms=5, storeys=1, openness=0.0)
    return _on_features(variant(spec, openness=OPENNESS[number % len(OPENNESS)]), seed)


def twins(rng: np.random.Generator, number: int) -> Scenario:
    """Draw an office of one or two storeys in which most rooms look like another room."""
    storeys = int(rng.integers(1, 3))
    return replace(_scenario(rng, rooms=8, preset="uh2-office", storeys=storeys), length_m=120.0)


def stairs(rng: np.random.Generator, number: int) -> Scenario:
    """Draw a home of two or three storeys."""
    storeys = int(rng.integers(2, 4))
    return replace(_scenario(rng, rooms=3 * storeys, storeys=storeys), length_m=60.0 * storeys)


def revisits(rng: np.random.Generator, number: int) -> Scenario:
    """Draw a home whose rooms are all visited twice, in opposite directions, with odometry that drifts much."""
    return replace(_scenario(rng, rooms=4, storeys=1), tour_kind="both ways", length_m=None, odometry="degraded")


def without_drift(rng: np.random.Generator, number: int) -> Scenario:
    """Draw a home of one or two storeys, with odometry that has no error."""
    storeys = 1 + number % 2
    return replace(_scenario(rng, rooms=3 * storeys + 1, storeys=storeys), odometry="perfect")


def faulty(rng: np.random.Generator, number: int) -> Scenario:
    """Draw a home with one fault of the stream, or with odometry whose covariances are four times too small."""
    plain = _scenario(rng, rooms=4, storeys=1)
    kind = int(rng.integers(len(_FAULTS) + 1))
    return (
        replace(plain, overconfidence=4.0) if kind == len(_FAULTS) else replace(plain, faults=(parse_fault(_FAULTS[kind]),))
    )


def long_walk(rng: np.random.Generator, number: int) -> Scenario:
    """Draw a long walk through a home, through all rooms in both directions."""
    return replace(_scenario(rng, rooms=8), length_m=_LONG_M, tour_kind="both ways")


def images(rng: np.random.Generator, number: int) -> Scenario:
    """Draw a short walk on rendered images through two rooms, by day or in the evening."""
    seed = _seed(rng)
    spec = sample_house("home", seed, rooms=2, storeys=1)
    house = in_light(spec, "day" if rng.random() < _BY_DAY else "evening")
    return Scenario(house=house, seed=seed, length_m=30.0)


def _laws(*names: str) -> tuple[Check, ...]:
    return tuple(LAWS[name] for name in names)


_EXACT = _laws(
    *("same run twice", "moved and rotated house", "axes of the body"),
    *("zero of the clock", "reused arrays", "steps in two parts", "similarities follow the images"),
    "order of the room names",
)
_FLOORS = ("floors.accuracy >= 0.95", "floors.count_error == 0")
_COVERED = "coverage.path_covered >= 0.99"
_THREE_MATCHES = "place_recognition.3.tp >= 0.9 * place_recognition.3.possible"


def _shares_of_odometry(ate: float, rpe_8m: float, rpe_24m: float) -> tuple[str, ...]:
    """Return claims that each error of the trajectory is at most the given share of the odometry's error."""
    return (
        f"trajectory.ate_m <= {ate} * trajectory.ate_odometry_m",
        f"trajectory.rpe_8m_m <= {rpe_8m} * trajectory.rpe_8m_odometry_m",
        f"trajectory.rpe_24m_m <= {rpe_24m} * trajectory.rpe_24m_odometry_m",
    )


def _labels(accuracy: float, graded: float, of_baseline: float, baseline: float) -> tuple[str, ...]:
    """Return claims about labels.

    `baseline` is the least accuracy before refinement, and `of_baseline` the least ratio of the accuracy to it.
    """
    return (
        f"labels.accuracy >= {accuracy}",
        f"labels.accuracy_graded >= {graded}",
        f"labels.accuracy >= {of_baseline} * labels.accuracy_baseline",
        f"labels.accuracy_baseline >= {baseline}",
    )


def _rooms(pq: float, ari: float) -> tuple[str, ...]:
    return f"rooms.pq >= {pq}", f"rooms.ari >= {ari}"


def _loops(recall: float, precision: float, of_possible: float) -> tuple[str, ...]:
    """Return claims about loops; `of_possible` is the least share of the possible revisits that place recognition finds."""
    return (
        f"loops.recall >= {recall}",
        f"loops.precision >= {precision}",
        f"place_recognition.1.tp >= {of_possible} * place_recognition.1.possible",
    )


PLANS = Consistent(
    "plans can be walked",
    "The SLAM finds a plan between any two of its labels. No step of a plan leads through a wall or furniture. At least "
    "half of the plans begin in a room that the SLAM labels like the start, and at least half end in one that it labels "
    "like the goal.",
    plans_can_be_walked,
    rate=0.9,
)
"""The law that plans are walkable, for houses of one storey. It has to hold only in 90 % of the scenarios, because a loop
closure that is slightly wrong may lead a step of a plan through the corner of a table."""
HOMES = SuitePart(
    "homes",
    "Homes of one storey and three to five rooms. LEXIS does well there, so most laws are checked in them.",
    small_home,
    (
        *CONSISTENCY,
        PLANS,
        *_EXACT,
        *_laws("a slip of the odometry", "slips are mended to the end", "false loop closures", "a pause"),
        *claims(
            0.9,
            *_labels(0.73, 0.86, 1.0, 0.6),
            *_rooms(0.36, 0.46),
            *_loops(0.78, 0.97, 0.7),
            *_FLOORS,
            _COVERED,
            _THREE_MATCHES,
        ),
        *claims(0.9, "trajectory.ate_m <= 0.12", *_shares_of_odometry(0.66, 0.91, 0.78)),
        *claims(0.5, *_labels(0.83, 0.93, 1.06, 0.7), *_rooms(0.6, 0.68), *_loops(0.93, 0.99, 0.95)),
        *claims(0.5, "trajectory.ate_m <= 0.083", *_shares_of_odometry(0.39, 0.73, 0.52)),
    ),
    n=12,
)
OPEN_PLAN = SuitePart(
    "open-plan",
    "Homes whose inner walls are opened step by step, from closed rooms to one space. Graded accuracy allows the labels of "
    "both sides near an open boundary.",
    open_plan,
    (
        *CONSISTENCY,
        *claims(
            0.9,
            *_labels(0.7, 0.82, 1.01, 0.55),
            *_rooms(0.34, 0.44),
            *_loops(0.7, 0.98, 0.8),
            *_FLOORS,
            _COVERED,
            _THREE_MATCHES,
        ),
        *claims(0.9, "trajectory.ate_m <= 0.13", *_shares_of_odometry(0.7, 0.92, 0.86)),
    ),
    n=60,
    group=len(OPENNESS),
)
TWINS = SuitePart(
    "twins",
    "Offices with rooms that look alike, some of them above one another. False loop closures must not bend the map.",
    twins,
    (
        *CONSISTENCY,
        *claims(
            0.9,
            *_labels(0.72, 0.72, 1.0, 0.66),
            *_rooms(0.52, 0.5),
            "loops.precision >= 0.95",
            *_FLOORS,
            _COVERED,
            _THREE_MATCHES,
        ),
        *claims(0.9, "trajectory.ate_m <= 0.2", *_shares_of_odometry(0.82, 0.955, 0.91)),
        *claims(0.5, *_labels(0.82, 0.825, 1.06, 0.74), *_rooms(0.7, 0.72), *_loops(0.82, 0.99, 0.9)),
        *claims(0.5, "trajectory.ate_m <= 0.122", *_shares_of_odometry(0.58, 0.875, 0.73)),
    ),
    n=20,
)
STAIRS = SuitePart(
    "stairs",
    "Homes of two and three storeys. Floors have to be told apart, and no room may span two of them.",
    stairs,
    (
        *CONSISTENCY,
        *_laws("same run twice", "moved and rotated house", "axes of the body", "a drift in height", "one more storey"),
        *claims(
            0.9,
            *_labels(0.82, 0.89, 1.06, 0.68),
            *_rooms(0.62, 0.72),
            *_loops(0.63, 0.96, 0.8),
            *_FLOORS,
            _COVERED,
            _THREE_MATCHES,
        ),
        *claims(0.9, "trajectory.ate_m <= 0.15", *_shares_of_odometry(0.63, 0.88, 0.8)),
        *claims(0.5, *_labels(0.885, 0.94, 1.1, 0.76), *_rooms(0.74, 0.81), *_loops(0.85, 0.99, 0.95)),
        *claims(0.5, "trajectory.ate_m <= 0.11", *_shares_of_odometry(0.46, 0.79, 0.63)),
    ),
    n=20,
)
REVISITS = SuitePart(
    "revisits",
    "Homes that are walked through in both directions with odometry that drifts much. Loop closures have to mend the drift.",
    revisits,
    (
        # While no loop is closed, the heights of this odometry may drift by more than "floors are level" tolerates.
        *(law for law in CONSISTENCY if law is not LEVEL_FLOORS),
        *_laws("a slip of the odometry", "slips that add up", "slips are mended to the end"),
        *claims(
            0.9,
            *_labels(0.77, 0.865, 1.01, 0.6),
            *_rooms(0.44, 0.6),
            *_loops(0.69, 0.98, 0.96),
            *_FLOORS,
            _COVERED,
            _THREE_MATCHES,
        ),
        *claims(0.9, "trajectory.ate_m <= 0.185", *_shares_of_odometry(0.42, 0.65, 0.54)),
        *claims(0.5, *_labels(0.87, 0.95, 1.07, 0.74), *_rooms(0.66, 0.77), *_loops(0.86, 0.99, 0.99)),
        *claims(0.5, "trajectory.ate_m <= 0.11", *_shares_of_odometry(0.25, 0.53, 0.37)),
    ),
    n=20,
)
NO_DRIFT = SuitePart(
    "no-drift",
    "Homes of one and two storeys in which the odometry has no error. Errors of the trajectory are then the SLAM's own "
    "doing, so their limits are tight.",
    without_drift,
    (
        *CONSISTENCY,
        *claims(0.9, *_labels(0.76, 0.86, 1.01, 0.6), *_rooms(0.4, 0.62), *_FLOORS, _COVERED, _THREE_MATCHES),
        *claims(0.9, "loops.recall >= 0.25", "loops.precision >= 0.98", "trajectory.ate_m <= 0.0022"),
        *claims(
            0.5,
            *_labels(0.84, 0.91, 1.07, 0.72),
            *_rooms(0.56, 0.75),
            *_loops(0.88, 0.995, 0.95),
            "trajectory.ate_m <= 0.0012",
        ),
    ),
    n=20,
)
LANGUAGE = SuitePart(
    "language",
    "Homes with other room names: in another order, in capitals, synonyms, or with names of rooms that no house has.",
    small_home,
    _laws("order of the room names", "room names in capitals", "synonyms of room names", "irrelevant room names"),
    n=20,
)
FAULTS = SuitePart(
    "faults",
    "Homes with one fault each: lost, frozen, late, swapped or wrongly stamped frames, a robot that is carried away, or "
    "covariances that are too small.",
    faulty,
    (
        *claims(0.9, *_labels(0.74, 0.85, 1.0, 0.6), *_rooms(0.38, 0.5), "loops.recall >= 0.32", "loops.precision >= 0.975"),
        *claims(0.9, "coverage.path_covered >= 0.94", *_FLOORS),
        *claims(0.5, *_labels(0.86, 0.945, 1.09, 0.74), *_rooms(0.65, 0.73), *_loops(0.91, 0.99, 0.95)),
        *claims(0.5, "trajectory.ate_m <= 0.095", *_shares_of_odometry(0.51, 0.79, 0.66)),
    ),
    n=28,
)
LONG = SuitePart(
    "long",
    "Walks of 400 m in both directions through homes of eight rooms and more. The map must not get worse with time.",
    long_walk,
    (
        *CONSISTENCY,
        *claims(
            0.9, "labels.accuracy >= 0.8", "rooms.pq >= 0.5", "loops.precision >= 0.9", *_FLOORS, _COVERED, _THREE_MATCHES
        ),
        *claims(0.9, "trajectory.ate_m <= 0.12", *_shares_of_odometry(0.5, 0.8, 0.6)),
    ),
    n=6,
)
IMAGES = SuitePart(
    "images",
    "Short walks through two rooms on rendered images, whose plans a robot drives.",
    images,
    (
        *CONSISTENCY,
        *claims(0.8, "planning.success >= 0.8"),
        *claims(0.9, "labels.accuracy >= 0.75", "labels.accuracy_baseline >= 0.63", "rooms.pq >= 0.58", *_FLOORS),
        *claims(0.9, "loops.recall >= 0.8", "loops.precision >= 0.95", _THREE_MATCHES, "coverage.path_covered >= 0.97"),
        *claims(0.9, "trajectory.ate_m <= 0.062", "trajectory.ate_m <= 0.72 * trajectory.ate_odometry_m"),
        *claims(0.5, "labels.accuracy >= 0.86", "rooms.pq >= 0.75", "loops.recall >= 0.92", "loops.precision >= 0.99"),
        *claims(0.5, "trajectory.ate_m <= 0.053", "trajectory.ate_m <= 0.52 * trajectory.ate_odometry_m"),
        *_laws("axes of the body, on images", "reused arrays", "jumbled images are not recognised"),
    ),
    n=8,
    on_images=True,
)


_MEANS = tuple(
    Claim.parse(text)
    for text in (
        *(*_labels(0.92, 0.97, 1.11, 0.825), *_rooms(0.785, 0.83), *_loops(0.925, 0.9965, 0.985)),
        *("loops.error_m <= 0.0605", "loops.error_rad <= 0.0141"),
        "place_recognition.1.precision >= 0.585",
        *("rooms.hydra_precision >= 0.926", "rooms.hydra_recall >= 0.914", "rooms.splits <= 0.26", "rooms.merges <= 0.59"),
        "floors.accuracy >= 0.9992",
    )
)
"""Claims about the means over all scenarios of the suite `pr`. Each limit is about one standard error worse than the mean of
LEXIS. No claim is about the trajectory: a few walks with large errors decide that mean, such as walks on which the robot is
carried away."""


class _Suites(dict[str, Suite]):
    """Suites by name. Another name raises `SimError` with a list of all names."""

    def __missing__(self, name: str) -> Suite:
        raise SimError(f"unknown suite {name!r:.60}{did_you_mean(name, self)}; valid: {', '.join(self)}")


SUITES: Mapping[str, Suite] = MappingProxyType(
    _Suites(
        (suite.name, suite)
        for suite in (
            Suite(
                "pr",
                "Some scenarios of every other suite but `long`, for tests of each change.",
                (
                    *(NO_DRIFT, REVISITS, STAIRS, HOMES, TWINS, replace(OPEN_PLAN, n=30)),
                    *(replace(LANGUAGE, n=6), replace(FAULTS, n=20), IMAGES),
                ),
                _MEANS,
            ),
            *(
                Suite(part.name, part.about, (part,))
                for part in (OPEN_PLAN, HOMES, TWINS, STAIRS, REVISITS, NO_DRIFT, LANGUAGE, FAULTS, LONG, IMAGES)
            ),
        )
    )
)
"""All suites by name. `SUITES[name]` raises `SimError` for an unknown name."""


def suite_named(suite: object) -> Suite:
    """Return the suite of this name, or the suite itself. Raises `SimError` for an unknown name and any other value."""
    if isinstance(suite, Suite):
        return suite
    if not isinstance(suite, str):
        raise SimError(f"suite is {class_of(suite)}; valid: a Suite, or the name of one: {', '.join(SUITES)}")
    return SUITES[suite]
