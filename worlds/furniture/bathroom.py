"""Furniture of bathrooms and toilets."""

from numpy.random import Generator

from worlds.furniture.kinds import AgainstWall, OnFloor, OnTop, OnWall, Parts, Size
from worlds.furniture.palette import BLACK, BRIGHT, CHROME, FRONTS, GLASS, LINEN, STEEL, WHITE, WHITES, WOODS, pick
from worlds.furniture.registry import furniture
from worlds.furniture.shapes import about, ball, box, cylinder, ends, fronts, inset, legs, shelf_unit, split, stocked

_WATER = (0.6, 0.8, 0.88)


@furniture(
    "bathtub",
    width=(1.6, 1.75),
    depth=(0.7, 0.8),
    height=(0.75, 0.85),
    rooms={"bathroom": (1, 1)},
    place=AgainstWall(corner=True),
    clearance=0.5,
)
def bathtub(s: Size, rng: Generator) -> Parts:
    """A bathtub full of water, with a tap, and a towel over the rim."""
    rim, white = 0.56, pick(rng, WHITES)
    x, y = s.x, s.y
    return (
        box(x, y, (0.0, 0.38), white, "ceramic"),
        *(box(i, y, (0.38, rim), white, "ceramic") for i in ends(x, 0.1)),
        *(box(inset(x, 0.1), j, (0.38, rim), white, "ceramic") for j in ends(y, 0.08)),
        box(inset(x, 0.1), inset(y, 0.08), (0.38, 0.42), _WATER, "glass"),
        cylinder(about(s.right - 0.2, 0.04), (s.back + 0.02, s.back + 0.06), (rim, s.height), CHROME, "metal"),
        box(about(s.right - 0.2, 0.04), (s.back + 0.02, s.back + 0.18), (s.height - 0.06, s.height - 0.02), CHROME, "metal"),
        box((s.left + 0.2, s.left + 0.6), (s.front - 0.12, s.front), (rim - 0.25, rim + 0.02), pick(rng, LINEN), "fabric"),
    )


@furniture(
    "shower",
    width=(0.8, 1.0),
    depth=(0.8, 1.0),
    height=(1.95, 2.1),
    rooms={"bathroom": 0.6},
    place=AgainstWall(corner=True),
    clearance=0.5,
)
def shower(s: Size, rng: Generator) -> Parts:
    """A shower: a tray, two glass walls in a metal frame, a tiled back wall and a shower head."""
    frame = pick(rng, (CHROME, BLACK))
    return (
        box(s.x, s.y, (0.0, 0.12), WHITE, "ceramic"),
        *legs(s, s.height, 0.03, frame, "metal", margin=0.0),
        box(inset(s.x, 0.03), (s.front - 0.025, s.front - 0.01), (0.12, 0.9), GLASS, "glass"),
        box((s.left + 0.01, s.left + 0.02), inset(s.y, 0.03), (0.12, s.height), GLASS, "glass"),
        box(s.x, (s.front - 0.03, s.front), (s.height - 0.03, s.height), frame, "metal"),
        box(inset(s.x, 0.02), (s.back, s.back + 0.02), (0.12, s.height - 0.05), (0.7, 0.85, 0.88), "tile"),
        cylinder(about(0.0, 0.03), (s.back + 0.04, s.back + 0.07), (0.9, 1.9), CHROME, "metal"),
        cylinder(about(0.0, 0.2), (s.back + 0.1, s.back + 0.3), (1.84, 1.88), CHROME, "metal"),
    )


@furniture(
    "toilet bowl",
    width=(0.37, 0.42),
    depth=(0.62, 0.7),
    height=(0.78, 0.86),
    rooms={"bathroom": (1, 1), "toilet": (1, 1)},
    clearance=0.45,
    essential=True,
)
def toilet_bowl(s: Size, rng: Generator) -> Parts:
    """A toilet: cistern, bowl, seat, and a raised or closed lid."""
    lid = pick(rng, (WHITE, WHITE, BLACK, WOODS[0]))
    seat = (
        (box(inset(s.x, 0.02), (s.back + 0.2, s.back + 0.25), (0.44, s.height - 0.02), lid),) if rng.random() < 0.4 else ()
    )
    return (
        box(s.x, (s.back, s.back + 0.2), (0.38, s.height - 0.03), WHITE, "ceramic"),
        box(s.x, (s.back, s.back + 0.21), (s.height - 0.03, s.height), WHITE, "ceramic"),
        box(inset(s.x, 0.1), (s.back + 0.02, s.front - 0.15), (0.0, 0.3), WHITE, "ceramic"),
        cylinder(inset(s.x, 0.01), (s.back + 0.16, s.front), (0.22, 0.4), WHITE, "ceramic"),
        cylinder(inset(s.x, 0.005), (s.back + 0.16, s.front), (0.4, 0.44), lid),
        *seat,
        box(about(0.0, 0.06), about(s.back + 0.1, 0.04), (s.height - 0.01, s.height), CHROME, "metal"),
    )


