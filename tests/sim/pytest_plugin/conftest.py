"""Pytest sessions with the plugin, in a process of their own or in this one."""

import importlib

import pytest
from helpers.documentation import ROOT
from helpers.pytest_process import isolate_pytest

from sim.harness import Scenario
from sim.harness.world_tests import FreshWorld

PLUGIN = ("-p", "no:lexis", "-p", "sim.pytest_plugin")


@pytest.fixture
def start(pytester, monkeypatch):
    """Run pytest in a folder of its own and a process of its own, with the plugin."""
    isolate_pytest(monkeypatch, ROOT)

    def run(*args, plugin=PLUGIN):
        return pytester.runpytest_subprocess(*plugin, "-p", "no:cacheprovider", "--strict-markers", *args)

    return run


@pytest.fixture(scope="module")
def loaded():
    """Load what cannot be loaded twice, before `pytester` notes which modules are to stay."""
    for module in (
        "sim.harness.failures.failed_test",
        "sim.harness.diagnosis.first_wrong",
        "sim.harness.shrinking.reducer",
        "worlds.strategies",
    ):
        importlib.import_module(module)


@pytest.fixture
def inner(loaded, pytester, start):
    """Run pytest in a folder of its own and in this process."""

    def run(*args):
        return pytester.runpytest_inprocess(*PLUGIN, "-p", "no:cacheprovider", "--strict-markers", *args)

    return run


@pytest.fixture
def light(monkeypatch):
    """Let the scenarios of fresh houses consist of a seed, for tests that look at nothing else."""
    monkeypatch.setattr(FreshWorld, "scenario", lambda self: Scenario(seed=self.seed))
