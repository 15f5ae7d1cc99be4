"""`SuiteReport`: the verdicts of a suite about a SLAM, with their confidence, and the scenarios in which a check failed."""

import math
import time
from collections.abc import Iterable, Iterator, Mapping
from contextlib import closing
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import groupby, islice
from numbers import Real
from typing import Any, Literal

from lexis.errors import LexisError
from sim.errors import SimError
from sim.harness.crash import COMPLETES
from sim.harness.last_run import LastRun, watched
from sim.harness.results import RunResult
from sim.harness.runner import Progress
from sim.harness.slam_under_test import check_slam_factory
from sim.number_checks import check_count
from sim.programs.program import Program
from sim.suites.catalogue import suite_named
from sim.suites.checks import Check, ClaimCheck, NewSlam
from sim.suites.examination import Examination, examinations, jobs_of
from sim.suites.expected_failures import NONE_EXPECTED, ExpectedFailure, expected_failures_of
from sim.suites.suite import Suite, SuitePart
from sim.suites.suite_means import ALL_PARTS, SuiteMean
from sim.verdicts.rate import RateVerdict
from worlds.errors import WorldsError

CONFIDENCE = 0.99
"""Confidence of each single verdict. The suite `pr` has about 300 of them. With 95 % confidence, LEXIS failed at least
one check with five of eight seeds."""
SEED = 7
"""Default seed of the scenarios of a suite; `lexis-sim check --suite` uses the same."""
SuiteOutcome = Literal["holds", "fails", "undecided", "not applicable", "not examined"]
_EXAMPLES = 3
"""Number of houses with failing scenarios that the text of a report names for each check."""


