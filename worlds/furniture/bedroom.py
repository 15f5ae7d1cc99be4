"""Furniture of bedrooms and children's rooms."""

from numpy.random import Generator

from worlds.furniture.kinds import AgainstWall, Around, OnFloor, OnTop, OnWall, Parts, Size
from worlds.furniture.palette import BLACK, BRIGHT, FRONTS, GLASS, LINEN, STEEL, UPHOLSTERY, WHITE, WOODS, pick
from worlds.furniture.registry import furniture
from worlds.furniture.shapes import (
    about,
    ball,
    box,
    cone,
    cylinder,
    ends,
    fronts,
    inset,
    legs,
    shelf_unit,
    spaced,
    split,
    stocked,
)
from worlds.parts import Colour, Part


def _bedding(s: Size, rng: Generator, low: float, pillows: int) -> Parts:
    sheet, cover = pick(rng, LINEN), pick(rng, (*LINEN, *UPHOLSTERY))
    return (
        box(inset(s.x, 0.03), (s.back + 0.06, s.front - 0.03), (low, low + 0.22), sheet, "fabric"),
        box(inset(s.x, 0.015), (s.back + 0.65, s.front - 0.015), (low + 0.05, low + 0.27), cover, "fabric"),
        box(inset(s.x, 0.012), (s.back + 0.6, s.back + 0.85), (low + 0.2, low + 0.3), sheet, "fabric"),
        *(
            box(inset(x, 0.05), (s.back + 0.1, s.back + 0.5), (low + 0.22, low + 0.35), WHITE, "fabric")
            for x in split(inset(s.x, 0.04), pillows)
        ),
    )


@furniture(
    "double bed",
    width=(1.5, 1.8),
    depth=(2.05, 2.15),
    height=(0.95, 1.15),
    rooms={"bedroom": (1, 1)},
    place=AgainstWall(can_stand_free=True),
    clearance=0.4,
    essential=True,
)
def double_bed(s: Size, rng: Generator) -> Parts:
    """A double bed: head board, mattress, duvet and two pillows."""
    wood = pick(rng, WOODS)
    head = (wood, "wood") if rng.random() < 0.5 else (pick(rng, UPHOLSTERY), "fabric")
    return (
        box(s.x, (s.back + 0.05, s.front), (0.1, 0.3), wood, "wood"),
        box(s.x, (s.back, s.back + 0.07), (0.0, s.height), *head),
        *legs(s, 0.1, 0.07, wood),
        *_bedding(s, rng, 0.3, 2),
    )


@furniture(
    "single bed",
    width=(0.9, 1.0),
    depth=(1.9, 2.0),
    height=(0.75, 0.9),
    rooms={"children's room": (1, 1)},
    place=AgainstWall(corner=True, can_stand_free=True),
    clearance=0.3,
    essential=True,
)
def single_bed(s: Size, rng: Generator) -> Parts:
    """A single bed: a frame with a coloured cover and one pillow."""
    frame = pick(rng, (WHITE, *BRIGHT, *WOODS))
    return (
        box(s.x, (s.back + 0.05, s.front), (0.12, 0.28), frame, "wood"),
        box(s.x, (s.back, s.back + 0.05), (0.0, s.height), frame, "wood"),
        box(s.x, (s.front - 0.04, s.front), (0.0, 0.55), frame, "wood"),
        *_bedding(s, rng, 0.28, 1),
    )


@furniture(
    "bunk bed",
    width=(0.9, 1.0),
    depth=(1.95, 2.05),
    height=(1.6, 1.75),
    rooms={"children's room": 0.4},
    place=AgainstWall(corner=True),
    clearance=0.4,
)
def bunk_bed(s: Size, rng: Generator) -> Parts:
    """A bunk bed: two berths and a ladder."""
    frame = pick(rng, (WHITE, *BRIGHT, *WOODS))
    rungs = [box(about(0.0, 0.36), (s.front - 0.03, s.front), about(z, 0.03), frame, "wood") for z in (0.3, 0.6, 0.9, 1.2)]
    berths: list[Part] = []
    for low in (0.3, 1.15):
        berths += [
            box(s.x, inset(s.y, 0.03), (low - 0.1, low), frame, "wood"),
            box(inset(s.x, 0.04), inset(s.y, 0.08), (low, low + 0.14), pick(rng, LINEN), "fabric"),
            box(inset(s.x, 0.03), (s.back + 0.6, s.front - 0.06), (low + 0.03, low + 0.18), pick(rng, BRIGHT), "fabric"),
            box(inset(s.x, 0.15), (s.back + 0.12, s.back + 0.45), (low + 0.14, low + 0.25), WHITE, "fabric"),
        ]
    guard = box((s.left, s.left + 0.03), inset(s.y, 0.05), (1.38, 1.5), frame, "wood")
    return (*legs(s, s.height, 0.06, frame, margin=0.0), *berths, *rungs, guard)


