"""The fresh houses of decorated tests: their budget, their collection in several processes, and when they are imported."""

import itertools
import re
import subprocess
import sys
import tomllib
import types

import pytest
from helpers.documentation import ROOT
from helpers.plugin_sessions import LAYOUT, LIGHT, ids

import sim.pytest_plugin.protocol
from sim.pytest_plugin.options import SEED, pytest_configure_node

pytest_plugins = ["pytester"]


HEAVY = {"cv2", "gtsam", "hypothesis", "jaxtyping", "mujoco", "numpy", "open_clip", "scipy", "shapely", "torch"}


def test_importing_the_plugin_and_decorating_a_test_load_nothing_heavy():
    code = "import sys, sim.pytest_plugin\nfrom sim.harness import worlds\nworlds()(lambda run: None)\nprint(*sys.modules)"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    assert HEAVY.isdisjoint(loaded)


COUNTED = """
import os
from pathlib import Path
import pytest

@pytest.fixture
def slam(scenario):
    with Path("seeds").open("a") as file:
        file.write(f"{scenario.seed}\\n")

@worlds(max_rooms=2, n=2)
def test_counted(scenario, slam):
    print("ran")
    assert scenario.seed != int(os.environ.get("BAD", -1))
"""


SKIPS_LATER = """
import pytest

houses = []

@worlds(n=1, fidelity="layout")
def test_skips(house):
    houses.append(house)
    if len(houses) == 2:
        pytest.skip("not here")
"""


def test_a_budget_is_spent_on_further_houses_until_one_fails(pytester, inner, light, monkeypatch):
    clock = itertools.count()
    monkeypatch.setattr(sim.pytest_plugin.protocol, "time", types.SimpleNamespace(monotonic=lambda: next(clock)))
    pytester.makepyfile(test_slam=LAYOUT.partition("@")[0] + COUNTED)
    inner("--lexis-budget", "8s").assert_outcomes(passed=2)
    seeds = (pytester.path / "seeds").read_text().split()
    assert len(seeds) == len(set(seeds)) == 2 * 4

    monkeypatch.setenv("BAD", seeds[2])
    result = inner("--lexis-budget", "8s", "--no-lexis-shrink")
    result.assert_outcomes(passed=1, failed=1)
    assert result.stdout.str().count("ran\n") == 1
    assert f"assert {seeds[2]} != {seeds[2]}" in result.stdout.str()
    result.stdout.fnmatch_lines([f"house: *-{seeds[2]}, a further one within --lexis-budget"])


def test_a_test_that_is_skipped_in_a_further_house_has_passed(pytester, inner, light, monkeypatch):
    clock = itertools.count()
    monkeypatch.setattr(sim.pytest_plugin.protocol, "time", types.SimpleNamespace(monotonic=lambda: next(clock)))
    pytester.makepyfile(test_slam=LAYOUT.partition("@")[0] + SKIPS_LATER)
    inner("--lexis-budget", "8s").assert_outcomes(passed=1)


@pytest.mark.parametrize(
    ("dist", "workers"), [("load", 2), ("worksteal", 2), ("loadfile", 1), ("loadgroup", 1), ("each", 1)]
)
def test_the_budget_is_multiplied_only_for_workers_that_share_the_tests(dist, workers):
    config = types.SimpleNamespace(option=types.SimpleNamespace(dist=dist), stash={SEED: 7})
    node = types.SimpleNamespace(config=config, workerinput={"workercount": 2})
    pytest_configure_node(node)
    assert node.workerinput == {"workercount": 2, "lexis_seed": 7, "lexis_workers": workers}


def test_workers_of_xdist_collect_the_same_fresh_houses(pytester, start, inner):
    conftest = pytester.makeconftest(LIGHT)
    pytester.makepyfile(test_houses=LAYOUT)
    result = start("-p", "xdist", "-n", "2", "--lexis-profile", "lexis-nightly", "-v")
    result.assert_outcomes(passed=3)
    seed = re.search(r"--lexis-seed (\d+) \(lexis-nightly\)", result.stdout.str())[1]
    conftest.unlink()  # sessions in this process would replace `FreshWorld.scenario` for good
    ran = set(re.findall(r"PASSED test_houses.py::test_house\[(.*?)\]", result.stdout.str()))
    assert ran == set(ids(inner("--collect-only", "-q", "--lexis-seed", seed)))


def test_the_entry_point_loads_the_plugin_and_no_lexis_switches_it_off(pytester, start, monkeypatch):
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    ((name, module),) = project["entry-points"]["pytest11"].items()
    folder = pytester.path / "trial-1.0.dist-info"
    folder.mkdir()
    (folder / "METADATA").write_text("Metadata-Version: 2.1\nName: trial\nVersion: 1.0\n")
    (folder / "entry_points.txt").write_text(f"[pytest11]\n{name} = {module}\n")
    pytester.syspathinsert()
    pytester.makepyfile(test_houses=LAYOUT)
    monkeypatch.delenv("PYTEST_DISABLE_PLUGIN_AUTOLOAD")
    assert len(ids(start("--collect-only", "-q", plugin=()))) == 3
    pytester.makepyfile(test_houses="def test_plain():\n    pass\n")
    result = start("-p", "no:lexis", plugin=())
    result.assert_outcomes(passed=1)
    result.stdout.no_fnmatch_line("*lexis-seed*")
