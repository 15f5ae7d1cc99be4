"""Furniture and equipment of laundry rooms, storage rooms and garages."""

from numpy.random import Generator

from worlds.furniture.kinds import AgainstWall, OnFloor, OnTop, OnWall, Parts, Size
from worlds.furniture.palette import (
    BLACK,
    BRIGHT,
    CARDBOARD,
    CHROME,
    GLASS,
    GREY,
    LINEN,
    METALS,
    RED,
    STEEL,
    WHITE,
    WOODS,
    pick,
)
from worlds.furniture.registry import furniture
from worlds.furniture.shapes import about, box, cylinder, ends, fronts, inset, legs, octagon, shelf_unit, split, stocked
from worlds.parts import Colour, Part

_MACHINES = ("washing machine", "tumble dryer")


def _machine(s: Size, body: Colour, door: Colour) -> Parts:
    middle = 0.42
    rings = [
        box(x, (s.front - 0.03, s.front - 0.004 * i), z, CHROME, "metal")
        for i, (x, z) in enumerate(octagon(0.0, middle, 0.36, narrow=0.6, diagonal=0.84), start=1)
    ]
    return (
        box(s.x, (s.back, s.front - 0.025), s.z, body, "metal"),
        *rings,
        box(about(0.0, 0.25), (s.front - 0.03, s.front), about(middle, 0.25), door, "glass"),
        box(inset(s.x, 0.02), (s.front - 0.03, s.front - 0.012), (s.height - 0.13, s.height - 0.02), GREY, "keyboard"),
        box((s.left + 0.04, s.left + 0.2), (s.front - 0.02, s.front - 0.006), (s.height - 0.12, s.height - 0.03), body),
    )


@furniture(
    "washing machine",
    width=(0.6, 0.62),
    depth=(0.58, 0.64),
    height=(0.85, 0.87),
    rooms={"laundry room": (1, 2), "bathroom": 0.25, "kitchen": 0.08},
    place=AgainstWall(beside=_MACHINES),
    clearance=0.6,
    essential=True,
)
def washing_machine(s: Size, rng: Generator) -> Parts:
    """A washing machine with a dark round window at the front."""
    return _machine(s, pick(rng, (WHITE, WHITE, STEEL)), (0.25, 0.3, 0.36))


@furniture(
    "tumble dryer",
    width=(0.6, 0.62),
    depth=(0.58, 0.64),
    height=(0.85, 0.87),
    rooms={"laundry room": (1, 1)},
    place=AgainstWall(beside=_MACHINES),
    clearance=0.6,
)
def tumble_dryer(s: Size, rng: Generator) -> Parts:
    """A tumble dryer: like the washing machine, but with a pale window."""
    return _machine(s, pick(rng, (WHITE, WHITE, STEEL)), GLASS)


@furniture(
    "laundry basket",
    width=(0.4, 0.5),
    depth=(0.36, 0.44),
    height=(0.45, 0.6),
    rooms={"laundry room": (1, 2), "bathroom": 0.6, "bedroom": 0.2},
    place=AgainstWall(corner=True),
)
def laundry_basket(s: Size, rng: Generator) -> Parts:
    """A basket full of laundry."""
    return (
        box(s.x, s.y, (0.0, s.height - 0.1), pick(rng, (WHITE, *WOODS)), "fabric"),
        *(
            box(
                x,
                inset(s.y, 0.03),
                (s.height - 0.12, s.height - rng.uniform(0.0, 0.06)),
                pick(rng, (*LINEN, *BRIGHT)),
                "fabric",
            )
            for x in split(inset(s.x, 0.03), 3)
        ),
    )


@furniture(
    "ironing board",
    width=(1.2, 1.35),
    depth=(0.36, 0.42),
    height=(0.98, 1.05),
    rooms={"laundry room": (1, 1), "storage room": 0.2},
    place=OnFloor(),
    clearance=0.3,
)
def ironing_board(s: Size, rng: Generator) -> Parts:
    """An ironing board with an iron on it."""
    top = s.height - 0.14
    return (
        box(s.x, s.y, (top - 0.05, top), pick(rng, LINEN), "fabric"),
        *(box(about(x, 0.04), inset(s.y, 0.03), (0.0, top - 0.05), CHROME, "metal") for x in (-0.3, 0.3)),
        box((s.right - 0.4, s.right - 0.16), about(0.0, 0.11), (top, top + 0.06), pick(rng, BRIGHT)),
        box((s.right - 0.36, s.right - 0.18), about(0.0, 0.04), (top + 0.1, s.height), BLACK),
        box((s.right - 0.36, s.right - 0.32), about(0.0, 0.04), (top + 0.06, s.height), BLACK),
    )


