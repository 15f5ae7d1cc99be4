"""Programs with planted bugs are shrunk from a house of ten rooms and more, on recordings alone, and the cause is named."""

import pytest
from helpers.planted_commands import planted_command, program

from sim.harness import Claim, FailureTest, Scenario, blame, reduce
from sim.harness.shrinking.scenario_size import size
from sim.programs import Program

HOME = Scenario(seed=500, frame_rate_hz=4.0)
BUGS = {
    "open-plan": ("labels.accuracy < 0.9", 1, 3, {"openness 0"}),
    "floors": ("floors.accuracy < 0.9", 2, 5, set()),
    "drift": ("trajectory.ate_m > 0.05", 1, 3, {"perfect odometry"}),
}
"""For each bug: the condition for a failure, the largest numbers of storeys and rooms (with stairs) that may be left, and
what mends the failure."""


@pytest.mark.slow
@pytest.mark.parametrize("bug", BUGS)
def test_a_program_with_a_planted_bug_is_shrunk_and_blamed(bug, tmp_path):
    condition, storeys, rooms, mends = BUGS[bug]

    def run_program(scenario, progress):
        return Program(program(bug))(scenario, progress)

    test = FailureTest(Claim.parse(condition), planted_command(tmp_path) if bug == "open-plan" else run_program)
    reduction = reduce(HOME, test, deadline_s=1e9)
    before, after = map(size, (reduction.original, reduction.scenario))
    assert before.rooms >= 10 and after.storeys <= storeys and after.rooms <= rooms and after.length_m <= 20.0
    assert reduction.searched_on == "render" and reduction.on_features == "cannot run"
    assert test(reduction.scenario) == reduction.signature
    assert set(blame(reduction, test).named("mends")) == mends
