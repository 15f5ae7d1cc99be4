"""Furniture of kitchens and pantries."""

from numpy.random import Generator

from worlds.furniture.kinds import AgainstWall, Around, OnFloor, OnTop, OnWall, Parts, Size
from worlds.furniture.palette import (
    BLACK,
    BRIGHT,
    CHROME,
    FRONTS,
    GLASS,
    METALS,
    RED,
    STEEL,
    STONES,
    WHITE,
    WHITES,
    WOODS,
    pick,
)
from worlds.furniture.registry import furniture
from worlds.furniture.shapes import about, ball, box, cylinder, fronts, inset, legs, shelf_unit, spaced, split, stocked
from worlds.parts import Part

_ROW = ("kitchen sink", "kitchen counter", "stove", "dishwasher", "fridge")


def _base_cabinet(s: Size, rng: Generator, top: float, columns: int) -> Parts:
    front, worktop = pick(rng, FRONTS), pick(rng, STONES)
    return (
        box(s.x, (s.back, s.front - 0.06), (0.0, 0.1), BLACK),
        box(s.x, (s.back, s.front - 0.025), (0.1, top - 0.04), front),
        box(s.x, s.y, (top - 0.04, top), worktop, "marble"),
        *fronts(s.x, (0.1, top - 0.04), s.front - 0.01, columns, 1, front, STEEL),
    )


@furniture(
    "kitchen counter",
    width=(0.9, 1.8),
    depth=(0.6, 0.63),
    height=(0.9, 0.92),
    rooms={"kitchen": (2, 3), "laboratory": 0.5},
    place=AgainstWall(beside=_ROW),
    clearance=0.7,
)
def kitchen_counter(s: Size, rng: Generator) -> Parts:
    """Base cabinets under a worktop."""
    return _base_cabinet(s, rng, s.height, max(2, round(s.width / 0.5)))


@furniture(
    "kitchen sink",
    width=(0.9, 1.2),
    depth=(0.6, 0.63),
    height=(1.2, 1.25),
    rooms={"kitchen": (1, 1), "laboratory": (1, 1)},
    place=AgainstWall(beside=_ROW),
    clearance=0.7,
    essential=True,
)
def kitchen_sink(s: Size, rng: Generator) -> Parts:
    """A base cabinet with a steel basin and a swan-necked tap."""
    top = 0.9
    tap = about(-0.1, 0.03)
    return (
        *_base_cabinet(s, rng, top, 2),
        box((s.left + 0.08, 0.12), (s.back + 0.1, s.front - 0.08), (top - 0.01, top + 0.006), CHROME, "metal"),
        box((s.left + 0.12, 0.08), (s.back + 0.14, s.front - 0.12), (top, top + 0.008), METALS[1], "metal"),
        box((0.16, s.right - 0.05), (s.back + 0.1, s.front - 0.08), (top, top + 0.012), STEEL, "metal"),
        cylinder(tap, (s.back + 0.05, s.back + 0.08), (top, s.height), CHROME),
        box(tap, (s.back + 0.05, s.back + 0.25), (s.height - 0.03, s.height), CHROME),
        cylinder(tap, (s.back + 0.22, s.back + 0.25), (s.height - 0.1, s.height), CHROME),
    )