@furniture(
    "washbasin",
    width=(0.5, 0.7),
    depth=(0.42, 0.5),
    height=(0.98, 1.04),
    rooms={"bathroom": (1, 2), "laboratory": 0.3},
    clearance=0.55,
    essential=True,
)
def washbasin(s: Size, rng: Generator) -> Parts:
    """A washbasin on a cabinet, with a tap and soap."""
    front, top = pick(rng, FRONTS), 0.85
    return (
        box(inset(s.x, 0.03), (s.back, s.front - 0.06), (0.0, 0.7), front),
        *fronts(inset(s.x, 0.03), (0.1, 0.7), s.front - 0.04, 2, 1, front, CHROME),
        box(s.x, s.y, (0.7, top), WHITE, "ceramic"),
        cylinder(inset(s.x, 0.1), inset(s.y, 0.09), (top, top + 0.006), (0.72, 0.78, 0.8), "ceramic"),
        cylinder(about(0.0, 0.035), (s.back + 0.03, s.back + 0.065), (top, s.height), CHROME, "metal"),
        box(about(0.0, 0.03), (s.back + 0.03, s.back + 0.2), (s.height - 0.04, s.height), CHROME, "metal"),
        cylinder(about(s.right - 0.1, 0.06), (s.back + 0.03, s.back + 0.09), (top, top + 0.14), pick(rng, BRIGHT), "label"),
    )


@furniture(
    "hand basin",
    width=(0.36, 0.45),
    depth=(0.26, 0.32),
    height=(0.94, 0.98),
    rooms={"toilet": (1, 1)},
    clearance=0.3,
    essential=True,
)
def hand_basin(s: Size, rng: Generator) -> Parts:
    """A small basin on a pedestal."""
    return (
        cylinder(about(0.0, 0.16), (s.back, s.back + 0.16), (0.0, 0.72), WHITE, "ceramic"),
        box(s.x, s.y, (0.72, 0.86), WHITE, "ceramic"),
        cylinder(about(0.0, 0.03), (s.back + 0.02, s.back + 0.05), (0.86, s.height), CHROME, "metal"),
        box(about(0.0, 0.03), (s.back + 0.02, s.back + 0.14), (s.height - 0.03, s.height), CHROME, "metal"),
        cylinder(about(s.right - 0.06, 0.05), (s.back + 0.02, s.back + 0.07), (0.86, s.height), pick(rng, BRIGHT), "label"),
    )


@furniture(
    "bathroom mirror",
    width=(0.36, 0.65),
    depth=(0.03, 0.05),
    height=(0.6, 0.8),
    rooms={"bathroom": (1, 1), "toilet": (1, 1)},
    place=OnWall((1.12, 1.2), above=("washbasin", "hand basin")),
)
def bathroom_mirror(s: Size, rng: Generator) -> Parts:
    """A framed mirror with a light above it."""
    frame = pick(rng, (CHROME, BLACK, *WOODS))
    return (
        box(s.x, (s.back, s.front - 0.01), (0.0, s.height - 0.05), frame),
        box(inset(s.x, 0.03), (s.front - 0.01, s.front), (0.03, s.height - 0.08), GLASS, "glass"),
        box(inset(s.x, 0.08), s.y, (s.height - 0.05, s.height), (1.0, 0.97, 0.86)),
    )


@furniture(
    "towel rail",
    width=(0.5, 0.7),
    depth=(0.08, 0.12),
    height=(0.8, 1.0),
    rooms={"bathroom": (2, 3), "toilet": 0.5, "laundry room": 0.4, "gym": 0.5},
    place=OnWall((0.75, 0.95)),
)
def towel_rail(s: Size, rng: Generator) -> Parts:
    """A towel rail: three metal bars with two towels."""
    rails = [
        box(s.x, (s.back, s.back + 0.04), (z, z + 0.03), CHROME, "metal") for z in (0.0, 0.45 * s.height, s.height - 0.03)
    ]
    towels = [
        box(inset(s.x, rng.uniform(0.03, 0.12)), s.y, (z, s.height * f), pick(rng, (*LINEN, *BRIGHT)), "fabric")
        for z, f in ((0.1, 0.48), (0.55 * s.height, 1.0))
    ]
    return (*rails, *towels)


