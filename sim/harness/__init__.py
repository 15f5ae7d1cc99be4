"""The harness: give the observations of a scenario to a SLAM, and check its claims against the truth.

    from sim import Scenario, check

    result = check(Scenario(preset="home", seed=7), MySlam())
    assert result.floors.accuracy > 0.9

`scenario` describes a run, `parts` and `walk` build its house, tour and odometry. `slam_under_test` is the interface of a
SLAM, `estimate` holds its claims, and `adapters` contains LEXIS and others. `runner` feeds the SLAM, `planning` drives its
plans, `figures` (with `loops`) computes the `results`, about which `claims` are made, and `outputs` writes the folder of a
run with its report, for which `report_data` prepares the data.

`crash` tells a SLAM that raises an exception from a scenario that cannot be run.

For a failing run, `failure_signature` says how it fails, and `reducer` finds the smallest scenario that fails in the same
way, by the steps of `reductions` and `house_reductions`. `blame_table` replaces one part of the run at a time to find the
part that causes the failure. `failure_folder` writes all of this, with the page of `why_page`.

`world_tests` holds the decorator `worlds` for tests in pytest, whose plugin is `sim.pytest_plugin`. `first_wrong` finds
where in a run the SLAM first went wrong, and `failed_test` writes the files that replay a failed test. Through `last_run`
the plugin learns which run a test has started.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
