"""The suites that are ready to use. LEXIS keeps their limits with room to spare; `Suite.with_limits` sets others."""

from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType

import numpy as np

from sim.errors import SimError
from sim.faults import parse_fault
from sim.harness.scenario import Scenario
from sim.harness.world_tests import FEATURES_FRAME_RATE_HZ, HOUSE_SEEDS
from sim.suites.checks import Check
from sim.suites.laws import LAWS
from sim.suites.suite import Suite, SuitePart, claims
from worlds.presets import sample_house
from worlds.valid_names import did_you_mean
from worlds.variant import in_light, variant

OPENNESS = (0.0, 0.25, 0.5, 0.75, 1.0)
"""Values of openness of the suite `open-plan`; each house occurs with all of them."""
_FAULTS = ("dropped:0.2", "frozen:0.05,burst=4", "late", "out-of-order", "stamp-jitter", "kidnap:20,skip_s=5")
_LENGTH_M, _LONG_M = 80.0, 400.0
_BY_DAY = 0.5
"""Probability of daylight in the suite `images`."""


def _seed(rng: np.random.Generator) -> int:
    return int(rng.integers(HOUSE_SEEDS))


def _scenario(rng: np.random.Generator, rooms: int = 5, preset: str = "home", storeys: int | None = None) -> Scenario:
    """A walk on features through a house of a preset."""
    seed = _seed(rng)
    house = sample_house(preset, seed, rooms=rooms, storeys=storeys)
    return Scenario(house=house, seed=seed, length_m=_LENGTH_M, frame_rate_hz=FEATURES_FRAME_RATE_HZ, fidelity="features")


def small_home(rng: np.random.Generator, number: int) -> Scenario:
    """A home of one storey."""
    return _scenario(rng, rooms=int(rng.integers(3, 6)), storeys=1)


def open_plan(rng: np.random.Generator, number: int) -> Scenario:
    """A home with one of the values of `OPENNESS`; successive numbers give the same home with the next value."""
    seed = _seed(rng)
    spec = sample_house("home", seed, rooms=5, storeys=1, openness=0.0)
    house = variant(spec, openness=OPENNESS[number % len(OPENNESS)])
    return Scenario(house=house, seed=seed, length_m=_LENGTH_M, frame_rate_hz=FEATURES_FRAME_RATE_HZ, fidelity="features")


def twins(rng: np.random.Generator, number: int) -> Scenario:
    """An office of one or two storeys, most of whose rooms have twins that look alike."""
    storeys = int(rng.integers(1, 3))
    return replace(_scenario(rng, rooms=8, preset="uh2-office", storeys=storeys), length_m=120.0)


def stairs(rng: np.random.Generator, number: int) -> Scenario:
    """A home of two or three storeys."""
    storeys = int(rng.integers(2, 4))
    return replace(_scenario(rng, rooms=3 * storeys, storeys=storeys), length_m=60.0 * storeys)


def revisits(rng: np.random.Generator, number: int) -> Scenario:
    """A home whose rooms are all visited twice, in opposite directions, with odometry that drifts much."""
    return replace(_scenario(rng, rooms=4, storeys=1), tour_kind="both ways", length_m=None, odometry="degraded")


def faulty(rng: np.random.Generator, number: int) -> Scenario:
    """A home with one fault of the stream, or with odometry whose covariances are four times too small."""
    plain = _scenario(rng, rooms=4, storeys=1)
    kind = int(rng.integers(len(_FAULTS) + 1))
    return (
        replace(plain, overconfidence=4.0) if kind == len(_FAULTS) else replace(plain, faults=(parse_fault(_FAULTS[kind]),))
    )


def long_walk(rng: np.random.Generator, number: int) -> Scenario:
    """A long walk through a home, up and down through all rooms."""
    return replace(_scenario(rng, rooms=8), length_m=_LONG_M, tour_kind="both ways")


def images(rng: np.random.Generator, number: int) -> Scenario:
    """A short walk on rendered images through two rooms, by day or in the evening."""
    seed = _seed(rng)
    spec = sample_house("home", seed, rooms=2, storeys=1)
    house = in_light(spec, "day" if rng.random() < _BY_DAY else "evening")
    return Scenario(house=house, seed=seed, length_m=30.0)


def _laws(*names: str) -> tuple[Check, ...]:
    return tuple(LAWS[name] for name in names)


_EXACT = _laws("same run twice", "origin of the odometry", "zero of the clock", "order of the room names")
_MAP = ("floors.accuracy >= 0.95", "floors.count_error == 0", "coverage.path_covered >= 0.9")