@furniture(
    "stove",
    width=(0.6, 0.75),
    depth=(0.6, 0.64),
    height=(0.9, 0.92),
    rooms={"kitchen": (1, 1)},
    place=AgainstWall(beside=_ROW),
    clearance=0.8,
    essential=True,
)
def stove(s: Size, rng: Generator) -> Parts:
    """A stove: an oven with a window and knobs, and four hotplates on top."""
    body = pick(rng, (WHITE, STEEL, BLACK))
    rings = [
        cylinder(about(x, 0.18), about(y, 0.18), (s.height - 0.015, s.height), METALS[1])
        for x in (-s.width / 4, s.width / 4)
        for y in (-s.depth / 4, s.depth / 4)
    ]
    knobs = [box(about(x, 0.04), (s.front - 0.03, s.front), about(0.81, 0.04), BLACK) for x in (-0.2, -0.1, 0.0, 0.1, 0.2)]
    return (
        box(s.x, (s.back, s.front - 0.03), (0.0, s.height - 0.02), body, "metal"),
        box(s.x, s.y, (s.height - 0.03, s.height - 0.008), BLACK, "glass"),
        box(inset(s.x, 0.05), (s.front - 0.04, s.front - 0.015), (0.22, 0.68), BLACK, "glass"),
        box(inset(s.x, 0.06), (s.front - 0.03, s.front), (0.7, 0.73), CHROME),
        box(inset(s.x, 0.03), (s.front - 0.04, s.front - 0.02), (0.03, 0.18), body, "metal"),
        *rings,
        *knobs,
    )


@furniture(
    "fridge",
    width=(0.6, 0.9),
    depth=(0.62, 0.7),
    height=(1.7, 2.0),
    rooms={"kitchen": (1, 1), "pantry": 0.4, "garage": 0.15},
    place=AgainstWall(beside=_ROW, corner=True),
    clearance=0.6,
    essential=True,
)
def fridge(s: Size, rng: Generator) -> Parts:
    """A fridge above a freezer, with notes on the door."""
    body = pick(rng, (WHITE, WHITE, STEEL, (0.76, 0.2, 0.18), (0.6, 0.78, 0.74)))
    split_z = s.height * rng.uniform(0.3, 0.42)
    notes = [
        box(about(x, 0.1), (s.front - 0.014, s.front - 0.008), about(z, 0.13), pick(rng, BRIGHT), "label")
        for x, z in zip(
            rng.uniform(s.left + 0.1, s.right - 0.15, 3), rng.uniform(split_z + 0.2, s.height - 0.15, 3), strict=True
        )
    ]
    return (
        box(s.x, (s.back, s.front - 0.05), s.z, body, "metal"),
        *(
            box(inset(s.x, 0.005), (s.front - 0.045, s.front - 0.012), z, body, "metal")
            for z in ((0.05, split_z), (split_z + 0.015, s.height - 0.01))
        ),
        *(
            box((s.right - 0.08, s.right - 0.05), (s.front - 0.02, s.front), about(z, 0.3), METALS[1])
            for z in (split_z - 0.2, split_z + 0.25)
        ),
        *notes,
    )


@furniture(
    "dishwasher",
    width=(0.6, 0.6),
    depth=(0.6, 0.62),
    height=(0.88, 0.9),
    rooms={"kitchen": 0.6},
    place=AgainstWall(beside=_ROW),
    clearance=0.6,
)
def dishwasher(s: Size, rng: Generator) -> Parts:
    """A dishwasher with a white or steel front and a strip of buttons."""
    body = pick(rng, (WHITE, STEEL))
    return (
        box(s.x, (s.back, s.front - 0.02), (0.0, s.height - 0.04), body, "metal"),
        box(s.x, s.y, (s.height - 0.04, s.height), STONES[0], "marble"),
        box(inset(s.x, 0.04), (s.front - 0.03, s.front - 0.005), (0.76, 0.82), BLACK, "keyboard"),
        box(inset(s.x, 0.1), (s.front - 0.03, s.front), (0.7, 0.73), METALS[1]),
    )


@furniture(
    "upper cabinet",
    width=(0.8, 1.0),
    depth=(0.33, 0.36),
    height=(0.6, 0.75),
    rooms={"kitchen": (1, 1), "laboratory": 0.5},
    place=OnWall((1.42, 1.5), above=("kitchen counter", "kitchen sink", "dishwasher")),
)
def upper_cabinet(s: Size, rng: Generator) -> Parts:
    """A wall cupboard with two doors, or sometimes with open shelves of food and dishes."""
    front = pick(rng, FRONTS)
    if rng.random() < 0.3:
        return (*shelf_unit(s, 2, front), *stocked(s, 2, ("food", "ceramic"), WHITE, rng))
    body = box(s.x, (s.back, s.front - 0.025), s.z, front)
    return (body, *fronts(s.x, s.z, s.front - 0.005, 2, 1, front, STEEL))


