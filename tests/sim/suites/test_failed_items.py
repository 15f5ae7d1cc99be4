"""A failed item of `slam_checks` leaves a folder that replays its failure."""

import os
import shlex

import pytest
from helpers.documentation import ROOT

from sim.harness import Scenario

pytest_plugins = ["pytester"]

CHECKS = """
    from helpers.flat_suite import FLAT, FloorsByHeight
    from sim import slam_checks

    test_floors = slam_checks(FloorsByHeight, suite=FLAT)
    test_expected = slam_checks(FloorsByHeight, suite=FLAT, expected_failures={"flat: origin": "heights"})
"""
ITEM = "test_mine.py::test_floors[flat: origin]"


@pytest.fixture
def start(pytester, monkeypatch):
    """Run pytest in a folder of its own and a process of its own; returns its output."""
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(ROOT), str(ROOT / "tests")]))
    monkeypatch.setenv("PYTEST_DISABLE_PLUGIN_AUTOLOAD", "1")
    plugin = ("-p", "no:lexis", "-p", "sim.pytest_plugin", "-p", "no:cacheprovider")
    return lambda *options: pytester.runpytest_subprocess(*plugin, *options).stdout.str()


def test_a_failed_item_is_stored_and_replayed(pytester, start):
    pytester.makepyfile(test_mine=CHECKS)
    shown = start("-k", "origin")
    (folder,) = (pytester.path / ".lexis-failures").iterdir()
    kept = f".lexis-failures/{folder.name}"
    assert "1 failed" in shown and "1 xfailed" in shown and f"\nfolder: {kept}\n" in shown
    assert f"\nreplay: pytest -p sim.pytest_plugin {shlex.quote(ITEM)} --lexis-replay {kept}\n" in shown
    assert folder.name.endswith(Scenario.load(folder / "scenario.json").content_hash)
    assert "The claims do not depend on the origin." in (folder / "why.md").read_text()
    replayed = start(folder)
    assert "1 failed" in replayed and "% of the floors" in replayed and "in 0 of 2 scenarios" not in replayed
