"""The laws that relate two runs of any SLAM: changes that must matter little, or that should do no harm.

- `SameEstimates` changes the stream of observations and compares the estimates frame by frame. Where the SLAM has no
  reason to notice the change, the tolerance is rounding, or 1 mm where an optimiser stops at a slightly different place.
  `SimilaritiesFollowImages` compares the similarities frame by frame, and `JumbledImagesAreNotRecognised` counts loops.
- `AfterChange` changes the stream, and examines the run on the changed stream alone.
- `NotWorse` changes the house, so that the frames differ and only figures can be compared. Its tolerances allow for the
  differences between two tours.

`consistency`, `staircases` and `plans` hold laws about a single run.
"""

from collections.abc import Mapping
from dataclasses import replace

from sim.harness.run_settings import house_spec
from sim.harness.scenario import Scenario
from sim.suites.checks import AfterChange, Check, NotWorse, SameEstimates
from sim.suites.consistency import LastLoopsFit
from sim.suites.false_loops import FalseLoops
from sim.suites.frame_changes import MovedOrigin, TurnedBody
from sim.suites.image_evidence import JumbledImagesAreNotRecognised, SimilaritiesFollowImages
from sim.suites.stream_changes import (
    CapitalLetters,
    HeightDrift,
    MoreNames,
    NoChange,
    OtherClock,
    Pause,
    PermutedNames,
    ReusedArrays,
    Slip,
    StepsInTwoParts,
    Synonyms,
)
from worlds.variant import variant

_SLIPS = Slip(first_s=15.0, every_s=15.0, shift_m=(0.4, -0.3, 0.0))
_MENDED = LastLoopsFit(end_m=5.0, most_m=0.045, ratio=1.4)
"""LEXIS kept within these limits in all of 87 runs."""


def taller(scenario: Scenario) -> Scenario:
    """Return the scenario in the same house with one more storey. No length is requested for the tour."""
    return replace(scenario, house=variant(house_spec(scenario), add_storey=True), length_m=None)


LAWS: Mapping[str, Check] = {
    law.name: law
    for law in (
        SameEstimates("same run twice", "Two runs on the same observations give the same estimates.", NoChange()),
        SameEstimates(
            "moved and rotated house",
            "The estimates do not depend on where the odometry frame lies, nor on its heading. Tolerance: rounding, "
            "and 1 mm because an optimiser stops when it has nearly converged.",
            MovedOrigin(),
            position_m=1e-3,
        ),
        SameEstimates(
            "zero of the clock",
            "The estimates are the same if stamps count from 1970. Tolerance: rounding of time differences.",
            OtherClock(),
        ),
        SameEstimates(
            "axes of the body",
            "The estimates do not depend on the axes of the body frame, such as those of an IMU. Tolerance: rounding, "
            "and 1 mm because an optimiser stops when it has nearly converged.",
            TurnedBody(),
            position_m=1e-3,
        ),
        SameEstimates(
            "axes of the body, on images",
            "The estimates on images hardly depend on the axes of the body frame. The last digits of positions do, and with "
            "them the results of RANSAC: in LEXIS, poses change by up to 3 mm and 2 mrad.",
            TurnedBody(),
            least=0.98,
            position_m=0.02,
            rotation_rad=0.01,
        ),
        SameEstimates(
            "reused arrays",
            "The caller may overwrite the arrays of an observation once it is processed, so a SLAM has to copy what it "
            "keeps. Tolerance: none.",
            ReusedArrays(),
        ),
        SameEstimates(
            "steps in two parts",
            "The estimates stay the same if the odometry reports the uncertainty of each step in two parts. Frames must be "
            "selected by motion, not by time or number. Tolerance: rounding.",
            StepsInTwoParts(),
        ),
        SimilaritiesFollowImages(),
        JumbledImagesAreNotRecognised(),
        SameEstimates(
            "order of the room names",
            "The estimates do not depend on the order of the room names. No tolerance, because ties are not expected.",
            PermutedNames(),
            needs=("labels",),
        ),
        SameEstimates(
            "irrelevant room names",
            "Names of rooms that the house lacks change few labels and rooms. A few images may resemble such a room most.",
            MoreNames(),
            needs=("labels",),
            least=0.97,
            position_m=0.05,
            rotation_rad=0.05,
        ),
        SameEstimates(
            "room names in capitals",
            "Capital letters change few labels. Some encoders tell them from small ones.",
            CapitalLetters(),
            needs=("labels",),
            least=0.97,
            position_m=0.05,
            rotation_rad=0.05,
            rate=0.9,
        ),
        SameEstimates(
            "synonyms of room names",
            "With synonyms of the room names most labels stay. Encoders know some names better than others.",
            Synonyms(),
            needs=("labels",),
            least=0.6,
            position_m=0.2,
            rotation_rad=0.1,
            rate=0.9,
            compares=("frames", "labels", "floors"),
        ),
        SameEstimates(
            "a slip of the odometry",
            "The odometry slips by 0.6 m and states the uncertainty, so loop closures mend most of it. Other frames may be "
            "selected.",
            Slip(),
            least=0.9,
            position_m=0.25,
            rotation_rad=0.1,
            rate=0.9,
            compares=("labels", "floors"),
            needs=("loops",),
        ),
        SameEstimates(
            "slips that add up",
            "The odometry slips by 0.5 m again and again, and states the uncertainty. Where loop closures mend the "
            "trajectory, labels and rooms follow from the mended poses. Other frames may be selected.",
            _SLIPS,
            least=0.8,
            position_m=0.5,
            rotation_rad=0.15,
            rate=0.8,
            compares=("labels", "rooms", "floors"),
            needs=("loops",),
            needs_poses=True,
        ),
        AfterChange(
            "slips are mended to the end",
            "The odometry slips by 0.5 m again and again, and states the uncertainty. The trajectory satisfies the trusted "
            f"loop closures of the last {_MENDED.end_m:g} m of the walk within {_MENDED.most_m} m, or within "
            f"{_MENDED.ratio} times the difference of the others; these are medians. An optimisation that stops too early "
            "leaves larger differences.",
            _SLIPS,
            _MENDED,
            rate=0.97,
        ),
        SameEstimates(
            "a drift in height",
            "The odometry rises by 1.5 cm/s on level floors, too. Floors are told by the stairs between them, so few frames "
            "change their floor.",
            HeightDrift(),
            least=0.95,
            rate=0.9,
            compares=("floors",),
            compares_poses=False,
        ),
        SameEstimates(
            "a pause",
            "Standing still changes little. Times between visits grow, so other revisits may count as old enough.",
            Pause(),
            least=0.97,
            position_m=0.02,
            rotation_rad=0.01,
            rate=0.9,
        ),
        SameEstimates(
            "false loop closures",
            "Loop closures that are 1 m wrong change little, because a robust SLAM gives them little weight.",
            FalseLoops(),
            least=0.95,
            position_m=0.25,
            rotation_rad=0.1,
            rate=0.9,
            compares=("frames", "labels", "rooms", "floors"),
        ),
        NotWorse(
            "one more storey",
            "With one more storey on top, floors are hardly worse. Their number is no reason to confuse them.",
            taller,
            (("floors.accuracy", 0.05),),
            rate=0.9,
        ),
    )
}
"""The laws that relate two runs, by name."""
