"""`EarlierResults`: the stored results of a suite with which a later run of the suite is compared."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from sim.errors import SimError

if TYPE_CHECKING:
    from sim.suites.report import SuiteReport
    from sim.suites.suite import Suite
    from sim.verdicts import SuiteResults
    from sim.verdicts.comparison import Comparison


@dataclass(frozen=True)
class EarlierResults:
    """The results of an earlier version of a SLAM, as `lexis-sim check --suite --json` writes them."""

    path: Path
    stored: "SuiteResults"

    @classmethod
    def read(cls, path: Path) -> "EarlierResults":
        """Read a file of results, or a folder of runs. Raises `SimError` if there is no result, or one that is not valid."""
        from sim.verdicts import SuiteResults

        return cls(path, SuiteResults.load(path))

    def refuse_other_scenarios(self, suite: "Suite", seed: int) -> None:
        """Raise `SimError` unless the earlier run has a scenario of this suite and seed."""
        from sim.suites.examination import drawn_scenario, jobs_of

        if not any(drawn_scenario(job).content_hash in self.stored.known for job in jobs_of(suite, seed)):
            raise SimError(
                f"{self.path}: has no results of the suite {suite.name} with seed {seed}; valid: a file of "
                f"lexis-sim check --suite {suite.name} --seed {seed} --json {self.path}"
            )

    def compared_with(self, report: "SuiteReport") -> "Comparison | None":
        """Compare the results of a later run with these. Scenarios that one of the runs did not begin are left out.

        The result is None if no scenario was completed in both runs.
        """
        from sim.verdicts import SuiteResults

        later = SuiteResults(report.results, frozenset(each.scenario.content_hash for each in report.examined))
        if (comparison := self.stored.compared_with(later)) is None:
            return None
        before, now = comparison.names
        return replace(comparison, names=(f"{before} ({self.path})", f"{now} (this check)"))