@furniture(
    "drying rack",
    width=(1.1, 1.5),
    depth=(0.5, 0.6),
    height=(0.95, 1.1),
    rooms={"laundry room": (1, 1), "balcony": 0.4, "bathroom": 0.08},
    place=OnFloor(),
)
def drying_rack(s: Size, rng: Generator) -> Parts:
    """A drying rack with wet clothes on its lines."""
    clothes = [
        box(
            (x[0], x[0] + rng.uniform(0.4, 0.95) * (x[1] - x[0])),
            (y - 0.008, y + 0.008),
            (s.height * rng.uniform(0.3, 0.6), s.height),
            pick(rng, (*LINEN, *BRIGHT)),
            "fabric",
        )
        for y in (-0.36 * s.depth, 0.0, 0.36 * s.depth)
        for x in split(inset(s.x, 0.03), 3, 0.03)
    ]
    return (
        *legs(s, s.height - 0.02, 0.02, CHROME, "metal", margin=0.0),
        *(box(x, s.y, (s.height - 0.03, s.height - 0.01), CHROME) for x in ends(s.x, 0.02)),
        *clothes,
    )


@furniture(
    "utility sink",
    width=(0.55, 0.7),
    depth=(0.45, 0.55),
    height=(1.05, 1.12),
    rooms={"laundry room": (1, 1), "garage": 0.3, "classroom": 0.3},
    place=AgainstWall(beside=_MACHINES),
    clearance=0.5,
)
def utility_sink(s: Size, rng: Generator) -> Parts:
    """A deep sink on legs."""
    return (
        *legs(s, 0.5, 0.05, STEEL, "metal"),
        box(s.x, s.y, (0.5, 0.86), WHITE, "ceramic"),
        box(inset(s.x, 0.06), inset(s.y, 0.06), (0.86, 0.865), (0.6, 0.68, 0.72), "ceramic"),
        box(about(0.0, 0.04), (s.back + 0.01, s.back + 0.05), (0.86, s.height), CHROME, "metal"),
        box(about(0.0, 0.04), (s.back + 0.01, s.back + 0.22), (s.height - 0.05, s.height), CHROME, "metal"),
    )


@furniture(
    "detergents",
    width=(0.3, 0.45),
    depth=(0.14, 0.18),
    height=(0.24, 0.32),
    rooms={"laundry room": 0.8},
    place=OnTop(_MACHINES, "back"),
)
def detergents(s: Size, rng: Generator) -> Parts:
    """Three packs of detergent, side by side."""
    return tuple(
        box(x, inset(s.y, 0.01), (0.0, s.height * rng.uniform(0.7, 1.0)), pick(rng, BRIGHT), "label")
        for x in split(s.x, 3, 0.02)
    )


@furniture(
    "folded laundry",
    width=(0.34, 0.45),
    depth=(0.3, 0.38),
    height=(0.16, 0.32),
    rooms={"laundry room": 1.0, "bedroom": 0.4},
    place=OnTop((*_MACHINES, "dresser")),
)
def folded_laundry(s: Size, rng: Generator) -> Parts:
    """A pile of towels and shirts."""
    return tuple(
        box(inset(s.x, rng.uniform(0.0, 0.03)), inset(s.y, rng.uniform(0.0, 0.03)), z, pick(rng, LINEN), "fabric")
        for z in split(s.z, 5, 0.004)
    )


