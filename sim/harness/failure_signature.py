"""Whether a run shows a failure, and which one: a claim about its figures is true, or the SLAM raises an exception."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

from sim.errors import SimError
from sim.harness.claims import Claim
from sim.harness.figures import evaluate
from sim.harness.planning import Trial, try_plans
from sim.harness.results import RunResult
from sim.harness.runner import Progress, Run
from sim.harness.scenario import Scenario
from worlds.errors import WorldsError

Runner = Callable[[Scenario, Progress | None], Run]
"""Runs the SLAM under test on a scenario."""
CRASH = "crash"
"""What `FailureTest.parse` reads as: the SLAM raises an exception."""


@dataclass(frozen=True)
class Signature:
    """What a failure is recognised by; two failures with the same signature count as the same."""

    kind: Literal["claim", "exception"]
    what: str
    """The claim that is true, or the name of the exception's type."""

    def __str__(self) -> str:
        return self.what if self.kind == "claim" else f"raises {self.what}"


@dataclass(frozen=True, eq=False)
class Observed:
    """A finished run with its figures, and the failure that it shows."""

    run: Run
    result: RunResult
    trials: tuple[Trial, ...]
    """Plans that were driven; only for claims about planning, because driving takes seconds."""
    value: float | None
    """The figure that the claim is about; None if the run cannot have it."""
    signature: Signature | None


@dataclass(frozen=True)
class FailureTest:
    """Runs a SLAM on a scenario and says whether it fails.

    It fails where the claim is true or, without a claim, where it raises an exception.
    """

    claim: Claim | None
    runner: Runner

    @staticmethod
    def parse(text: str, runner: Runner) -> "FailureTest":
        """Read a claim that is true of a failing run, such as "labels.accuracy < 0.7", or the word "crash".

        Raises `SimError` for anything else.
        """
        return FailureTest(None if text == CRASH else Claim.parse(text), runner)

    def __call__(self, scenario: Scenario) -> Signature | None:
        """The failure's signature, or None where the run does not fail. Raises what `run` raises if there is a claim."""
        if self.claim is not None:
            return self.observe(scenario).signature
        try:
            self.observe(scenario)
        except (SimError, WorldsError):  # the scenario is not valid, or the estimate
            raise
        except Exception as error:
            return Signature("exception", type(error).__name__)
        return None

    def observe(self, scenario: Scenario, progress: Progress | None = None) -> Observed:
        """Run the SLAM and judge the result. Raises what the run raises."""
        finished = self.runner(scenario, progress)
        drives = self.claim is not None and self.claim.is_about_plans
        trials = tuple(try_plans(finished)) if drives else ()
        result = evaluate(finished, trials)
        if self.claim is None:
            return Observed(finished, result, trials, None, None)
        failing = self.claim.outcome(result) == "holds"
        signature = Signature("claim", str(self.claim)) if failing else None
        return Observed(finished, result, trials, self.claim.value(result), signature)

    def __str__(self) -> str:
        return CRASH if self.claim is None else str(self.claim)
