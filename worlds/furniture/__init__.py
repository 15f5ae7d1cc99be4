"""Furniture: a catalogue of kinds, each declared by a function, and the placement of pieces of these kinds in rooms.

To add a kind, write one function in the module of its theme, or in a new module that is listed in `catalogue._THEMES`::

    @furniture(
        "longcase clock", width=(0.4, 0.5), depth=(0.25, 0.3), height=(1.9, 2.1), rooms={"living room": 0.2}, clearance=0.5
    )
    def longcase_clock(s: Size, rng: Generator) -> Parts:
        return (
            box(s.x, s.y, s.z, pick(rng, DARK_WOODS), "wood"),
            box((-0.12, 0.12), (s.front - 0.02, s.front), (0.4, 1.3), GLASS),
            ball(about(0.0, 0.28), (s.front - 0.02, s.front), about(s.height - 0.25, 0.28), WHITE),
        )

`rooms` says how many pieces a room has, by its label: 0.2 is an expected number, (1, 2) is the least and the greatest
number, and `PerClutter(0.5)` is for pieces that only cluttered rooms have. For pieces at, on or above another piece (the
host), these numbers count pieces per host. Placement, truth, rendering and tests use the catalogue.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
