"""Decides whether and how a run fails: a condition such as "labels.accuracy < 0.7" is true, or the SLAM crashes."""

from collections.abc import Sequence
from dataclasses import dataclass, field

from sim.errors import SimError
from sim.fidelity import Fidelity
from sim.harness.claims import Claim
from sim.harness.crash import Crash, Runner, attempt, attempt_plans
from sim.harness.figures import evaluate
from sim.harness.finished_run import Run
from sim.harness.results import RunResult
from sim.harness.run_settings import with_listed_house
from sim.harness.runner import Progress
from sim.harness.scenario import Scenario
from sim.harness.shrinking.failure_signature import Signature
from sim.harness.shrinking.original_failure import OriginalFailure
from sim.harness.trial import Trial

CRASH = "crash"
"""Word for `FailureTest.parse`: the run fails if the SLAM raises an exception, or if the program under test fails."""


@dataclass(frozen=True, eq=False)
class Observed:
    """A finished run with its figures, and the signature of the failure that it shows; None if the run does not fail."""

    run: Run
    result: RunResult
    trials: tuple[Trial, ...]
    """The plans that a robot has driven. Driving takes seconds, so plans are driven only for a condition about planning, and
    without a condition, because `plan` may crash."""
    value: float | None
    """Value of the figure that the condition is about; None without a condition, or if the run cannot have the figure."""
    signature: Signature | None

    @property
    def scenario(self) -> Scenario:
        """The scenario of the run."""
        return self.run.scenario