@furniture(
    "nightstand",
    width=(0.4, 0.5),
    depth=(0.36, 0.42),
    height=(0.5, 0.6),
    rooms={"bedroom": (2, 2), "children's room": 0.4},
    place=AgainstWall(beside=("double bed", "single bed")),
)
def nightstand(s: Size, rng: Generator) -> Parts:
    """A nightstand with two drawers."""
    wood = pick(rng, (*WOODS, WHITE))
    return (box(s.x, (s.back, s.front - 0.025), s.z, wood, "wood"), *fronts(s.x, s.z, s.front - 0.005, 1, 2, wood, BLACK))


@furniture(
    "wardrobe",
    width=(1.2, 2.0),
    depth=(0.56, 0.62),
    height=(1.95, 2.2),
    rooms={"bedroom": (1, 1), "children's room": 0.8, "entrance hall": 0.3},
    place=AgainstWall(corner=True),
    clearance=0.6,
)
def wardrobe(s: Size, rng: Generator) -> Parts:
    """A wardrobe with two to four doors; sometimes one door has a mirror."""
    wood = pick(rng, (*WOODS, WHITE, *FRONTS[1:4]))
    columns = max(2, round(s.width / 0.5))
    doors = fronts(s.x, (0.08, s.height - 0.04), s.front - 0.005, columns, 1, wood, STEEL)
    glass = (
        ()
        if rng.random() < 0.6
        else (
            box(
                inset(split(s.x, columns)[0], 0.04),
                (s.front - 0.012, s.front - 0.003),
                (0.2, s.height - 0.15),
                GLASS,
                "glass",
            ),
        )
    )
    return (box(s.x, (s.back, s.front - 0.025), s.z, wood, "wood"), *doors, *glass)


@furniture(
    "dresser",
    width=(0.9, 1.3),
    depth=(0.42, 0.5),
    height=(0.8, 1.0),
    rooms={"bedroom": 0.8, "children's room": 0.5},
    clearance=0.5,
)
def dresser(s: Size, rng: Generator) -> Parts:
    """A chest of drawers: eight drawers in two columns."""
    wood = pick(rng, (*WOODS, WHITE))
    return (
        box(s.x, (s.back, s.front - 0.025), s.z, wood, "wood"),
        *fronts(s.x, (0.05, s.height - 0.03), s.front - 0.005, 2, 4, wood, BLACK),
    )


@furniture("vanity", width=(0.9, 1.1), depth=(0.42, 0.48), height=(1.4, 1.5), rooms={"bedroom": 0.3}, clearance=0.6)
def vanity(s: Size, rng: Generator) -> Parts:
    """A dressing table with drawers, a mirror and bottles."""
    wood = pick(rng, (WHITE, *WOODS))
    table = Size(s.width, s.depth, 0.76)
    return (
        *legs(table, 0.6, 0.05, wood),
        box(s.x, (s.back, s.front - 0.02), (0.6, 0.76), wood, "wood"),
        *fronts(s.x, (0.61, 0.75), s.front - 0.005, 3, 1, wood, BLACK),
        box(inset(s.x, 0.18), (s.back, s.back + 0.03), (0.76, s.height), wood, "wood"),
        box(inset(s.x, 0.21), (s.back + 0.03, s.back + 0.035), (0.8, s.height - 0.03), GLASS, "glass"),
        *(
            cylinder(about(x, 0.05), about(0.05, 0.05), (0.76, 0.86), pick(rng, BRIGHT), "label")
            for x in (s.left + 0.1, s.left + 0.2, s.right - 0.12)
        ),
    )


@furniture(
    "bed bench",
    width=(1.0, 1.3),
    depth=(0.36, 0.42),
    height=(0.42, 0.48),
    rooms={"bedroom": 0.35},
    place=Around(("double bed",), "front", gap_m=0.05),
)
def bed_bench(s: Size, rng: Generator) -> Parts:
    """An upholstered bench for the foot of the bed."""
    return (
        box(s.x, s.y, (s.height - 0.14, s.height), pick(rng, UPHOLSTERY), "fabric"),
        *legs(s, s.height - 0.14, 0.05, pick(rng, WOODS)),
    )


@furniture(
    "alarm clock",
    width=(0.12, 0.16),
    depth=(0.07, 0.09),
    height=(0.09, 0.12),
    rooms={"bedroom": 0.6, "children's room": 0.5},
    place=OnTop(("nightstand",), "front"),
)
def alarm_clock(s: Size, rng: Generator) -> Parts:
    """An alarm clock with a lit face."""
    return (
        box(s.x, (s.back, s.front - 0.01), s.z, pick(rng, (BLACK, *BRIGHT))),
        box(inset(s.x, 0.015), (s.front - 0.01, s.front), inset(s.z, 0.02), (0.5, 0.5, 0.5), "screen"),
    )


