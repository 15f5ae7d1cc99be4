"""`Reduction`: the result of a search for the smallest scenario that fails in the same way."""

from dataclasses import dataclass
from typing import Literal

from sim.fidelity import Fidelity
from sim.harness.scenario import Scenario
from sim.harness.shrinking.failure_signature import Signature
from sim.harness.shrinking.scenario_size import ScenarioSize, size
from sim.wording import counted

Ending = Literal["smallest", "deadline", "interrupted"]
"""Why a search ended: no step led to a smaller failure, time was up, or the user interrupted it."""
CandidateOutcome = Literal["fails", "passes", "unavoidable", "reference fails", "fails differently", "cannot run", "invalid"]
"""What a candidate does. Three of them fail in the way of the original, but do not count: "unavoidable", because a good SLAM
fails there, too; "reference fails"; and "fails differently", for example by errors of another kind. See `Signature`."""


@dataclass(frozen=True, eq=False)
class Change:
    """A scenario, and the name of the step that made it from a larger one."""

    step: str
    scenario: Scenario


@dataclass(frozen=True, eq=False)
class Reduction:
    """The result of a search: the smallest failing scenario that was found, and how it was found."""

    original: Scenario
    """The failing scenario, with all rooms, furniture and windows of its house listed."""
    scenario: Scenario
    """The smallest scenario that fails with the same signature."""
    signature: Signature
    accepted: tuple[Change, ...]
    """The failing scenarios that the search found, from large to small; the last is `scenario`. Empty if the search found
    none."""
    passing: tuple[Change, ...]
    """Scenarios one step smaller than `scenario` that were run and did not fail, in the order of the steps. If the search
    ended on features, these scenarios were run on features, too."""
    last_passing: tuple[Scenario, Change] | None
    """The last run that passed: the failing scenario from which its candidate was made, and the candidate. None if no
    candidate passed."""
    tried: int
    """Number of candidates that were tried; equal candidates count once."""
    unavoidable: int
    """Number of these candidates that do not count, because a good SLAM fails there, too."""
    of_reference: int
    """Number of these candidates that do not count, because the reference fails there, too."""
    different: int
    """Number of these candidates that do not count, because they fail in another way."""
    ended: Ending
    """Why the search ended."""
    searched_on: Fidelity
    """Fidelity of the runs with which the search began. It may be "features" although the original has images."""
    ended_on: Fidelity
    """Fidelity of the runs that found the smallest scenario. If the search began on features, and the smallest scenario that
    it found does not fail on images, it goes on with images."""
    confirmed: bool
    """Whether `scenario` was run with the fidelity of the original, and failed."""
    on_features: CandidateOutcome | None = None
    """Outcome of the original with fidelity "features", such as "cannot run" for a program; None if this was not tried."""

    @property
    def sizes(self) -> tuple[ScenarioSize, ScenarioSize]:
        """Sizes of the original and of the smallest scenario."""
        return size(self.original), size(self.scenario)

    @property
    def note(self) -> str:
        """How many candidates and steps the search took, why it ended, and on what fidelity, in one or two sentences."""
        why = {
            "smallest": "no single step makes it smaller",
            "deadline": "time was up, so a smaller one may exist",
            "interrupted": "the search was interrupted, so a smaller one may exist",
        }[self.ended]
        how = f"{counted(self.tried, 'candidate')}, {counted(len(self.accepted), 'step')}; {why}."
        if self.unavoidable:
            how += f" {counted(self.unavoidable, 'candidate')} did not count, because a good SLAM fails there, too."
        if self.of_reference:
            how += f" {counted(self.of_reference, 'candidate')} did not count, because the reference fails there, too."
        if self.different:
            how += f" {counted(self.different, 'candidate')} did not count, because the SLAM fails there in another way."
        if self.original.fidelity != "render":
            return how
        if self.searched_on == "render":
            reason = {
                None: "nothing was run on feature fidelity",
                "cannot run": "the SLAM cannot run on feature fidelity",
                "unavoidable": "a good SLAM fails on feature fidelity, too",
                "fails": "no smaller scenario was found that fails on feature fidelity and on images",
            }.get(self.on_features, "the failure does not exist on feature fidelity")
            return f"{how} The search ran on rendered images, because {reason}."
        if self.ended_on == "render":
            return f"{how} The search began on feature fidelity, and went on with rendered images."
        confirmed = (
            "the result was confirmed on rendered images" if self.confirmed else "nothing was confirmed on images yet"
        )
        return f"{how} The search ran on feature fidelity, and {confirmed}."
