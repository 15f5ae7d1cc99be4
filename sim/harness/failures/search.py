"""What the page of a failed pytest test tells besides its run: the search for the smallest scenario, and the reference."""

from dataclasses import dataclass

from sim.harness.failures.blame_table import BlameTable
from sim.harness.finished_run import Run
from sim.harness.scenario import Scenario
from sim.harness.shrinking.reduction import Reduction


@dataclass(frozen=True, eq=False)
class Reference:
    """The SLAM that the user named as one with which the test passes."""

    run: Run | None = None
    """Its run in the scenario of the failure; None if no such SLAM was named, or if it is not used."""
    left_out: str = ""
    """Why it is not used, as a sentence; else empty."""


NO_REFERENCE = Reference()


@dataclass(frozen=True, eq=False)
class Search:
    """The search for the smallest scenario in which a test fails."""

    original: Scenario
    """The scenario in which the failure was found."""
    found: str
    """What pytest said about the failure in the original scenario."""
    found_place: str
    """Where the original run first went wrong: room, time and kind of error; empty if it is not known."""
    kinds: str
    """In both scenarios, how many wrong frames have the kind of error that is most frequent in the smallest one; empty for
    figures without kinds."""
    reduction: Reduction
    blamed: BlameTable
    """The changes that mend the failure in the smallest scenario, and the changes that do not."""
