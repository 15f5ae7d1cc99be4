"""The pytest plugin: tests run a SLAM in simulated houses, and a failed test leaves a folder that replays the failure.

A user decorates a test with `sim.harness.worlds` and overrides the fixture `slam`; the fixture `run` is the `RunResult` of
the SLAM in one house. A test without the decorator may call `sim.harness.run` by itself. pytest loads this package at every
start, so the package loads nothing heavy until a test needs it. pytest finds the hooks and fixtures here. They are defined
in these modules:

- `options`: the command line options, the seed and the markers.
- `collection`: decides which tests run in which houses.
- `fixtures`: what tests take as arguments: `scenario`, `house`, `slam` and `run`.
- `execution`: executes a test once, and records its runs and why it failed.
- `drawn_tests`: replays of tests whose houses Hypothesis draws.
- `protocol`: executes a decorated test, also in further houses within the budget, and reports its outcome.
- `shrinking`: executes a failing test in smaller and smaller scenarios.
- `explanation`: what the terminal shows of a failure, and its folder.
- `replay`: replays a failure from its folder.
"""

from sim.pytest_plugin.collection import pytest_collection_finish as pytest_collection_finish
from sim.pytest_plugin.collection import pytest_generate_tests as pytest_generate_tests
from sim.pytest_plugin.collection import pytest_pycollect_makemodule as pytest_pycollect_makemodule
from sim.pytest_plugin.execution import pytest_runtest_call as pytest_runtest_call
from sim.pytest_plugin.execution import pytest_runtest_setup as pytest_runtest_setup
from sim.pytest_plugin.fixtures import house as house
from sim.pytest_plugin.fixtures import run as run
from sim.pytest_plugin.fixtures import scenario as scenario
from sim.pytest_plugin.fixtures import slam as slam
from sim.pytest_plugin.options import pytest_addoption as pytest_addoption
from sim.pytest_plugin.options import pytest_configure as pytest_configure
from sim.pytest_plugin.options import pytest_configure_node as pytest_configure_node
from sim.pytest_plugin.options import pytest_ignore_collect as pytest_ignore_collect
from sim.pytest_plugin.options import pytest_report_header as pytest_report_header
from sim.pytest_plugin.protocol import pytest_runtest_makereport as pytest_runtest_makereport
from sim.pytest_plugin.protocol import pytest_runtest_protocol as pytest_runtest_protocol