@furniture(
    "mop bucket",
    width=(0.3, 0.38),
    depth=(0.28, 0.34),
    height=(1.2, 1.35),
    rooms={"laundry room": 0.7, "storage room": (1, 1), "pantry": 0.3, "garage": 0.4},
    place=AgainstWall(corner=True),
)
def mop_bucket(s: Size, rng: Generator) -> Parts:
    """A bucket with a mop standing in it."""
    return (
        cylinder(s.x, s.y, (0.0, 0.28), pick(rng, BRIGHT)),
        cylinder(about(0.0, 0.14), about(0.0, 0.14), (0.24, 0.38), LINEN[0], "carpet"),
        cylinder(about(0.0, 0.03), about(0.0, 0.03), (0.3, s.height), WOODS[0], "wood"),
    )


@furniture(
    "vacuum cleaner",
    width=(0.28, 0.34),
    depth=(0.36, 0.44),
    height=(1.0, 1.15),
    rooms={"storage room": 0.7, "laundry room": 0.4, "corridor": 0.1},
    place=AgainstWall(corner=True),
)
def vacuum_cleaner(s: Size, rng: Generator) -> Parts:
    """A vacuum cleaner: a body, and an upright tube on a floor nozzle."""
    paint = pick(rng, BRIGHT)
    return (
        box(inset(s.x, 0.02), (s.back, s.front - 0.06), (0.04, 0.28), paint),
        cylinder(inset(s.x, 0.05), inset(s.y, 0.1), (0.26, 0.34), BLACK),
        box(s.x, (s.front - 0.12, s.front), (0.0, 0.05), BLACK),
        cylinder(about(0.0, 0.04), (s.front - 0.08, s.front - 0.04), (0.05, s.height), CHROME, "metal"),
    )


@furniture(
    "metal shelf",
    width=(0.9, 1.4),
    depth=(0.38, 0.5),
    height=(1.7, 2.0),
    rooms={"storage room": (2, 4), "garage": (1, 2), "laundry room": 0.4, "laboratory": 0.4, "print room": 0.5},
    place=AgainstWall(beside=("metal shelf",)),
    clearance=0.5,
)
def metal_shelf(s: Size, rng: Generator) -> Parts:
    """An open metal shelf with boxes of many colours."""
    steel = pick(rng, METALS)
    boards = [
        box(s.x, s.y, (z, z + 0.03), steel, "metal")
        for z in (0.1, 0.1 + 0.3 * s.height, 0.1 + 0.6 * s.height, s.height - 0.03)
    ]
    goods: list[Part] = []
    for low, high in zip((0.13, 0.13 + 0.3 * s.height, 0.13 + 0.6 * s.height), (0.3, 0.6, 0.9), strict=True):
        for x in split(inset(s.x, 0.05), 3, 0.03):
            top = low + rng.uniform(0.45, 0.95) * (high * s.height - low + 0.05)
            if rng.random() < 0.9:
                goods.append(
                    box(
                        inset(x, rng.uniform(0.0, 0.05)),
                        (s.back + 0.02, s.front - rng.uniform(0.02, 0.1)),
                        (low, top),
                        pick(rng, (CARDBOARD, CARDBOARD, *BRIGHT, GREY)),
                        "label",
                    )
                )
    return (*legs(s, s.height, 0.04, steel, "metal", margin=0.0), *boards, *goods)


@furniture(
    "cardboard boxes",
    width=(0.5, 0.7),
    depth=(0.4, 0.55),
    height=(0.6, 1.2),
    rooms={"storage room": (2, 4), "garage": 1.0, "laundry room": 0.2, "pantry": 0.4, "office": 0.08},
    place=AgainstWall(corner=True),
)
def cardboard_boxes(s: Size, rng: Generator) -> Parts:
    """A stack of cardboard boxes that are not quite aligned."""
    return tuple(
        box(
            (s.left + rng.uniform(0.0, 0.08), s.right - rng.uniform(0.0, 0.08)),
            (s.back + rng.uniform(0.0, 0.05), s.front - rng.uniform(0.0, 0.06)),
            z,
            CARDBOARD,
            "label",
        )
        for z in split(s.z, max(2, round(s.height / 0.35)), 0.004)
    )


