"""Furniture: a catalogue of kinds that declare what they are, and a placer that reads the declarations.

To add a kind, write one function in the module of its theme (or a new module, named in `catalogue._THEMES`)::

    @furniture(
        "piano", width=(1.35, 1.5), depth=(0.55, 0.65), height=(1.05, 1.25), rooms={"living room": 0.2}, clearance=0.7
    )
    def piano(s: Size, rng: Generator) -> Parts:
        black = pick(rng, DARK_WOODS)
        return (
            box(s.x, (s.back, s.back + 0.3), s.z, black, "wood"),
            box(s.x, (s.back + 0.3, s.front), (0.6, 0.75), black, "wood"),
            box((s.left + 0.08, s.right - 0.08), (s.front - 0.16, s.front - 0.01), (0.75, 0.77), WHITE, "keyboard"),
        )

`rooms` says how many: 0.2 is an expected number, (1, 2) what the room always has, `Hoarded(0.5)` what only clutter brings.
The rest (placement, truth, rendering, tests) follows from the catalogue.
"""
