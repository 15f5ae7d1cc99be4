"""The harness: gives the observations of a scenario to a SLAM, and compares the SLAM's estimate with the truth.

    from sim import Scenario, check

    result = check(Scenario(preset="home", seed=7), MySlam())
    assert result.floors.accuracy > 0.9

`scenario` describes a run; `run_settings` and `walk` derive its house, tour and odometry. `slam_under_test` is the interface
of a SLAM, `feature_input` replaces images in runs on features, `estimate` holds what the SLAM returns, `returned_estimate`
compares this with the run, and `adapters` contains LEXIS and others. `runner` gives the observations of `scenario_sessions`
to the SLAM, and returns a `finished_run`. `planning` lets a robot drive the SLAM's plans, each in a `trial`; `upright` turns
estimated poses so that z points up. `figures` (with `loops`) computes the figures that `results` holds. `claims` reads
statements about figures, such as "rooms.pq >= 0.6". `outputs` writes the folder of a run with its report, for which
`report_data` prepares the data. `crash` runs a SLAM, and distinguishes a crash of the SLAM from a scenario that cannot be
run.

Three packages explain a failure. `diagnosis` finds where in the run the SLAM first went wrong. `shrinking` finds the
smallest scenario in which the SLAM fails in the same way. `failures` finds the causes, and writes all this into a folder.

`world_tests` holds the decorator `worlds` for tests in pytest; the plugin `sim.pytest_plugin` runs the decorated tests.
Through `last_run` the plugin learns which run a test has started.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