@furniture(
    "cooker hood",
    width=(0.6, 0.7),
    depth=(0.4, 0.48),
    height=(0.6, 0.7),
    rooms={"kitchen": (1, 1)},
    place=OnWall((1.55, 1.65), above=("stove",)),
)
def cooker_hood(s: Size, rng: Generator) -> Parts:
    """A metal cooker hood with its flue."""
    steel = pick(rng, METALS)
    return (
        box(s.x, s.y, (0.0, 0.08), steel, "metal"),
        box(inset(s.x, 0.1), (s.back, s.front - 0.12), (0.08, 0.18), steel, "metal"),
        box(about(0.0, 0.24), (s.back, s.back + 0.24), (0.18, s.height), steel, "metal"),
    )


@furniture(
    "kitchen island",
    width=(1.2, 1.8),
    depth=(0.7, 0.9),
    height=(0.9, 0.92),
    rooms={"kitchen": 0.3},
    place=OnFloor("centre"),
)
def kitchen_island(s: Size, rng: Generator) -> Parts:
    """A free-standing worktop over drawers."""
    front = pick(rng, FRONTS)
    return (
        box(inset(s.x, 0.05), inset(s.y, 0.08), (0.0, s.height - 0.05), front),
        box(s.x, s.y, (s.height - 0.05, s.height), pick(rng, STONES), "marble"),
        *fronts(inset(s.x, 0.05), (0.1, s.height - 0.06), s.front - 0.06, 3, 2, front, STEEL),
    )


@furniture(
    "bar stool",
    width=(0.36, 0.42),
    depth=(0.36, 0.42),
    height=(0.7, 0.85),
    rooms={"kitchen": (2, 2)},
    place=Around(("kitchen island",)),
)
def bar_stool(s: Size, rng: Generator) -> Parts:
    """A bar stool: a round seat on a column."""
    return (
        cylinder(s.x, s.y, (s.height - 0.07, s.height), pick(rng, BRIGHT), "fabric"),
        cylinder(about(0.0, 0.06), about(0.0, 0.06), (0.02, s.height - 0.07), CHROME),
        cylinder(inset(s.x, 0.02), inset(s.y, 0.02), (0.0, 0.03), CHROME, "metal"),
    )


@furniture(
    "microwave",
    width=(0.45, 0.52),
    depth=(0.34, 0.4),
    height=(0.26, 0.3),
    rooms={"kitchen": 0.4},
    place=OnTop(("kitchen counter",), "back"),
)
def microwave(s: Size, rng: Generator) -> Parts:
    """A microwave oven: a window beside a panel of buttons."""
    return (
        box(s.x, (s.back, s.front - 0.02), s.z, pick(rng, (WHITE, BLACK, STEEL)), "metal"),
        box((s.left + 0.03, s.right - 0.14), (s.front - 0.03, s.front), inset(s.z, 0.04), BLACK, "glass"),
        box((s.right - 0.12, s.right - 0.02), (s.front - 0.03, s.front), inset(s.z, 0.04), METALS[1], "keyboard"),
    )


@furniture(
    "kettle",
    width=(0.16, 0.2),
    depth=(0.14, 0.16),
    height=(0.22, 0.26),
    rooms={"kitchen": 0.5},
    place=OnTop(("kitchen counter",)),
)
def kettle(s: Size, rng: Generator) -> Parts:
    """A kettle with a knob and a handle."""
    body = pick(rng, (STEEL, RED, WHITE))
    return (
        cylinder((s.left, s.right - 0.04), s.y, (0.0, s.height - 0.03), body, "metal"),
        cylinder(about(-0.02, 0.05), about(0.0, 0.05), (s.height - 0.03, s.height), BLACK),
        box((s.right - 0.03, s.right), about(0.0, 0.03), (0.04, s.height - 0.04), BLACK),
    )


