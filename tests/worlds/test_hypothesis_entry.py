"""Hypothesis finds the strategy of `HouseSpec` through an entry point, in whichever order a user imports the two."""

import os
import subprocess
import sys
import tomllib
from importlib.metadata import entry_points
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
ENTRIES = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["entry-points"]["hypothesis"]
FIRST = ("from worlds.strategies import houses", "import hypothesis", "import worlds.spec", "import worlds.hypothesis_entry")
DRAW = """
from hypothesis import find, settings, strategies as st
from worlds.house import build_house
from worlds.spec import HouseSpec
spec = find(st.from_type(HouseSpec), lambda spec: True, settings=settings(database=None, derandomize=True))
print(len(build_house(spec).rooms))
"""


@pytest.fixture
def installed(tmp_path):
    """The environment of a process in which this tree is installed, with metadata that precede any other installation."""
    metadata = tmp_path / "lexis_sim-0.1.0.dist-info"
    metadata.mkdir()
    (metadata / "METADATA").write_text("Metadata-Version: 2.4\nName: lexis-sim\nVersion: 0.1.0\n")
    (metadata / "entry_points.txt").write_text(
        "\n".join(["[hypothesis]", *(f"{name} = {value}" for name, value in ENTRIES.items())])
    )
    return os.environ | {"PYTHONPATH": os.pathsep.join((str(ROOT), str(tmp_path)))}


@pytest.mark.parametrize("first", FIRST)
def test_the_type_can_be_drawn_whatever_is_imported_first(installed, first):
    done = subprocess.run([sys.executable, "-c", f"{first}\n{DRAW}"], capture_output=True, text=True, env=installed)
    assert done.returncode == 0, done.stderr[-500:]
    assert int(done.stdout) >= 2


def test_hypothesis_alone_does_not_load_the_strategies(installed):
    code = "import sys, hypothesis; print('worlds.hypothesis_entry' in sys.modules, 'worlds.strategies' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, env=installed)
    assert done.stdout.split() == ["True", "False"]


def test_what_is_installed_is_what_is_declared():
    """If this fails, reinstall the tree: pip install --no-deps --editable ."""
    assert {entry.name: entry.value for entry in entry_points(group="hypothesis", name="lexis-sim")} == ENTRIES
