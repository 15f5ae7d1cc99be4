"""The search for the smallest scenario in which a pytest test of the user fails, with all that its page tells."""

from dataclasses import dataclass

from sim.harness.blame_table import BlameTable
from sim.harness.reducer import Reduction
from sim.harness.runner import Run
from sim.harness.scenario import Scenario


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
    """How many wrong frames have the most frequent kind of error, in both scenarios; empty for figures without kinds."""
    reduction: Reduction
    blamed: BlameTable
    """The changes that mend the failure in the smallest scenario, and the changes that do not."""
    reference: Run | None = None
    """The run of a SLAM with which the test passes in the smallest scenario; None if no such SLAM was named or used."""
    left_out: str = ""
    """Why the reference that the user named was not used, as a sentence; else empty."""
