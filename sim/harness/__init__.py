"""The harness: run LEXIS on a simulated house, and check the result against the truth.

    from sim import RunConfig, check

    result = check(RunConfig(preset="home", seed=7))
    assert result["floors"]["accuracy"] > 0.9

`config` describes a run, `parts` and `walk` build its house, tour and odometry, `runner` feeds LEXIS, `planning` drives the
plans, `figures` (with `loops`) computes every figure of result.json, and `outputs` writes the folder of a run with its
report, for which `report_data` prepares the data.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
