"""Run LEXIS on simulated houses and check it against the truth.

from sim.harness import RunConfig, check

result = check(RunConfig(preset="home", seed=7))
assert result["floors"]["accuracy"] > 0.9
"""

from typing import Any

from sim.harness.config import RunConfig
from sim.harness.evaluate import evaluate
from sim.harness.outputs import write_run
from sim.harness.planning import try_plans
from sim.harness.run import Run, run


def check(config: RunConfig) -> dict[str, Any]:
    """Run and evaluate: the contents of result.json."""
    finished = run(config)
    return evaluate(finished, try_plans(finished))


__all__ = ["Run", "RunConfig", "check", "evaluate", "run", "try_plans", "write_run"]
