"""The lines that `lexis-sim check --suite` prints: a table of verdicts, medians of figures, and the number of scenarios."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

from sim.wording import percent

if TYPE_CHECKING:
    from sim.suites.report import CheckVerdict, SuiteReport
    from sim.suites.suite_means import SuiteMean

_HEAD = f"{'outcome':14} {'holds in':>12} {'wanted':>6}  check"


def suite_lines(report: "SuiteReport", failed_alone: bool) -> Iterator[str]:
    """Yield the lines about a suite. With `failed_alone`, they are only about the checks that fail, if there are any."""
    yield _HEAD
    if failed_alone and (report.failed or report.failed_means):
        yield from (_verdict_line(verdict, report) for verdict in report.failed)
        yield from (_mean_line(mean, report) for mean in report.failed_means)
    else:
        yield from _all_lines(report)
    yield f"{len(report.examined)} of {sum(part.n for part in report.suite.parts)} scenarios were examined"


def _all_lines(report: "SuiteReport") -> Iterator[str]:
    """Yield the lines about all checks and means, and the medians of the figures."""
    from sim.suites.figure_table import figure_table
    from sim.suites.report import CONFIDENCE

    yield from (_verdict_line(verdict, report) for verdict in report.verdicts if verdict.is_begun)
    examined = {each.part for each in report.examined}
    if missing := [part.name for part in report.suite.parts if part.name not in examined]:
        yield f"not examined: {', '.join(missing)}"
    yield from (_mean_line(mean, report) for mean in report.means)
    yield figure_table(report)
    if "undecided" in [*(each.outcome for each in report.verdicts), *(each.outcome for each in report.means)]:
        yield f"undecided: so few scenarios give no answer with {percent(CONFIDENCE)} confidence; this is no failure"
    if report.shortage is not None:
        yield report.shortage


def _verdict_line(verdict: "CheckVerdict", report: "SuiteReport") -> str:
    (held, decided), wanted = verdict.counts, 1.0 if verdict.rate is None else verdict.rate
    return f"{_outcome(verdict, report):14} {round(held, 2):5g} of {decided:<3} {percent(wanted):>6}  {verdict.name}"


def _mean_line(mean: "SuiteMean", report: "SuiteReport") -> str:
    low, high = mean.verdict.interval
    margin = "" if mean.verdict.mean is None else f"  margin {mean.verdict.mean:+.3g} ({low:+.3g} to {high:+.3g})"
    return f"{_outcome(mean, report):14} {'':19}  {mean.name}{margin}"


def _outcome(verdict: "CheckVerdict | SuiteMean", report: "SuiteReport") -> str:
    """Return the outcome as the first word of a line; "expected" for a failure that is expected."""
    is_expected = verdict.outcome == "fails" and report.expectation(verdict.name) is not None
    return "expected" if is_expected else verdict.outcome
