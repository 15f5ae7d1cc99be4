"""The harness: give the observations of a scenario to a SLAM, and check its claims against the truth.

    from sim import Scenario, check

    result = check(Scenario(preset="home", seed=7), MySlam())
    assert result.floors.accuracy > 0.9

`scenario` describes a run, `parts` and `walk` build its house, tour and odometry. `slam_under_test` is what the harness
asks of a SLAM, `estimate` what the SLAM may claim, and `adapters` holds LEXIS and others. `runner` feeds the SLAM,
`planning` drives its plans, `figures` (with `loops`) computes the `results`, about which `claims` are made, and `outputs`
writes the folder of a run with its report, for which `report_data` prepares the data.

For a run that fails as `failure_signature` says, `reducer` finds the smallest scenario that fails in the same way, by the
steps of `reductions` and `house_reductions`; `blame_table` finds what mends it, and `failure_folder` writes all of that.

`world_tests` holds the decorator `worlds` for tests in pytest, whose plugin is `sim.pytest_plugin`. `first_wrong` finds
where in a run the SLAM first went wrong, and `failed_test` writes what is needed to replay a failed test.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