@furniture(
    "cot",
    width=(0.7, 0.8),
    depth=(1.2, 1.35),
    height=(0.9, 1.0),
    rooms={"children's room": 0.25},
    place=AgainstWall(corner=True),
    clearance=0.4,
)
def cot(s: Size, rng: Generator) -> Parts:
    """A cot: bars around a small mattress."""
    frame = pick(rng, (WHITE, *WOODS))
    bars = [
        box(x, about(y, 0.025), (0.35, s.height - 0.04), frame, "wood")
        for x in ends(s.x, 0.03)
        for y in spaced(s.back + 0.1, s.front - 0.1, 7)
    ]
    return (
        *legs(s, s.height, 0.05, frame, margin=0.0),
        *(box(x, s.y, (s.height - 0.05, s.height), frame, "wood") for x in ends(s.x, 0.04)),
        *(box(s.x, y, (0.3, s.height), frame, "wood") for y in ends(s.y, 0.03)),
        box(inset(s.x, 0.03), inset(s.y, 0.03), (0.35, 0.47), pick(rng, LINEN), "fabric"),
        box(inset(s.x, 0.12), (s.back + 0.06, s.back + 0.3), (0.47, 0.54), WHITE, "fabric"),
        *bars,
    )


@furniture(
    "toy shelf",
    width=(0.9, 1.3),
    depth=(0.32, 0.4),
    height=(0.7, 1.0),
    rooms={"children's room": (1, 1), "classroom": 0.3},
    clearance=0.5,
)
def toy_shelf(s: Size, rng: Generator) -> Parts:
    """A shelf with open compartments and bright bins."""
    rows, columns = 2, 3
    step = (s.height - 0.03) / rows
    bins = [
        box(
            inset(x, 0.03),
            (s.back + 0.03, s.front - 0.02),
            (row * step + 0.03, row * step + 0.03 + step * rng.uniform(0.4, 0.8)),
            pick(rng, BRIGHT),
            "label",
        )
        for row in range(rows)
        for x in split(inset(s.x, 0.03), columns)
    ]
    return (*shelf_unit(s, rows, pick(rng, (WHITE, *WOODS))), *bins)


@furniture(
    "teddy bear",
    width=(0.28, 0.4),
    depth=(0.25, 0.3),
    height=(0.35, 0.5),
    rooms={"children's room": (1, 3)},
    place=OnFloor(),
    solid=False,
)
def teddy_bear(s: Size, rng: Generator) -> Parts:
    """A sitting teddy bear: body, head, ears and paws."""
    fur: Colour = pick(rng, ((0.62, 0.42, 0.24), (0.8, 0.7, 0.55), (0.9, 0.6, 0.7)))
    h = s.height
    return (
        ball(inset(s.x, 0.06), inset(s.y, 0.04), (0.0, 0.6 * h), fur, "fabric"),
        ball(about(0.0, 0.55 * s.width), about(0.02, 0.2), (0.52 * h, 0.96 * h), fur, "fabric"),
        *(ball(about(x, 0.08), about(0.02, 0.05), (0.84 * h, h), fur, "fabric") for x in (-0.07, 0.07)),
        *(
            ball(about(x, 0.1), (s.front - 0.16, s.front), (0.0, 0.1), fur, "fabric")
            for x in (s.left + 0.05, s.right - 0.05)
        ),
        box(about(0.0, 0.05), about(0.115, 0.01), about(0.7 * h, 0.03), BLACK),
    )


@furniture(
    "toy blocks",
    width=(0.4, 0.6),
    depth=(0.4, 0.6),
    height=(0.16, 0.3),
    rooms={"children's room": (1, 2)},
    place=OnFloor(),
    solid=False,
)
def toy_blocks(s: Size, rng: Generator) -> Parts:
    """Building blocks: a tower, with loose blocks around it."""
    side = s.height / 3
    tower = [box(about(0.0, side), about(0.0, side), (i * side, (i + 1) * side), pick(rng, BRIGHT)) for i in range(3)]
    loose = [
        box(about(x, 0.07), about(y, 0.07), (0.0, 0.07), pick(rng, BRIGHT), "label")
        for x, y in zip(
            rng.uniform(s.left + 0.04, s.right - 0.04, 6), rng.uniform(s.back + 0.04, s.front - 0.04, 6), strict=True
        )
    ]
    return (*tower, *loose)