@furniture(
    "ladder",
    width=(0.45, 0.55),
    depth=(0.12, 0.16),
    height=(1.8, 2.2),
    rooms={"storage room": 0.7, "garage": 0.6, "library": 0.5},
)
def ladder(s: Size, rng: Generator) -> Parts:
    """A folded ladder that stands against the wall."""
    metal = pick(rng, (CHROME, WOODS[0], BRIGHT[1]))
    rails = [box(x, s.y, s.z, metal, "metal") for x in ends(s.x, 0.04)]
    return (
        *rails,
        *(box(s.x, inset(s.y, 0.02), about(z, 0.03), metal, "metal") for z in (0.3, 0.6, 0.9, 1.2, 1.5, s.height - 0.15)),
    )


@furniture(
    "tool board",
    width=(1.0, 1.6),
    depth=(0.06, 0.1),
    height=(0.7, 0.9),
    rooms={"garage": (2, 3), "storage room": 0.6},
    place=OnWall((1.1, 1.3)),
)
def tool_board(s: Size, rng: Generator) -> Parts:
    """A board on the wall with two rows of tools."""
    tools: list[Part] = []
    for x in split(inset(s.x, 0.05), 8, 0.03):
        for z in split(inset(s.z, 0.05), 2, 0.06):
            wide, high = (x[1] - x[0]) * rng.uniform(0.2, 0.9), (z[1] - z[0]) * rng.uniform(0.5, 1.0)
            tools.append(
                box(
                    (x[0], x[0] + wide),
                    (s.back + 0.02, s.front),
                    (z[1] - high, z[1]),
                    pick(rng, (*METALS, *BRIGHT, RED)),
                    "metal",
                )
            )
    return (box(s.x, (s.back, s.back + 0.02), s.z, pick(rng, (GREY, *WOODS)), "label"), *tools)


@furniture(
    "workbench",
    width=(1.4, 2.0),
    depth=(0.6, 0.7),
    height=(0.86, 0.92),
    rooms={"garage": (1, 1), "storage room": 0.3, "laboratory": 0.2},
    clearance=0.7,
)
def workbench(s: Size, rng: Generator) -> Parts:
    """A workbench with a thick top, a vice, and boxes underneath."""
    wood = pick(rng, WOODS)
    return (
        box(s.x, s.y, (s.height - 0.14, s.height - 0.08), wood, "wood"),
        *legs(s, s.height - 0.14, 0.09, wood),
        box(inset(s.x, 0.05), inset(s.y, 0.05), (0.2, 0.23), wood, "wood"),
        *(
            box(
                inset(x, 0.04),
                inset(s.y, 0.08),
                (0.23, rng.uniform(0.4, 0.6)),
                pick(rng, (RED, *BRIGHT, CARDBOARD)),
                "label",
            )
            for x in split(inset(s.x, 0.1), 3)
        ),
        box((s.left + 0.1, s.left + 0.3), (0.05, s.front), (s.height - 0.08, s.height), (0.25, 0.35, 0.5), "metal"),
        box((0.1, 0.45), (s.back + 0.1, 0.1), (s.height - 0.08, s.height), RED, "metal"),
    )


@furniture(
    "car",
    width=(1.65, 1.8),
    depth=(3.6, 4.2),
    height=(1.4, 1.5),
    rooms={"garage": (1, 1)},
    place=OnFloor("centre"),
    essential=True,
)
def car(s: Size, rng: Generator) -> Parts:
    """A car: body, cabin, four wheels, lights and number plates."""
    paint = pick(rng, (*BRIGHT[:4], STEEL, WHITE, BLACK))
    wheels = [
        box(x, y, z, BLACK)
        for x in ends(s.x, 0.2)
        for axle in (s.back + 0.75, s.front - 0.75)
        for y, z in octagon(axle, 0.32, 0.64)
    ]
    lights = [box(x, (s.front - 0.04, s.front), (0.62, 0.78), (1.0, 0.98, 0.85)) for x in ends(s.x, 0.45, margin=0.1)]
    tails = [box(x, (s.back, s.back + 0.04), (0.65, 0.8), RED) for x in ends(s.x, 0.4, margin=0.08)]
    cabin_y = (s.back + 0.35, s.front - 1.25)
    return (
        box(inset(s.x, 0.02), inset(s.y, 0.03), (0.25, 0.92), paint, "metal"),
        box(inset(s.x, 0.14), cabin_y, (0.92, s.height - 0.06), (0.2, 0.25, 0.3), "glass"),
        box(inset(s.x, 0.12), inset(cabin_y, 0.08), (s.height - 0.06, s.height), paint, "metal"),
        *(box(about(0.0, 0.5), y, (0.4, 0.52), WHITE, "label") for y in ends(s.y, 0.03)),
        box(inset(s.x, 0.3), (s.front - 0.035, s.front - 0.005), (0.55, 0.68), BLACK, "keyboard"),
        *wheels,
        *lights,
        *tails,
    )