HOMES = SuitePart(
    "homes",
    "Homes of one storey and three to five rooms. LEXIS does well there, so most laws are checked in them.",
    small_home,
    (
        *claims(
            0.9, "labels.accuracy >= 0.6", "rooms.pq >= 0.2", "loops.precision >= 0.9", "trajectory.ate_m <= 0.15", *_MAP
        ),
        *claims(0.7, "labels.accuracy >= 0.72", "labels.accuracy_graded >= 0.8", "rooms.pq >= 0.35"),
        *claims(0.7, "loops.recall >= 0.6", "trajectory.ate_m <= 0.09"),
        *_EXACT,
        *_laws(
            "false loop closures",
            "a pause",
            "mirrored house",
            "rotated house",
            "other furniture",
            "no drift",
            "more frames",
            "second lap",
        ),
    ),
    n=12,
)
OPEN_PLAN = SuitePart(
    "open-plan",
    "Homes whose inner walls are opened step by step, from closed rooms to one space. Graded accuracy allows the labels of "
    "both sides near an open boundary.",
    open_plan,
    (
        *claims(0.7, "labels.accuracy_graded >= 0.75", "labels.accuracy >= 0.62", "rooms.pq >= 0.2"),
        *claims(0.9, "trajectory.ate_m <= 0.15"),
    ),
    n=60,
    group=len(OPENNESS),
)
TWINS = SuitePart(
    "twins",
    "Offices with rooms that look alike, some of them above one another. False loop closures must not bend the map.",
    twins,
    (*claims(0.9, "loops.precision >= 0.75", "trajectory.ate_m <= 0.16", *_MAP), *claims(0.7, "rooms.pq >= 0.4")),
    n=20,
)
STAIRS = SuitePart(
    "stairs",
    "Homes of two and three storeys. Floors have to be told apart, and no room may span two of them.",
    stairs,
    (
        *claims(0.9, "labels.accuracy >= 0.8", "rooms.pq >= 0.5", "trajectory.ate_m <= 0.18", *_MAP),
        *claims(0.7, "rooms.pq >= 0.6", "loops.recall >= 0.6"),
        *_laws("same run twice", "origin of the odometry", "one more storey"),
    ),
    n=20,
)
REVISITS = SuitePart(
    "revisits",
    "Homes that are walked through in both directions with odometry that drifts much. Loop closures have to mend the drift.",
    revisits,
    (
        *claims(0.9, "trajectory.ate_m <= 0.25", "loops.recall >= 0.5", "loops.precision >= 0.9", "labels.accuracy >= 0.7"),
        *claims(0.7, "trajectory.ate_m <= 0.17", "loops.recall >= 0.7"),
    ),
    n=20,
)
LANGUAGE = SuitePart(
    "language",
    "Homes with other room names: in another order, or with names of rooms that no house has.",
    small_home,
    _laws("order of the room names", "irrelevant room names"),
    n=20,
)
FAULTS = SuitePart(
    "faults",
    "Homes with one fault each: lost, frozen, late, swapped or wrongly stamped frames, a robot that is carried away, or "
    "covariances that are too small.",
    faulty,
    (*claims(0.8, "labels.accuracy >= 0.7", "rooms.pq >= 0.3", "coverage.path_covered >= 0.85"),
     *claims(0.4, "trajectory.ate_m <= 0.12")),
    n=28,
)  # fmt: skip
LONG = SuitePart(
    "long",
    "Walks of 400 m through homes of eight rooms and more, up and down. The map must not get worse with time.",
    long_walk,
    claims(0.9, "labels.accuracy >= 0.8", "rooms.pq >= 0.5", "trajectory.ate_m <= 0.12", "loops.precision >= 0.9", *_MAP),
    n=6,
)
IMAGES = SuitePart(
    "images",
    "Short walks through two rooms on rendered images, whose plans a robot drives.",
    images,
    (
        *claims(0.8, "labels.accuracy >= 0.65", "rooms.pq >= 0.25", "planning.success >= 0.8"),
        *claims(0.9, "loops.precision >= 0.9", "loops.recall >= 0.5", "trajectory.ate_m <= 0.1", *_MAP),
        *_laws("origin of the odometry", "repainted house", "daylight"),
    ),
    n=6,
    on_images=True,
)


def _first(part: SuitePart, n: int) -> SuitePart:
    return replace(part, n=n)


SUITES: Mapping[str, Suite] = MappingProxyType(
    {
        suite.name: suite
        for suite in (
            Suite(
                "pr",
                "Some scenarios of every other suite but `long`, for tests of each change.",
                (
                    *(_first(HOMES, 10), _first(OPEN_PLAN, 20), _first(TWINS, 12), _first(STAIRS, 10), _first(REVISITS, 14)),
                    *(_first(LANGUAGE, 6), _first(FAULTS, 20), _first(IMAGES, 4)),
                ),
            ),
            *(
                Suite(part.name, part.about, (part,))
                for part in (OPEN_PLAN, HOMES, TWINS, STAIRS, REVISITS, LANGUAGE, FAULTS, LONG, IMAGES)
            ),
        )
    }
)
"""All suites by name."""


def suite_named(suite: Suite | str) -> Suite:
    """Return the suite of this name, or the suite itself. Raises `SimError` for an unknown name."""
    if isinstance(suite, Suite):
        return suite
    if suite not in SUITES:
        raise SimError(f"unknown suite {suite!r:.60}{did_you_mean(suite, SUITES)}; valid: {', '.join(SUITES)}")
    return SUITES[suite]