@dataclass(frozen=True, eq=False)
class FailureTest:
    """Runs a SLAM on a scenario and says whether it fails.

    A run fails if the condition is true or, without a condition, if the SLAM crashes. At its first failure, the test chooses
    a good SLAM that does not fail there (see `good_slam`), and remembers the kinds of errors. A later failure has
    another signature if this good SLAM fails in its scenario, too (`Signature.unavoidable`), if the `reference` does so
    (`Signature.of_reference`), or if its errors are of other kinds (`Signature.with_other_errors`).

    The test keeps the last failing run of each fidelity. After a search by `reduce`, the kept run is the run of the smallest
    scenario, which need not be run again.
    """

    condition: Claim | None
    runner: Runner
    reference: Runner | None = None
    """Runs a SLAM without the failure, such as an earlier version of the SLAM under test; only with a condition."""
    original: OriginalFailure = field(default_factory=OriginalFailure, repr=False)
    """What is remembered of the first failure. Copies made by `replace` share it."""
    _kept: dict[Fidelity, Observed | Crash] = field(default_factory=dict, init=False, repr=False)

    @staticmethod
    def parse(text: str, runner: Runner, reference: Runner | None = None) -> "FailureTest":
        """Parse the condition for a failure: a comparison such as "labels.accuracy < 0.7", or the word "crash".

        Raises `SimError` for anything else, and for a crash with a reference.
        """
        if text == CRASH and reference is not None:
            raise SimError(f"reference: the failure is {CRASH!r}; valid: with a figure, such as 'labels.accuracy < 0.7'")
        return FailureTest(None if text == CRASH else Claim.parse(text, "condition"), runner, reference)

    def __call__(self, scenario: Scenario) -> Signature | None:
        """Run the SLAM on a scenario; return the signature of the failure, or None if the run does not fail.

        A test with a condition, such as "labels.accuracy < 0.7", raises `SimError` in two cases: the SLAM crashes, or the
        run has no value (null) for a figure in the condition.
        """
        return self.signature_of(self.outcome(scenario))

    def signature_of(self, outcome: Observed | Crash) -> Signature | None:
        """Return the signature of the failure that an outcome shows, or None if it shows none.

        If the test has a condition, raises `SimError` if the SLAM crashed or a figure in the condition is null.
        """
        if isinstance(outcome, Crash):
            if self.condition is None:
                return Signature(outcome.what)
            valid = f"valid: {CRASH!r} in place of this condition"
            raise SimError(f"condition {str(self)!r}: {outcome.sentence}; {valid}") from outcome.error
        if self.condition is not None and outcome.value is None:
            null = " or ".join(self.condition.figures)
            raise SimError(f"condition {str(self)!r}: {null} is null; valid: a figure of what the SLAM estimates")
        return outcome.signature

    def outcome(self, scenario: Scenario, progress: Progress | None = None) -> Observed | Crash:
        """Run the SLAM on a scenario, unless the test has kept this run; return the run with its figures, or the crash.

        Raises what `attempt` raises: the scenario cannot be run, or the SLAM's estimate is not valid.
        """
        kept = self._kept.get(scenario.fidelity)
        if kept is not None and kept.scenario == scenario:
            return kept
        finished = attempt(self.runner, scenario, progress)
        outcome = finished if isinstance(finished, Crash) else self._judge(finished)
        if self._shows_the_failure(outcome, kept):
            self._kept[scenario.fidelity] = outcome
        return outcome

    def _shows_the_failure(self, outcome: Observed | Crash, kept: Observed | Crash | None) -> bool:
        """Return whether an outcome is the failure that is looked for. If a crash is kept, only an equal crash counts."""
        if isinstance(outcome, Crash):
            return self.condition is None and (not isinstance(kept, Crash) or kept.what == outcome.what)
        return self.condition is not None and outcome.signature == Signature(str(self.condition))

    def observe(self, scenario: Scenario) -> Observed:
        """Run the SLAM like `outcome`, but return completed runs only.

        Raises what `outcome` raises and, after a crash, the exception of the SLAM.
        """
        outcome = self.outcome(scenario)
        if isinstance(outcome, Crash):
            raise outcome.error
        return outcome

    def _judge(self, finished: Run) -> Observed | Crash:
        drives = self.condition is None or self.condition.is_about_plans  # a crash may be one of the method `plan`
        trials = attempt_plans(finished) if drives else ()
        if isinstance(trials, Crash):
            return trials
        result = evaluate(finished, trials)
        if self.condition is None:
            return Observed(finished, result, tuple(trials), None, None)
        failing, value = self.condition.outcome(result) == "holds", self.condition.value(result)
        signature = self._compared(Signature(str(self.condition), value), finished, trials) if failing else None
        return Observed(finished, result, tuple(trials), value, signature)

    def _compared(self, signature: Signature, failing: Run, trials: Sequence[Trial]) -> Signature:
        """Return the signature of a failing run after a comparison with the original failure and the reference."""
        assert self.condition is not None
        if self.original.is_unavoidable(failing, trials, self._passes):
            return signature.unavoidable
        if not self.original.is_like(failing, self.condition.figure):
            return signature.with_other_errors
        return signature if self.reference_fails(failing.scenario) is None else signature.of_reference

    def reference_run(self, scenario: Scenario) -> Run | None:
        """Run the reference on a scenario; None without a reference, or if it crashes. Raises `SimError` as `run` does."""
        finished = self._reference_attempt(scenario)
        return finished if isinstance(finished, Run) else None

    def _reference_attempt(self, scenario: Scenario) -> Run | Crash | None:
        if self.reference is None:
            return None
        try:
            return attempt(self.reference, scenario)
        except SimError as error:
            raise SimError(f"reference: {error}") from None

    def reference_fails(self, scenario: Scenario) -> str | None:
        """Return how the reference fails on a scenario, as text; None if it passes, or without a reference."""
        finished = self._reference_attempt(scenario)
        if finished is None:
            return None
        assert self.condition is not None
        trials = attempt_plans(finished) if isinstance(finished, Run) and self.condition.is_about_plans else ()
        for outcome in (finished, trials):
            if isinstance(outcome, Crash):
                return f"it {outcome.what}{outcome.place}"
        assert isinstance(finished, Run) and not isinstance(trials, Crash)
        result = evaluate(finished, trials)
        return None if self._passes(result) else self.condition.described(result)

    def _passes(self, result: RunResult) -> bool:
        return self.condition is not None and self.condition.outcome(result) == "fails"

    def __str__(self) -> str:
        return CRASH if self.condition is None else str(self.condition)


def check_fails(scenario: Scenario, test: FailureTest) -> None:
    """Raise `SimError` unless the SLAM fails on the scenario; the message contains the value of the figure.

    The scenario is run with its whole house listed (`with_listed_house`). The test keeps a failing run, so that a search by
    `reduce` does not repeat it.
    """
    outcome = test.outcome(with_listed_house(scenario))
    signature = test.signature_of(outcome)
    if signature is not None and signature == Signature(str(test)).of_reference:
        how = test.reference_fails(with_listed_house(scenario))
        raise SimError(f"reference: it fails in the scenario, too: {how}; valid: a SLAM that passes there")
    if signature is not None:
        return
    if test.condition is None or isinstance(outcome, Crash):
        raise SimError(f"{CRASH}: the SLAM does not crash on the scenario; valid: a scenario on which it does")
    found = test.condition.described(outcome.result)
    raise SimError(f"condition {str(test)!r}: {found}; valid: a condition that is true of the scenario")