@furniture(
    "toaster",
    width=(0.26, 0.32),
    depth=(0.16, 0.2),
    height=(0.18, 0.21),
    rooms={"kitchen": 0.5},
    place=OnTop(("kitchen counter",), "back"),
)
def toaster(s: Size, rng: Generator) -> Parts:
    """A toaster from which two slices of toast stick out."""
    slots = [box(inset(s.x, 0.05), about(y, 0.02), (s.height - 0.03, s.height), (0.7, 0.5, 0.25)) for y in (-0.04, 0.04)]
    return (box(s.x, s.y, (0.0, s.height - 0.02), pick(rng, (STEEL, RED, *WHITES)), "metal"), *slots)


@furniture(
    "dish rack",
    width=(0.4, 0.5),
    depth=(0.28, 0.34),
    height=(0.22, 0.26),
    rooms={"kitchen": 0.5},
    place=OnTop(("kitchen counter",), "back"),
)
def dish_rack(s: Size, rng: Generator) -> Parts:
    """A tray with plates that stand upright."""
    plates = [
        box(
            about(x, 0.02),
            inset(s.y, 0.04),
            (0.03, s.height - rng.uniform(0.0, 0.06)),
            pick(rng, (WHITE, *BRIGHT[:3])),
            "ceramic",
        )
        for x in spaced(s.left + 0.06, s.right - 0.06, 6)
    ]
    return (box(s.x, s.y, (0.0, 0.04), STEEL, "metal"), *plates)


@furniture("pot", width=(0.24, 0.34), depth=(0.2, 0.24), height=(0.14, 0.2), rooms={"kitchen": 1.2}, place=OnTop(("stove",)))
def pot(s: Size, rng: Generator) -> Parts:
    """A cooking pot with a lid and two handles."""
    body = pick(rng, (STEEL, RED, BLACK, BRIGHT[2]))
    return (
        cylinder(inset(s.x, 0.03), s.y, (0.0, s.height - 0.04), body, "metal"),
        cylinder(inset(s.x, 0.03), s.y, (s.height - 0.045, s.height - 0.025), STEEL, "metal"),
        cylinder(about(0.0, 0.04), about(0.0, 0.04), (s.height - 0.03, s.height), BLACK),
        box(s.x, about(0.0, 0.05), about(0.65 * s.height, 0.02), BLACK),
    )


@furniture(
    "fruit bowl",
    width=(0.26, 0.32),
    depth=(0.26, 0.32),
    height=(0.14, 0.18),
    rooms={"kitchen": 0.5, "dining room": 0.6},
    place=OnTop(("kitchen counter", "kitchen island", "dining table", "sideboard")),
)
def fruit_bowl(s: Size, rng: Generator) -> Parts:
    """A bowl of apples, oranges and lemons."""
    fruit = [
        ball(about(x, 0.08), about(y, 0.08), (s.height - 0.1, s.height - 0.01), pick(rng, BRIGHT))
        for x, y in rng.uniform(-0.07, 0.07, (5, 2)).tolist()
    ]
    return (cylinder(s.x, s.y, (0.0, 0.08), pick(rng, WHITES), "ceramic"), *fruit)


@furniture(
    "bottles",
    width=(0.2, 0.34),
    depth=(0.08, 0.1),
    height=(0.24, 0.32),
    rooms={"kitchen": 1.0, "dining room": 0.5},
    place=OnTop(("kitchen counter", "sideboard", "dining table")),
)
def bottles(s: Size, rng: Generator) -> Parts:
    """Three or four bottles in a row."""
    parts: list[Part] = []
    for x in split(s.x, int(rng.integers(3, 5)), 0.015):
        colour = pick(rng, ((0.2, 0.4, 0.2), (0.4, 0.2, 0.1), GLASS, *BRIGHT[:3]))
        middle, wide, top = (x[0] + x[1]) / 2, min(x[1] - x[0], s.depth), s.height * rng.uniform(0.75, 1.0)
        parts += [
            cylinder(about(middle, wide), about(0.0, wide), (0.0, 0.62 * top), colour, "label"),
            cylinder(about(middle, 0.4 * wide), about(0.0, 0.4 * wide), (0.62 * top, top), colour),
        ]
    return tuple(parts)