@furniture(
    "bath mat",
    width=(0.6, 0.8),
    depth=(0.4, 0.5),
    height=(0.015, 0.02),
    rooms={"bathroom": (1, 1), "toilet": 0.5},
    place=OnFloor("centre"),
    solid=False,
)
def bath_mat(s: Size, rng: Generator) -> Parts:
    """A shaggy bath mat."""
    return (
        box(s.x, s.y, (0.0, 0.014), pick(rng, (*LINEN, *BRIGHT)), "carpet"),
        box(inset(s.x, 0.06), inset(s.y, 0.06), (0.0, s.height), pick(rng, LINEN), "carpet"),
    )


@furniture(
    "bathroom cabinet",
    width=(0.35, 0.5),
    depth=(0.3, 0.36),
    height=(1.5, 1.8),
    rooms={"bathroom": 0.6},
    place=AgainstWall(corner=True),
    clearance=0.4,
)
def bathroom_cabinet(s: Size, rng: Generator) -> Parts:
    """A cabinet with towels on open shelves above a door."""
    front = pick(rng, FRONTS)
    return (
        *shelf_unit(s, 4, front),
        *stocked(s, 4, ("fabric", "fabric", "label"), pick(rng, LINEN), rng, fill=1.0),
        *fronts(s.x, (0.02, s.height / 4), s.front, 1, 1, front, CHROME),
    )


@furniture(
    "toilet paper",
    width=(0.13, 0.15),
    depth=(0.11, 0.13),
    height=(0.13, 0.16),
    rooms={"bathroom": (1, 1), "toilet": (1, 1)},
    place=OnWall((0.7, 0.8)),
)
def toilet_paper(s: Size, rng: Generator) -> Parts:
    """A roll of toilet paper under a lid."""
    return (
        box(s.x, s.y, (s.height - 0.02, s.height), CHROME, "metal"),
        box(inset(s.x, 0.01), inset(s.y, 0.005), (0.0, s.height - 0.03), WHITE, "fabric"),
    )


@furniture(
    "toilet brush",
    width=(0.1, 0.12),
    depth=(0.1, 0.12),
    height=(0.38, 0.45),
    rooms={"bathroom": 0.7, "toilet": (1, 1)},
    place=AgainstWall(beside=("toilet bowl",)),
    solid=False,
)
def toilet_brush(s: Size, rng: Generator) -> Parts:
    """A toilet brush in its holder."""
    return (
        cylinder(s.x, s.y, (0.0, 0.18), pick(rng, (WHITE, STEEL, BLACK)), "ceramic"),
        cylinder(about(0.0, 0.02), about(0.0, 0.02), (0.18, s.height), CHROME),
    )


@furniture(
    "wall cabinet",
    width=(0.5, 0.7),
    depth=(0.16, 0.2),
    height=(0.55, 0.7),
    rooms={"bathroom": (1, 1), "toilet": 0.5, "laundry room": 0.8},
    place=OnWall((1.35, 1.5)),
)
def wall_cabinet(s: Size, rng: Generator) -> Parts:
    """A wall cabinet: two doors above a ledge with bottles."""
    front = pick(rng, (WHITE, *FRONTS))
    bottles = [
        cylinder(inset(x, 0.02), about(0.0, 0.06), (0.02, 0.02 + rng.uniform(0.1, 0.16)), pick(rng, BRIGHT), "label")
        for x in split(inset(s.x, 0.03), 6)
    ]
    return (
        box(s.x, (s.back, s.front - 0.025), (0.22, s.height), front),
        *fronts(s.x, (0.22, s.height), s.front - 0.005, 2, 1, front, CHROME),
        box(s.x, s.y, (0.0, 0.02), front),
        *bottles,
    )


@furniture(
    "rubber duck",
    width=(0.1, 0.13),
    depth=(0.1, 0.12),
    height=(0.1, 0.12),
    rooms={"bathroom": 0.4},
    place=OnTop(("bathroom stool",)),
)
def rubber_duck(s: Size, rng: Generator) -> Parts:
    """A yellow rubber duck."""
    h = s.height
    return (
        ball(s.x, s.y, (0.0, 0.6 * h), BRIGHT[1]),
        ball(about(0.0, 0.06), about(0.01, 0.06), (0.45 * h, h), BRIGHT[1]),
        box(about(0.0, 0.03), (0.03, 0.05), about(0.7 * h, 0.012), BRIGHT[5]),
    )


@furniture("bathroom stool", width=(0.32, 0.38), depth=(0.3, 0.34), height=(0.4, 0.45), rooms={"bathroom": 0.4})
def bathroom_stool(s: Size, rng: Generator) -> Parts:
    """A stool with a folded towel."""
    wood = pick(rng, WOODS)
    return (
        *legs(s, s.height - 0.08, 0.04, wood),
        box(s.x, s.y, (s.height - 0.1, s.height - 0.06), wood, "wood"),
        box(inset(s.x, 0.03), inset(s.y, 0.04), (s.height - 0.06, s.height), pick(rng, LINEN), "fabric"),
    )