@furniture(
    "bicycle",
    width=(1.5, 1.7),
    depth=(0.4, 0.5),
    height=(0.95, 1.05),
    rooms={"garage": (1, 2), "storage room": 0.4, "garden": 0.3, "corridor": 0.05},
)
def bicycle(s: Size, rng: Generator) -> Parts:
    """A bicycle: wheels, frame, saddle and handlebar."""
    paint = pick(rng, BRIGHT)
    parts: list[Part] = []
    for middle in (s.left + 0.33, s.right - 0.33):
        disc = octagon(middle, 0.33, 0.64, diagonal=0.76)
        parts += [box(x, about(0.0, 0.035), z, BLACK, "metal") for x, z in disc]
        parts.append(box(about(middle, 0.42), about(0.0, 0.038), about(0.33, 0.42), (0.8, 0.8, 0.8), "metal"))
    return (
        *parts,
        box((s.left + 0.45, s.right - 0.4), about(0.0, 0.04), (0.66, 0.7), paint),
        box(about(-0.15, 0.04), about(0.0, 0.04), (0.25, 0.85), paint),
        box((s.left + 0.33, -0.13), about(0.0, 0.04), (0.3, 0.34), paint),
        box(about(s.right - 0.42, 0.04), about(0.0, 0.04), (0.3, s.height - 0.05), paint),
        box(about(-0.15, 0.24), about(0.0, 0.14), (0.85, 0.92), BLACK),
        box(about(s.right - 0.42, 0.05), s.y, (s.height - 0.05, s.height), BLACK),
    )


@furniture(
    "tyre stack",
    width=(0.58, 0.66),
    depth=(0.58, 0.66),
    height=(0.6, 0.85),
    rooms={"garage": (1, 1)},
    place=AgainstWall(corner=True),
)
def tyre_stack(s: Size, rng: Generator) -> Parts:
    """A stack of four tyres."""
    return tuple(
        cylinder(inset(s.x, d), inset(s.y, d), z, BLACK, "label")
        for z, d in zip(split(s.z, 4, 0.02), (0.0, 0.01, 0.0, 0.015), strict=True)
    )


@furniture(
    "lawn mower",
    width=(0.5, 0.56),
    depth=(1.1, 1.3),
    height=(0.95, 1.05),
    rooms={"garage": 0.7, "garden": 0.3, "storage room": 0.1},
    place=AgainstWall(corner=True),
)
def lawn_mower(s: Size, rng: Generator) -> Parts:
    """A lawn mower: a body with a motor, on four wheels, and a push bar."""
    paint = pick(rng, BRIGHT)
    return (
        box(inset(s.x, 0.05), (s.front - 0.7, s.front), (0.1, 0.3), paint, "metal"),
        cylinder(about(0.0, 0.3), about(s.front - 0.3, 0.3), (0.3, 0.45), BLACK, "metal"),
        *(cylinder(x, about(y, 0.2), (0.0, 0.2), BLACK) for x in ends(s.x, 0.07) for y in (s.front - 0.12, s.front - 0.6)),
        *(box(about(x, 0.03), (s.back, s.back + 0.03), (0.25, s.height), BLACK) for x in (-0.2, 0.2)),
        *(box(about(x, 0.03), (s.back, s.front - 0.6), (0.25, 0.28), BLACK) for x in (-0.2, 0.2)),
        box(about(0.0, 0.43), (s.back, s.back + 0.03), (s.height - 0.03, s.height), BLACK),
    )


