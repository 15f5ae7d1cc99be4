"""The table of kinds, for tests that declare kinds of their own."""

import pytest

from worlds.furniture.catalogue import CATALOGUE
from worlds.furniture.registry import KINDS


@pytest.fixture
def kinds():
    """The table of kinds. The kinds that a test declares are removed after the test, even if the test fails."""
    before = dict(CATALOGUE)
    yield KINDS
    KINDS.clear()
    KINDS.update(before)