@dataclass(frozen=True, eq=False)
class CheckVerdict:
    """The verdict about one check of one part, over all scenarios of the part so far."""

    part: SuitePart
    check: str
    says: str
    rate: float | None
    """Share of the scenarios in which the check has to hold; None: in all of them, and one failure decides."""
    examined: tuple[Examination, ...]
    """All scenarios of the part that have been examined so far, in their order."""

    @property
    def checked(self) -> Check | None:
        """The check itself; None for the check that the run completes."""
        return self.part.check_named(self.check)

    @property
    def name(self) -> str:
        """Part and check, such as "stairs: floors.accuracy >= 0.9"."""
        return f"{self.part.name}: {self.check}"

    @property
    def is_begun(self) -> bool:
        """Whether the check has been made in any scenario. It is not made in a scenario in which the SLAM crashes."""
        return any(self.check in each.findings for each in self.examined)

    @cached_property
    def decided(self) -> tuple[Examination, ...]:
        """The scenarios in which the check holds or fails, in their order."""
        return tuple(each for each in self.examined if self._holds(each) is not None)

    @property
    def failures(self) -> tuple[Examination, ...]:
        """The scenarios in which the check fails."""
        return tuple(each for each in self.examined if self._holds(each) is False)

    @cached_property
    def verdict(self) -> RateVerdict | None:
        """The result of the sequential test of the rate at which the check holds.

        The test is read after every group. Its first "fails" counts, whatever follows. Otherwise its last "holds" counts or,
        without one, its answer after the last group. The result is None for a check that has to hold in all scenarios.
        """
        if self.rate is None:
            return None
        verdict, latest = RateVerdict(self.rate, CONFIDENCE, 0.0, 0), None
        for share in self._shares():
            verdict = RateVerdict(self.rate, CONFIDENCE, verdict.held + share, verdict.houses + 1)
            if verdict.outcome == "fails":
                return verdict
            if verdict.outcome == "holds":
                latest = verdict
        return latest or verdict

    @property
    def counts(self) -> tuple[float, int]:
        """How often the check holds, and in how many scenarios it is decided; a group of scenarios counts as one.

        For a check with a rate, these are the counts at which `verdict` gives its answer.
        """
        if self.verdict is None:
            return len(self.decided) - len(self.failures), len(self.decided)
        return self.verdict.held, self.verdict.houses

    @property
    def outcome(self) -> SuiteOutcome:
        """The outcome of `verdict`; "not applicable" if the check could not be decided in any scenario that was examined.

        A check that has to hold in all scenarios fails at its first failure, and holds as long as there is none. A check
        with a rate is "not examined" until the first group of scenarios is complete.
        """
        if not self.decided:
            return "not applicable" if self.is_begun else "not examined"
        if self.verdict is None:
            return "fails" if self.failures else "holds"
        return self.verdict.outcome if self.verdict.houses else "not examined"

    @property
    def could_fail(self) -> bool:
        """Whether enough scenarios were examined for a failure: would the check fail if it held in none of them?"""
        if self.verdict is None or self.outcome != "undecided":
            return self.outcome != "not examined"
        return replace(self.verdict, held=0.0).outcome == "fails"

    def __str__(self) -> str:
        """Return part, check and verdict.

        If the check fails, the text also says what the check demands and what it measured in the first houses in which it
        fails. If it could not be decided, the text gives the reason in the first scenario.
        """
        if self.outcome == "not examined":
            return f"{self.name}: not examined"
        if self.outcome == "not applicable":
            reason = next(each.findings[self.check].measured for each in self.examined if self.check in each.findings)
            return f"{self.name}: not applicable ({reason})"
        held, decided = self.counts
        counts = f"holds in {held} of {decided} scenarios (wanted: in all): {self.outcome}"
        lines = [f"{self.name}: {self.verdict or counts}"]
        if self.outcome == "fails":
            lines.append(f"  {self.says}")
            lines += [self._told(house) for house in islice(self._houses(self.failures), _EXAMPLES)]
        return "\n".join(lines)

    def _holds(self, scenario: Examination) -> bool | None:
        """Return whether the check holds in a scenario; None if it was not made there, or could not be decided.

        An estimate that the SLAM withholds in this scenario, but not in all others, counts as a failure. Otherwise, a SLAM
        that estimates nothing where it is lost would be judged by its good runs alone.
        """
        finding = scenario.findings.get(self.check)
        if finding is None:
            return None
        return False if finding.is_withheld and self._is_decided_somewhere else finding.holds

    @cached_property
    def _is_decided_somewhere(self) -> bool:
        findings = (each.findings.get(self.check) for each in self.examined)
        return any(finding is not None and finding.holds is not None for finding in findings)

    def _houses(self, scenarios: Iterable[Examination]) -> Iterator[tuple[Examination, ...]]:
        """Yield those of the scenarios that belong to one group, group by group."""
        groups = groupby(scenarios, lambda each: (each.part, each.number // self.part.group))
        return (tuple(members) for _, members in groups)

    def _told(self, failures: tuple[Examination, ...]) -> str:
        """Return one line about the failures in a group of scenarios, with what was measured in the first of them."""
        first, more = failures[0], len(failures) - 1
        others = f" (and {more} more of this house)" if more else ""
        scenario = f"scenario {first.number} of {first.part}, seed {first.scenario.seed}"
        return f"  {scenario}{others}: {first.findings[self.check].measured}"

    def _shares(self) -> Iterator[float]:
        """Yield for each completely examined group the share of its decided scenarios in which the check holds.

        Groups in which the check is not decided in any scenario are left out.
        """
        for scenarios in self._houses(self.examined):
            group = scenarios[0].number // self.part.group
            if scenarios[-1].number < min((group + 1) * self.part.group, self.part.n) - 1:
                continue  # the rest of the group has not been examined yet
            if holds := [held for each in scenarios if (held := self._holds(each)) is not None]:
                yield sum(holds) / len(holds)


@dataclass(frozen=True, eq=False)
class SuiteReport:
    """What a suite found out about a SLAM. `ok` says whether no check fails, except those that are expected to."""

    suite: Suite
    seed: int
    examined: tuple[Examination, ...]
    interrupted: bool = False
    """Whether Ctrl-C ended the suite before all its scenarios were examined."""
    error: Exception | None = None
    """The exception that ended the suite before all its scenarios were examined, such as a full disk; None without one."""
    expected: tuple[ExpectedFailure, ...] = ()
    """The checks and means that are expected to fail."""

    @cached_property
    def verdicts(self) -> tuple[CheckVerdict, ...]:
        """One verdict for each check of each part, in the order of the suite, and one for each law that parts share."""
        return (*(verdict for part in self.suite.parts for verdict in self._of_part(part)), *self._of_shared_laws())

    @property
    def failed(self) -> tuple[CheckVerdict, ...]:
        """The verdicts of the checks that fail, and are not expected to."""
        return tuple(each for each in self.verdicts if each.outcome == "fails" and self.expectation(each.name) is None)

    @cached_property
    def means(self) -> tuple[SuiteMean, ...]:
        """One verdict for each claim about a mean, in the order of the suite."""
        return tuple(SuiteMean(self.suite, claim, self.examined, CONFIDENCE) for claim in self.suite.means)

    @property
    def failed_means(self) -> tuple[SuiteMean, ...]:
        """The verdicts of the claims about means that fail, and are not expected to."""
        return tuple(each for each in self.means if each.outcome == "fails" and self.expectation(each.name) is None)

    @property
    def unmet_expectations(self) -> tuple[str, ...]:
        """One line about each check and mean that is expected to fail and does not; none until the suite is complete."""
        if len(self.examined) < sum(part.n for part in self.suite.parts):
            return ()
        return tuple(
            f"{each.name}: {expectation.instead(each.outcome)}"
            for each in self._all_verdicts()
            if each.outcome != "fails" and (expectation := self.expectation(each.name)) is not None
        )

    def expecting(self, reasons: Mapping[str, str]) -> "SuiteReport":
        """Return the report with other expected failures: the reason for each name or pattern of names.

        Raises `SimError` if a pattern stands for no check and no mean, or if a reason is no text.
        """
        names = [each.name for each in self._all_verdicts()]
        return replace(self, expected=expected_failures_of(reasons, names))

    def expectation(self, name: str) -> ExpectedFailure | None:
        """Return the entry that expects a check or a mean to fail; None without one."""
        return next((entry for entry in self.expected if name in entry.checks), None)

    @property
    def ok(self) -> bool:
        """Whether no check and no claim about a mean fails, except those that are expected to, which all fail.

        An undecided check or claim does not count as failed: it would take more scenarios to decide. A suite that Ctrl-C or
        an exception has ended is not ok.
        """
        failed = self.failed or self.failed_means or self.unmet_expectations
        return not (self.interrupted or self.error is not None or failed)

    @property
    def shortage(self) -> str | None:
        """A sentence about the checks that could not fail, because too few scenarios were examined; None without any."""
        unable = sum(not each.could_fail for each in self.verdicts)
        return f"{unable} of {len(self.verdicts)} checks could not fail: too few scenarios were examined" if unable else None

    @property
    def results(self) -> tuple[RunResult, ...]:
        """The figures of all unchanged runs that completed."""
        return tuple(each.result for each in self.examined if each.result is not None)

    def data(self) -> dict[str, Any]:
        """Return the verdicts as plain data for JSON."""
        return {
            "suite": self.suite.name,
            "seed": self.seed,
            "ok": self.ok,
            "interrupted": self.interrupted,
            "error": None if self.error is None else str(self.error),
            "examined": [each.scenario.content_hash for each in self.examined],
            "checks": [_check_data(each) | self._expected_data(each.name) for each in self.verdicts],
            "means": [_mean_data(each) | self._expected_data(each.name) for each in self.means],
        }

    def __str__(self) -> str:
        ended = None if self.error is None else f"ended early: {self.error}"
        lines = [*map(str, (*self.verdicts, *self.means)), *self.unmet_expectations, self.shortage, ended]
        return "\n".join(line for line in lines if line is not None)

    def _all_verdicts(self) -> tuple[CheckVerdict | SuiteMean, ...]:
        return *self.verdicts, *self.means

    def _expected_data(self, name: str) -> dict[str, Any]:
        expectation = self.expectation(name)
        return {"expected_failure": None if expectation is None else expectation.reason}

    def _of_part(self, part: SuitePart) -> Iterator[CheckVerdict]:
        own = sorted((each for each in self.examined if each.part == part.name), key=lambda each: each.number)
        completes = (COMPLETES, "The SLAM raises no exception, and its estimates are valid.", None)
        for name, says, rate in (completes, *((check.name, check.says, check.rate) for check in part.checks)):
            yield CheckVerdict(part, name, says, rate, tuple(own))

    def _of_shared_laws(self) -> Iterator[CheckVerdict]:
        """Yield a verdict for each law with a rate that several parts have, over the scenarios of all these parts.

        A law that is broken now and then shows sooner in all scenarios together than in the few of one part. Parts with
        groups of scenarios are left out.
        """
        parts = [part for part in self.suite.parts if part.group == 1]
        laws = {check.name: check for part in parts for check in part.checks if not isinstance(check, ClaimCheck)}
        for name, law in laws.items():
            sharing = [part for part in parts if law in part.checks]
            if law.rate is None or len(sharing) < 2:
                continue
            about = f"The scenarios of {', '.join(part.name for part in sharing)}."
            whole = replace(sharing[0], name=ALL_PARTS, about=about, checks=(law,), n=sum(part.n for part in sharing))
            own = tuple(each for each in self.examined if each.part in {part.name for part in sharing})
            yield CheckVerdict(whole, name, law.says, law.rate, own)


def check_slam(
    new_slam: NewSlam,
    suite: Suite | str = "pr",
    seed: int = SEED,
    workers: int = 1,
    stop_at_failure: bool = False,
    progress: Progress | None = None,
    budget_s: float = math.inf,
    expected_failures: Mapping[str, str] = NONE_EXPECTED,
) -> SuiteReport:
    """Check a SLAM by a suite.

    In a scenario in which an exception is raised while the SLAM is made or runs, the check "the run completes" fails. After
    Ctrl-C, the report is about the scenarios that were examined before. The same is true after one of the errors below, if a
    scenario was examined before it.

    Args:
        new_slam: makes a SLAM that has not run yet, such as a class that takes no arguments; or a `Program`, for which all
            scenarios are rendered.
        suite: a suite, or the name of one in `SUITES`.
        seed: seed of all scenarios.
        workers: number of processes; with more than one, `new_slam` has to be picklable.
        stop_at_failure: whether to stop when the first check fails.
        progress: is called after each scenario with the share of the scenarios that are done, in [0, 1].
        budget_s: wall time after which no further scenario is begun [s]. The parts of a suite take turns, so that an early
            end leaves out scenarios of all parts.
        expected_failures: the reason for each check or mean that is known to fail, by its name in the report, such as
            "homes: a pause", or by a pattern such as "revisits: trajectory.*". They do not count as failed. When all
            scenarios are done, each of them has to fail; otherwise the report is not `ok`, and says why.

    Raises:
        SimError: the suite or the name of an expected failure is unknown, the seed is negative, `workers` is less than 1,
            `budget_s` is no number, `new_slam` cannot be called without arguments, makes no SLAM or cannot be sent to other
            processes, or no scenario of a part can be drawn.
        EncoderError: LEXIS cannot load its encoder.
    """
    if not isinstance(new_slam, Program):
        check_slam_factory("check_slam: new_slam", new_slam)
    check_count("suite: seed", seed, 0)
    check_count("suite: workers", workers, 1)
    _check_budget(budget_s)
    chosen, end = runnable(suite_named(suite), new_slam), time.monotonic() + budget_s
    jobs = jobs_of(chosen, seed)
    report = SuiteReport(chosen, seed, ()).expecting(expected_failures)
    # In a test, the pytest plugin would take the last of these many runs for the run that the test is about.
    try:
        with watched(LastRun()), closing(examinations(jobs, new_slam, workers, end)) as found:
            for each in found:
                report = replace(report, examined=(*report.examined, each))
                if progress is not None:
                    progress(len(report.examined) / len(jobs))
                if stop_at_failure and not report.ok:
                    break
    except KeyboardInterrupt:
        return replace(report, interrupted=True)
    except (SimError, LexisError, WorldsError) as error:  # such as a full disk
        if not report.examined:
            raise
        return replace(report, error=error)
    return report


def runnable(suite: Suite, new_slam: NewSlam) -> Suite:
    """Return the suite in a form that can be run on the SLAM: for a program, all scenarios have rendered images.

    Programs cannot read percepts (embeddings of views, which replace images). For any other SLAM, the suite does not change.
    """
    return suite.with_images() if isinstance(new_slam, Program) else suite


def _check_budget(budget_s: object) -> None:
    """Raise SimError unless the budget is a number, which may be infinite."""
    if not isinstance(budget_s, Real) or math.isnan(budget_s):
        raise SimError(f"check_slam: budget_s is {budget_s!r:.60}; valid: a number of seconds, such as 720")


def _check_data(each: CheckVerdict) -> dict[str, Any]:
    return {
        "part": each.part.name,
        "check": each.check,
        "says": each.says,
        "rate": each.rate,
        "outcome": each.outcome,
        "scenarios": len(each.decided),
        "failures": [
            {"number": f.number, "measured": f.findings[each.check].measured, "scenario": f.scenario.data()}
            for f in each.failures
        ],
    }


def _mean_data(each: SuiteMean) -> dict[str, Any]:
    low, high = each.verdict.interval
    return {
        "claim": str(each.claim),
        "outcome": each.outcome,
        "houses": len(each.verdict.margins),
        "mean_margin": each.verdict.mean,
        "at_least": None if math.isinf(low) else low,
        "at_most": None if math.isinf(high) else high,
    }