@furniture(
    "tool chest",
    width=(0.65, 0.8),
    depth=(0.42, 0.5),
    height=(0.9, 1.1),
    rooms={"garage": (1, 1), "laboratory": 0.2},
    clearance=0.4,
)
def tool_chest(s: Size, rng: Generator) -> Parts:
    """A chest of six metal drawers, often red, on short feet."""
    paint = pick(rng, (RED, RED, BRIGHT[2], METALS[1]))
    return (
        box(s.x, (s.back, s.front - 0.025), (0.08, s.height), paint, "metal"),
        *legs(s, 0.08, 0.06, BLACK),
        *fronts(s.x, (0.1, s.height - 0.02), s.front - 0.004, 1, 6, paint, CHROME, "metal"),
    )


@furniture(
    "paint cans",
    width=(0.3, 0.45),
    depth=(0.18, 0.24),
    height=(0.18, 0.38),
    rooms={"garage": 1.0, "storage room": 1.0},
    place=AgainstWall(beside=("metal shelf", "workbench")),
    solid=False,
)
def paint_cans(s: Size, rng: Generator) -> Parts:
    """Four cans of paint in two stacks."""
    return tuple(
        cylinder(x, about(0.0, min(x[1] - x[0], s.depth)), z, pick(rng, BRIGHT), "label")
        for x in split(s.x, 2, 0.01)
        for z in split(s.z, 2, 0.005)
    )


@furniture(
    "boiler",
    width=(0.5, 0.6),
    depth=(0.36, 0.44),
    height=(0.8, 0.95),
    rooms={"laundry room": 0.4, "garage": 0.3, "storage room": 0.3},
    place=OnWall((1.2, 1.4), above=("tumble dryer", "utility sink", "workbench")),
)
def boiler(s: Size, rng: Generator) -> Parts:
    """A boiler: a white case above its pipes."""
    pipes = [
        cylinder(about(x, 0.03), (s.back + 0.05, s.back + 0.08), (0.0, 0.22), (0.72, 0.45, 0.25), "metal")
        for x in (-0.15, -0.05, 0.05, 0.15)
    ]
    return (
        box(s.x, (s.back, s.front - 0.01), (0.2, s.height), WHITE, "metal"),
        box(about(0.0, 0.2), (s.front - 0.01, s.front), (0.3, 0.38), BLACK, "screen"),
        *pipes,
    )


@furniture(
    "suitcase",
    width=(0.45, 0.55),
    depth=(0.24, 0.3),
    height=(0.65, 0.78),
    rooms={"storage room": (1, 2), "bedroom": 0.3, "entrance hall": 0.2},
)
def suitcase(s: Size, rng: Generator) -> Parts:
    """A suitcase with two straps and a handle, on short feet."""
    paint = pick(rng, (*BRIGHT, BLACK))
    return (
        box(s.x, s.y, (0.05, s.height - 0.06), paint, "fabric"),
        *(box(about(x, 0.04), (s.back, s.front), (0.05, s.height - 0.055), BLACK) for x in (-0.12, 0.12)),
        box(about(0.0, 0.16), about(0.0, 0.04), (s.height - 0.06, s.height), BLACK),
        *legs(s, 0.05, 0.05, BLACK),
    )


@furniture("plastic bins", width=(0.7, 1.0), depth=(0.4, 0.5), height=(0.4, 0.6), rooms={"storage room": 0.8, "garage": 0.3})
def plastic_bins(s: Size, rng: Generator) -> Parts:
    """Two plastic bins with coloured lids."""
    parts: list[Part] = []
    for x in split(s.x, 2, 0.02):
        lid = pick(rng, BRIGHT)
        parts += [
            box(inset(x, 0.015), inset(s.y, 0.015), (0.0, s.height - 0.04), (0.82, 0.86, 0.9), "label"),
            box(x, s.y, (s.height - 0.04, s.height), lid),
        ]
    return (*parts,)


@furniture(
    "cleaning shelf",
    width=(0.6, 0.9),
    depth=(0.26, 0.32),
    height=(1.5, 1.8),
    rooms={"laundry room": 0.8, "storage room": 0.5, "bathroom": 0.15},
    clearance=0.4,
)
def cleaning_shelf(s: Size, rng: Generator) -> Parts:
    """A shelf with bottles, cloths and packets for cleaning."""
    return (*shelf_unit(s, 4, WHITE), *stocked(s, 4, ("food", "fabric", "label"), WHITE, rng, fill=0.9))