@furniture(
    "spice rack",
    width=(0.4, 0.6),
    depth=(0.1, 0.12),
    height=(0.35, 0.5),
    rooms={"kitchen": (1, 2), "pantry": (1, 2)},
    place=OnWall((1.3, 1.5)),
)
def spice_rack(s: Size, rng: Generator) -> Parts:
    """Two small shelves of jars."""
    return (*shelf_unit(s, 2, pick(rng, WOODS), board=0.015), *stocked(s, 2, ("food",), WHITE, rng, board=0.015, fill=1.0))


@furniture(
    "pan rail", width=(0.6, 0.9), depth=(0.06, 0.08), height=(0.4, 0.5), rooms={"kitchen": (1, 2)}, place=OnWall((1.3, 1.4))
)
def pan_rail(s: Size, rng: Generator) -> Parts:
    """A rail from which pans and ladles hang."""
    hung = [
        box(
            inset(x, 0.01),
            (s.back + 0.01, s.front),
            (s.height - rng.uniform(0.2, 0.95) * s.height, s.height - 0.02),
            pick(rng, (*METALS, RED)),
            "metal",
        )
        for x in split(s.x, 5, 0.05)
    ]
    return (box(s.x, (s.back, s.back + 0.03), (s.height - 0.03, s.height), STEEL, "metal"), *hung)


@furniture(
    "pantry shelf",
    width=(0.8, 1.4),
    depth=(0.32, 0.42),
    height=(1.7, 2.1),
    rooms={"pantry": (2, 4), "kitchen": 0.35},
    place=AgainstWall(beside=("pantry shelf",)),
    clearance=0.5,
)
def pantry_shelf(s: Size, rng: Generator) -> Parts:
    """Shelves full of packets, bottles and jars."""
    return (*shelf_unit(s, 5, pick(rng, WOODS)), *stocked(s, 5, ("food",), WHITE, rng, fill=0.95))


@furniture(
    "crate",
    width=(0.4, 0.55),
    depth=(0.3, 0.4),
    height=(0.25, 0.35),
    rooms={"pantry": (1, 2), "storage room": 0.7, "garage": 0.6},
)
def crate(s: Size, rng: Generator) -> Parts:
    """A slatted wooden box of fruit or vegetables."""
    wood = pick(rng, WOODS)
    slats = [box(s.x, s.y, z, wood, "wood") for z in split((0.0, s.height - 0.06), 3, 0.03)]
    goods = [ball(x, inset(s.y, 0.04), (s.height - 0.16, s.height), pick(rng, BRIGHT)) for x in split(inset(s.x, 0.03), 3)]
    return (*slats, *goods)


@furniture("kitchen trolley", width=(0.5, 0.7), depth=(0.38, 0.45), height=(0.8, 0.88), rooms={"kitchen": 0.25})
def kitchen_trolley(s: Size, rng: Generator) -> Parts:
    """A trolley: two shelves of goods under a board."""
    wood = pick(rng, WOODS)
    return (
        *legs(s, s.height - 0.04, 0.04, wood),
        box(s.x, s.y, (s.height - 0.04, s.height), wood, "wood"),
        *(box(inset(s.x, 0.03), inset(s.y, 0.03), (z, z + 0.02), STEEL, "metal") for z in (0.15, 0.45)),
        *(box(inset(s.x, 0.07), inset(s.y, 0.06), (z, z + 0.18), WHITE, "food") for z in (0.17, 0.47)),
    )
