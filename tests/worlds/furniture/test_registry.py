"""Laws of the table of kinds: every name is declared once, and a second declaration is refused where it stands."""

import re
import subprocess
import sys

import pytest

from worlds.errors import WorldsError
from worlds.furniture.registry import furniture

PROGRAM = """
from worlds.furniture import furniture

for _ in range(2):
    try:
        furniture("piano", width=(1, 1), depth=(1, 1), height=(1, 1), rooms={"office": 1})(lambda size, rng: ())
    except ValueError as error:
        print(error)

from worlds.house import build_house
"""


def test_a_second_declaration_names_both_modules(kinds):
    before = dict(kinds)
    second = furniture("piano", width=(1.0, 1.0), depth=(1.0, 1.0), height=(1.0, 1.0), rooms={"office": 1.0})
    expected = f"kind 'piano' is declared in worlds.furniture.living and again in {__name__}; valid: a name that is not in "
    with pytest.raises(WorldsError, match=re.escape(expected)):
        second(lambda size, rng: ())
    assert kinds == before


def test_a_program_that_takes_the_name_of_a_shipped_kind_is_refused_at_its_declaration():
    """In a process of its own, because the program declares its kind before it imports the catalogue."""
    done = subprocess.run([sys.executable, "-c", PROGRAM], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    assert len(lines) == 2 and all("declared in worlds.furniture.living and again in __main__" in line for line in lines)


def test_the_same_function_replaces_its_kind(kinds):
    """A cell of a notebook is run again after a change."""
    for width in (0.5, 0.7):

        @furniture("gong", width=(width, width), depth=(1.0, 1.0), height=(1.0, 1.0), rooms={"office": 1.0})
        def gong(size, rng):
            return ()

        assert kinds["gong"].width == (width, width)
    with pytest.raises(WorldsError, match=f"kind 'gong' is declared twice in {__name__}"):
        furniture("gong", width=(1.0, 1.0), depth=(1.0, 1.0), height=(1.0, 1.0), rooms={"office": 1.0})(lambda size, rng: ())