@furniture(
    "ball",
    width=(0.2, 0.28),
    depth=(0.2, 0.28),
    height=(0.2, 0.28),
    rooms={"children's room": 0.8, "garden": 0.7, "gym": 1.0},
    place=OnFloor(),
    solid=False,
)
def toy_ball(s: Size, rng: Generator) -> Parts:
    """A two-coloured ball."""
    d = min(s)
    first, second = pick(rng, BRIGHT), pick(rng, (WHITE, *BRIGHT))
    return (
        ball(about(0.0, d), about(0.0, d), (0.0, d), first, "label"),
        cylinder(about(0.0, 0.98 * d), about(0.0, 0.98 * d), about(d / 2, 0.06), second),
    )


@furniture(
    "play tent",
    width=(0.9, 1.1),
    depth=(0.9, 1.1),
    height=(1.3, 1.5),
    rooms={"children's room": 0.35},
    place=AgainstWall(corner=True),
)
def play_tent(s: Size, rng: Generator) -> Parts:
    """A play tent for children: a cone of cloth, with a mat in front."""
    cloth = pick(rng, (*BRIGHT, *LINEN))
    return (
        cone(s.x, s.y, s.z, cloth, "fabric"),
        box(about(0.0, 0.3), (0.25 * s.depth, s.front), (0.0, 0.03), pick(rng, BRIGHT), "fabric"),
    )


@furniture(
    "small desk", width=(0.9, 1.1), depth=(0.5, 0.6), height=(0.6, 0.7), rooms={"children's room": 0.7}, clearance=0.7
)
def small_desk(s: Size, rng: Generator) -> Parts:
    """A child's desk with a drawing on it."""
    frame = pick(rng, (WHITE, *WOODS))
    return (
        box(s.x, s.y, (s.height - 0.035, s.height - 0.004), frame, "wood"),
        *legs(s, s.height - 0.03, 0.05, pick(rng, BRIGHT)),
        box(about(-0.1, 0.4), about(0.0, 0.28), (s.height - 0.004, s.height), WHITE, "picture"),
    )


@furniture(
    "small chair",
    width=(0.34, 0.4),
    depth=(0.34, 0.4),
    height=(0.6, 0.7),
    rooms={"children's room": (1, 1)},
    place=Around(("small desk",), "front"),
)
def small_chair(s: Size, rng: Generator) -> Parts:
    """A low chair for children, painted in a bright colour."""
    paint = pick(rng, BRIGHT)
    return (
        *legs(s, 0.32, 0.04, paint, margin=0.0),
        box(s.x, s.y, (0.32, 0.36), paint, "wood"),
        box(s.x, (s.back, s.back + 0.03), (0.4, s.height), paint, "wood"),
    )


@furniture(
    "letters",
    width=(0.9, 1.5),
    depth=(0.02, 0.03),
    height=(0.25, 0.35),
    rooms={"children's room": (1, 2), "classroom": 0.6},
    place=OnWall((1.4, 1.7)),
)
def letters(s: Size, rng: Generator) -> Parts:
    """A garland of coloured flags with printed letters."""
    flags = [
        box(inset(x, 0.01), s.y, (s.height * rng.uniform(0.0, 0.4), s.height - 0.02), pick(rng, BRIGHT), "label")
        for x in split(s.x, 7, 0.02)
    ]
    return (box(s.x, s.y, (s.height - 0.02, s.height), WHITE), *flags)


@furniture(
    "crayons",
    width=(0.1, 0.12),
    depth=(0.09, 0.1),
    height=(0.12, 0.16),
    rooms={"children's room": 0.8, "classroom": 0.4},
    place=OnTop(("small desk", "toy shelf", "school desk")),
)
def crayons(s: Size, rng: Generator) -> Parts:
    """Crayons in a cup."""
    pencils = [
        box(about(x, 0.012), about(0.0, 0.012), (0.05, s.height), pick(rng, BRIGHT)) for x in (-0.03, -0.01, 0.01, 0.03)
    ]
    return (cylinder(about(0.0, 0.09), about(0.0, 0.09), (0.0, 0.09), pick(rng, BRIGHT), "label"), *pencils)


@furniture(
    "wall shelf",
    width=(0.7, 1.1),
    depth=(0.18, 0.24),
    height=(0.3, 0.36),
    rooms={
        "children's room": 0.7,
        "bedroom": 0.3,
        "living room": (1, 2),
        "office": 0.5,
        "storage room": 0.5,
        "laundry room": 0.5,
    },
    place=OnWall((1.35, 1.7)),
)
def wall_shelf(s: Size, rng: Generator) -> Parts:
    """A board on the wall with books and boxes."""
    return (
        box(s.x, s.y, (0.0, 0.03), pick(rng, (*WOODS, WHITE)), "wood"),
        *stocked(Size(s.width, s.depth, s.height), 1, ("books", "books", "label"), (0.8, 0.78, 0.74), rng, fill=1.0),
    )
