"""The laws that hold for any SLAM: changes of a run that must not matter, or that may only help.

Laws of the first kind (`SameClaims`) change the stream of observations and compare the claims frame by frame. They are exact
where the SLAM has no reason to notice the change. Laws of the second kind (`SimilarFigures`) change the house or the tour,
so the frames differ and only figures can be compared. Their tolerances allow for the differences between two tours.
"""

from collections.abc import Mapping
from dataclasses import replace

from sim.harness.parts import house_spec, tour_config
from sim.harness.scenario import Scenario
from sim.suites.checks import SameClaims, SimilarFigures
from sim.suites.stream_changes import (
    FalseLoops,
    MoreNames,
    MovedOrigin,
    Nothing,
    OtherClock,
    Pause,
    PermutedNames,
)
from worlds.variant import in_light, variant

_NEUTRAL = (("labels.accuracy", 0.2), ("floors.accuracy", 0.1), ("trajectory.ate_m", 0.15))
"""Tolerances for a change that makes the scenario neither easier nor harder."""
_OTHER_SEED = 77


def mirrored(scenario: Scenario) -> Scenario:
    """The scenario in the mirrored house."""
    return replace(scenario, house=variant(house_spec(scenario), mirror=True))


def rotated(scenario: Scenario) -> Scenario:
    """The scenario in the house rotated by a quarter turn."""
    return replace(scenario, house=variant(house_spec(scenario), rotate=1))


def repainted(scenario: Scenario) -> Scenario:
    """The scenario in the house with other colours and materials."""
    return replace(scenario, house=variant(house_spec(scenario), repaint=_OTHER_SEED))


def refurnished(scenario: Scenario) -> Scenario:
    """The scenario in the house with other furniture, windows and colours, in the same rooms."""
    return replace(scenario, house=house_spec(scenario).model_copy(update={"seed": _OTHER_SEED}))


def taller(scenario: Scenario) -> Scenario:
    """The scenario in the house with one more storey; the tour has its usual length in the taller house."""
    return replace(scenario, house=variant(house_spec(scenario), add_storey=True), length_m=None)


def in_daylight(scenario: Scenario) -> Scenario:
    """The scenario in the house by daylight."""
    return replace(scenario, house=in_light(house_spec(scenario), "day"))


def without_drift(scenario: Scenario) -> Scenario:
    """The scenario with odometry that has no error."""
    return replace(scenario, odometry="perfect", overconfidence=1.0)


def with_more_frames(scenario: Scenario) -> Scenario:
    """The scenario with twice as many frames per second on the same tour."""
    return replace(scenario, frame_rate_hz=2.0 * scenario.frame_rate_hz)


def twice_as_long(scenario: Scenario) -> Scenario:
    """The scenario with a tour of twice the length, which visits the same rooms again. It needs a requested length."""
    length_m = tour_config(scenario).length_m
    return replace(scenario, length_m=None if length_m is None else 2.0 * length_m)


LAWS: Mapping[str, SameClaims | SimilarFigures] = {
    law.name: law
    for law in (
        SameClaims("same run twice", "Two runs on the same observations give the same claims.", Nothing()),
        SameClaims(
            "origin of the odometry",
            "The claims do not depend on where the odometry frame lies, nor on its heading. Tolerance: rounding.",
            MovedOrigin(),
        ),
        SameClaims(
            "zero of the clock",
            "The claims do not depend on when the clock started. Tolerance: rounding of time differences.",
            OtherClock(),
        ),
        SameClaims(
            "order of the room names",
            "The claims do not depend on the order of the room names. Tolerance: none, ties are not expected.",
            PermutedNames(),
        ),
        SameClaims(
            "irrelevant room names",
            "Names of rooms that the house does not have change few labels: an image may resemble such a room most.",
            MoreNames(),
            least=0.9,
            position_m=0.1,
            rotation_rad=0.1,
            rate=0.8,
        ),
        SameClaims(
            "a pause",
            "Standing still changes little. Times between visits grow, so other revisits may count as old enough.",
            Pause(),
            least=0.9,
            position_m=0.2,
            rotation_rad=0.1,
            rate=0.9,
        ),
        SameClaims(
            "false loop closures",
            "Loop closures that are 2 m wrong change little, because a robust SLAM gives them little weight.",
            FalseLoops(),
            least=0.95,
            position_m=0.25,
            rotation_rad=0.1,
            rate=0.9,
            compare_loops=False,
        ),
        SimilarFigures(
            "mirrored house",
            "In the mirrored house the figures are similar. The tour is planned anew, so single rooms may differ.",
            mirrored,
            _NEUTRAL,
        ),
        SimilarFigures(
            "rotated house",
            "In the house rotated by a quarter turn the figures are similar. The tour is planned anew.",
            rotated,
            _NEUTRAL,
        ),
        SimilarFigures(
            "repainted house",
            "With other colours and materials, labels stay similar. The encoder knows some colours better than others.",
            repainted,
            _NEUTRAL,
        ),
        SimilarFigures(
            "other furniture",
            "With other furniture, labels stay similar. Furniture is what tells rooms apart, so the tolerance is wide.",
            refurnished,
            (("labels.accuracy", 0.3), ("floors.accuracy", 0.1), ("trajectory.ate_m", 0.15)),
        ),
        SimilarFigures(
            "one more storey",
            "With one more storey on top, labels and floors are hardly worse. The new rooms have furniture of their own.",
            taller,
            (("labels.accuracy", 0.25), ("floors.accuracy", 0.1)),
            both_ways=False,
        ),
        SimilarFigures(
            "daylight",
            "By daylight, labels are not worse than in the dark.",
            in_daylight,
            (("labels.accuracy", 0.1), ("trajectory.ate_m", 0.1)),
            both_ways=False,
        ),
        SimilarFigures(
            "no drift",
            "With odometry that has no error, the trajectory is not worse. Wrong loop closures may still bend it a little.",
            without_drift,
            (("trajectory.ate_m", 0.02), ("labels.accuracy", 0.1)),
            both_ways=False,
            rate=0.9,
        ),
        SimilarFigures(
            "more frames",
            "Twice the frames per second on the same tour give similar figures. Keyframes fall on other places.",
            with_more_frames,
            (("labels.accuracy", 0.15), ("floors.accuracy", 0.1), ("trajectory.ate_m", 0.15)),
        ),
        SimilarFigures(
            "second lap",
            "A tour of twice the length does not make the map worse: it visits the same rooms again.",
            twice_as_long,
            (("labels.accuracy", 0.15), ("rooms.pq", 0.25), ("trajectory.ate_m", 0.15)),
            both_ways=False,
        ),
    )
}
"""All laws by name."""
