"""The law of the materials: furniture can have each material that can be painted, and no other."""

from worlds.furniture.palette import MATERIALS
from worlds.visuals.materials import PATTERNS


def test_the_materials_are_those_that_can_be_painted():
    assert tuple(PATTERNS) == MATERIALS
