"""`EarlierRun`: the stored results of a suite with which a later run of the suite is compared."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from sim.errors import SimError

if TYPE_CHECKING:
    from sim.harness.results import RunResult
    from sim.suites.report import SuiteReport
    from sim.suites.suite import Suite
    from sim.verdicts.comparison import Comparison


@dataclass(frozen=True)
class EarlierRun:
    """The results of an earlier version of a SLAM, as `lexis-sim check --suite --json` writes them."""

    path: Path
    results: "tuple[RunResult, ...]"
    begun: frozenset[str] | None
    """Hashes of the scenarios that the earlier run began; None if the file does not say."""

    @classmethod
    def read(cls, path: Path) -> "EarlierRun":
        """Read a file of results, or a folder of runs. Raises `SimError` if there is no result, or one that is not valid."""
        from sim.verdicts import load_results
        from sim.verdicts.stored_results import begun_in

        return cls(path, load_results(path), begun_in(path))

    def refuse_other_scenarios(self, suite: "Suite", seed: int) -> None:
        """Raise `SimError` unless the earlier run has a scenario of this suite and seed."""
        from sim.suites.examination import jobs_of, scenario_of

        known = {result.scenario for result in self.results} | (self.begun or frozenset())
        if not any(scenario_of(job).content_hash in known for job in jobs_of(suite, seed)):
            raise SimError(
                f"{self.path}: has no results of the suite {suite.name} with seed {seed}; valid: a file of "
                f"lexis-sim check --suite {suite.name} --seed {seed} --json {self.path}"
            )

    def compared_with(self, report: "SuiteReport") -> "Comparison | None":
        """Compare the results of a later run with these. Scenarios that only one of the runs began are left out.

        The result is None if no scenario was completed in both runs.
        """
        from sim.verdicts import compare_results
        from sim.verdicts.stored_results import only_begun

        begun = frozenset(each.scenario.content_hash for each in report.examined)
        a, b = only_begun(self.results, begun), only_begun(report.results, self.begun)
        return compare_results(a, b) if {each.scenario for each in a} & {each.scenario for each in b} else None
