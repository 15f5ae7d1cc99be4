"""Mixed scenarios in which planted bugs show: houses of all presets, all kinds of tours and odometry, and many faults.

All scenarios have the fidelity "features" and few frames per second, so that a run takes well under a second.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Any

import numpy as np

from lexis.errors import LexisError
from sim.bench.planted_bugs import BUGS, MENDED, planted
from sim.errors import SimError
from sim.faults import parse_fault
from sim.fidelity import ORACLE
from sim.harness.scenario import Scenario
from sim.harness.shrinking.failure_test import CRASH, FailureTest
from sim.harness.world_tests import HOUSE_SEEDS
from sim.odometry.config import ODOMETRY_PRESETS
from sim.tours.config import TOUR_KINDS
from sim.tours.sway import SWAYS
from worlds.errors import WorldsError
from worlds.presets import PRESETS, sample_house

_DRAWS = 500
"""Largest number of scenarios that are drawn in search of a failing scenario."""
_FRAME_RATE_HZ = 2.0
_FEWEST_ROOMS = 4
_LENGTHS_M = (40.0, 120.0)
_HALF = 0.5
"""Probability that a setting keeps its plain value. It applies separately to openness, storeys, length and kind of the tour,
start manoeuvre and overconfidence."""
_FAULTS = (
    "dropped:0.1",
    "frozen:0.05,burst=4",
    "duplicated",
    "late",
    "out-of-order",
    "stamp-jitter",
    "odometry-jump:10",
    "odometry-freeze:at_s=8,for_s=3",
    "odometry-nan:0.05",
    "kidnap:15,skip_s=6",
    "moved-furniture",
)


@dataclass(frozen=True)
class Family:
    """A planted bug, the failure by which it shows, and what a scenario needs so that the bug can show."""

    bug: str
    """A key of `BUGS`."""
    fails: str
    """The condition for a run to count as failing, as text for `FailureTest.parse`, such as "labels.accuracy < 0.9"."""
    rooms: int
    """Least number of rooms in which the bug can show."""
    openness: float | None = None
    storeys: int | None = None
    settings: Mapping[str, Any] = field(default_factory=lambda: MappingProxyType({}))
    """Values of fields of the scenario; all other fields are drawn at random."""

    def test(self) -> FailureTest:
        """Return the test that runs the planted bug on a scenario and decides whether the run fails."""
        return FailureTest.parse(self.fails, planted(BUGS[self.bug]))


def _faulty(text: str) -> Mapping[str, Any]:
    return MappingProxyType({"faults": (parse_fault(text),)})


FAMILIES = (
    Family("open plan", "labels.accuracy < 0.9", 2, openness=0.8),
    Family("small rooms", "labels.accuracy < 0.98", 2),
    Family("corners", "labels.accuracy < 0.9", 2),
    Family("clutter", "labels.accuracy < 0.9", 2),
    Family("floors", "floors.accuracy < 0.9", 3, storeys=2),
    Family("third floor", "floors.accuracy < 0.9", 4, storeys=3),
    Family("ring", "rooms.merges > 0", 3),
    Family("twins", "rooms.merges > 0", 2),
    Family("revisits", "rooms.splits > 0", 2),
    Family("drift", "trajectory.ate_m > 0.05", 1, settings=MappingProxyType({"odometry": "degraded"})),
    Family("wrong side", "trajectory.ate_m > 1.01 * trajectory.ate_odometry_m", 1),
    Family("kidnap", "trajectory.ate_m > 0.3", 1, settings=_faulty("kidnap:10,skip_s=8")),
    Family("gaps", "trajectory.ate_m > 0.3", 1, settings=_faulty("dropped:0.3,burst=5")),
    Family("long walks", "trajectory.ate_m > 0.3", 1),
    Family("gait", "trajectory.ate_m > 0.02", 1, settings=MappingProxyType({"sway": "hand-held"})),
    Family("wet rooms", CRASH, 1),
    Family("nan poses", CRASH, 1, settings=_faulty("odometry-nan:0.1")),
)
"""The families of failing scenarios, one for each planted bug."""


def failing_scenario(family: Family, seed: int, number: int, most_rooms: int) -> Scenario:
    """Draw scenarios until a scenario fails with the family's bug, but not without the bug; return that scenario.

    Its house has at most `most_rooms` rooms, to which corridors, halls and stairs are added.

    The same arguments always give the same scenario. Raises `SimError` if none of many scenarios fails.
    """
    rng = np.random.default_rng([seed, number])
    test = family.test()
    for _ in range(_DRAWS):
        try:
            scenario = _drawn(family, most_rooms, rng)
            if test(scenario) is not None and replace(test, runner=planted(BUGS[MENDED]))(scenario) is None:
                return scenario
        except (SimError, WorldsError, LexisError):  # a walk too short for the house, or no room for so many storeys
            continue
    raise SimError(
        f"scenario {number}: none of {_DRAWS} drawn scenarios of up to {most_rooms} rooms fails by {family.bug!r}; "
        "valid: more rooms, or another seed"
    )


def _drawn(family: Family, most_rooms: int, rng: np.random.Generator) -> Scenario:
    """Draw a scenario with the settings that the family needs; all other settings are random."""
    house = sample_house(
        PRESETS[rng.integers(len(PRESETS))],
        int(rng.integers(HOUSE_SEEDS)),
        openness=family.openness if rng.random() < _HALF or family.openness else round(float(rng.random()), 2),
        rooms=int(rng.integers(min(_FEWEST_ROOMS, most_rooms), most_rooms + 1)),
        storeys=family.storeys or (None if rng.random() < _HALF else int(rng.integers(1, 3))),
    )
    faults = [parse_fault(_FAULTS[k]) for k in rng.permutation(len(_FAULTS))[: rng.integers(4)]]
    drawn = Scenario(
        house=house,
        seed=int(rng.integers(HOUSE_SEEDS)),
        length_m=None if rng.random() < _HALF else float(round(rng.uniform(*_LENGTHS_M))),
        tour_kind=TOUR_KINDS[rng.integers(len(TOUR_KINDS))] if rng.random() < _HALF else "rooms",
        frame_rate_hz=_FRAME_RATE_HZ,
        sway=SWAYS[rng.integers(len(SWAYS))],
        start_manoeuvre=bool(rng.random() < _HALF),
        odometry=list(ODOMETRY_PRESETS)[rng.integers(len(ODOMETRY_PRESETS))],
        overconfidence=1.0 if rng.random() < _HALF else 4.0,
        fidelity="features",
        encoder=ORACLE,
    )
    wanted = dict(family.settings)
    return replace(drawn, **wanted | {"faults": (*wanted.get("faults", ()), *faults)})
