"""The smallest scenario in which a check of a suite fails, found by the reducer of the harness."""

from sim.harness.failure_signature import Signature
from sim.harness.reducer import DEADLINE_S, Reduction, reduce
from sim.harness.scenario import Scenario
from sim.suites.checks import Check, NewSlam
from sim.suites.examination import COMPLETES, finding


def smallest_failure(
    check: Check | None, scenario: Scenario, new_slam: NewSlam, deadline_s: float = DEADLINE_S
) -> Reduction:
    """Make a scenario smaller while a check fails in it; None stands for the check that the run completes.

    Raises `SimError` if the check does not fail in the scenario.
    """

    def fails(candidate: Scenario) -> Signature | None:
        found = finding(check, candidate, new_slam)
        if found.holds is not False:
            return None
        return Signature(f"{COMPLETES}: {found.measured}" if check is None else check.name)

    return reduce(scenario, fails, deadline_s)
