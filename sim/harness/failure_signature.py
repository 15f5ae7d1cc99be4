"""Decides whether a run fails, and how: a given claim about its figures is true, or the SLAM raises an exception."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Literal

from sim.errors import SimError
from sim.fidelity import Fidelity
from sim.harness.claims import Claim
from sim.harness.figures import evaluate
from sim.harness.planning import Trial, try_plans
from sim.harness.results import RunResult
from sim.harness.runner import Progress, Run
from sim.harness.scenario import Scenario
from worlds.errors import WorldsError

Runner = Callable[[Scenario, Progress | None], Run]
"""Runs the SLAM under test on a scenario. Each run needs a SLAM object of its own, because runs are kept."""
CRASH = "crash"
"""Word for `FailureTest.parse`: the run fails if the SLAM raises an exception."""


@dataclass(frozen=True)
class Signature:
    """Identifies a failure: two runs with equal signatures show the same failure."""

    kind: Literal["claim", "exception"]
    what: str
    """The claim that is true, or the name of the exception's type."""
    value: float | None = field(default=None, compare=False)
    """The figure that the claim is about, in the run that showed the failure."""

    def __str__(self) -> str:
        return self.what if self.kind == "claim" else f"raises {self.what}"


@dataclass(frozen=True, eq=False)
class Observed:
    """A finished run with its figures, and the failure that it shows."""

    run: Run
    result: RunResult
    trials: tuple[Trial, ...]
    """Driven plans. They are empty unless the claim is about planning, because driving takes seconds."""
    value: float | None
    """Value of the figure that the claim is about; None without a claim, or if the run cannot have the figure."""
    signature: Signature | None


@dataclass(frozen=True, eq=False)
class FailureTest:
    """Runs a SLAM on a scenario and says whether it fails.

    A run fails if the claim is true or, without a claim, if the SLAM raises an exception. The last failing run of each
    fidelity is kept. After a search by `reduce`, that is the run of the smallest scenario, so that it need not be run again.
    """

    claim: Claim | None
    runner: Runner
    _kept: dict[Fidelity, Observed] = field(default_factory=dict, init=False, repr=False)

    @staticmethod
    def parse(text: str, runner: Runner) -> "FailureTest":
        """Parse the condition for a failure: a claim such as "labels.accuracy < 0.7", or the word "crash".

        Raises `SimError` for anything else.
        """
        return FailureTest(None if text == CRASH else Claim.parse(text), runner)

    def __call__(self, scenario: Scenario) -> Signature | None:
        """Return the failure's signature, or None if the run does not fail.

        With a claim, raises whatever the run raises, and `SimError` if the figure of the claim is null.
        """
        if self.claim is not None:
            observed = self.observe(scenario)
            if observed.value is None:
                raise SimError(f"claim {str(self)!r}: {self.claim.figure} is null; valid: a figure of what the SLAM claims")
            return observed.signature
        try:
            self.observe(scenario)
        except (SimError, WorldsError):  # the scenario is not valid, or the estimate
            raise
        except Exception as error:
            return Signature("exception", type(error).__name__)
        return None

    def observe(self, scenario: Scenario, progress: Progress | None = None) -> Observed:
        """Run the SLAM on a scenario, unless this run was kept, and judge the result. Raises what the run raises."""
        kept = self._kept.get(scenario.fidelity)
        if kept is not None and kept.run.scenario == scenario:
            return kept
        observed = self._judge(self.runner(scenario, progress))
        if observed.signature is not None:
            self._kept[scenario.fidelity] = observed
        return observed

    def _judge(self, finished: Run) -> Observed:
        drives = self.claim is not None and self.claim.is_about_plans
        trials = tuple(try_plans(finished)) if drives else ()
        result = evaluate(finished, trials)
        if self.claim is None:
            return Observed(finished, result, trials, None, None)
        failing, value = self.claim.outcome(result) == "holds", self.claim.value(result)
        signature = Signature("claim", str(self.claim), value) if failing else None
        return Observed(finished, result, trials, value, signature)

    def __str__(self) -> str:
        return CRASH if self.claim is None else str(self.claim)
