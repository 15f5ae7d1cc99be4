"""Furniture of living rooms and libraries."""

from numpy.random import Generator

from worlds.furniture.kinds import AgainstWall, Around, OnFloor, OnTop, Parts, Size
from worlds.furniture.palette import (
    BLACK,
    BRIGHT,
    DARK_WOODS,
    GREY,
    LAMP,
    LINEN,
    METALS,
    STONES,
    UPHOLSTERY,
    WALNUT,
    WHITE,
    WHITES,
    WOODS,
    pick,
)
from worlds.furniture.registry import furniture
from worlds.furniture.shapes import about, box, cone, cylinder, ends, fronts, inset, legs, shelf_unit, split, stocked


@furniture(
    "sofa",
    width=(1.7, 2.3),
    depth=(0.85, 0.95),
    height=(0.78, 0.9),
    rooms={"living room": (1, 1), "lobby": (1, 1), "office": 0.12, "library": 0.3},
    place=AgainstWall(can_stand_free=True),
    clearance=0.9,
)
def sofa(s: Size, rng: Generator) -> Parts:
    """A sofa: seat and back cushions between arm rests, with throw pillows."""
    cloth, arm = pick(rng, UPHOLSTERY), rng.uniform(0.14, 0.22)
    seats = split(inset(s.x, arm), 3 if s.width > 2.0 else 2, 0.015)
    pillows = [
        box((x[0] + 0.05, x[0] + 0.42), (s.back + 0.27, s.back + 0.4), (0.45, 0.78), pick(rng, (*BRIGHT, *LINEN)), "fabric")
        for x in seats[:2]
    ]
    return (
        box(s.x, s.y, (0.06, 0.3), cloth, "fabric"),
        box(s.x, (s.back, s.back + 0.2), (0.3, s.height), cloth, "fabric"),
        *(box(x, s.y, (0.3, 0.62), cloth, "fabric") for x in ends(s.x, arm)),
        *(box(x, (s.back + 0.2, s.front), (0.3, 0.45), cloth, "fabric") for x in seats),
        *(box(x, (s.back + 0.18, s.back + 0.32), (0.45, s.height - 0.04), cloth, "fabric") for x in seats),
        *pillows,
        *legs(s, 0.06, 0.05, BLACK),
    )


@furniture(
    "armchair",
    width=(0.75, 0.9),
    depth=(0.78, 0.9),
    height=(0.8, 1.0),
    rooms={"living room": 1.4, "lobby": 1.8, "library": 1.5, "bedroom": 0.2},
    place=AgainstWall(corner=True),
    clearance=0.5,
)
def armchair(s: Size, rng: Generator) -> Parts:
    """An armchair, built like a sofa with one seat."""
    cloth = pick(rng, UPHOLSTERY)
    return (
        box(s.x, s.y, (0.08, 0.3), cloth, "fabric"),
        box(s.x, (s.back, s.back + 0.2), (0.3, s.height), cloth, "fabric"),
        *(box(x, s.y, (0.3, 0.6), cloth, "fabric") for x in ends(s.x, 0.15)),
        box(inset(s.x, 0.15), (s.back + 0.2, s.front), (0.3, 0.44), cloth, "fabric"),
        box(inset(s.x, 0.2), (s.back + 0.2, s.back + 0.32), (0.44, 0.74), pick(rng, (*BRIGHT, *LINEN)), "fabric"),
        *legs(s, 0.08, 0.05, BLACK),
    )


@furniture(
    "coffee table",
    width=(0.9, 1.2),
    depth=(0.5, 0.65),
    height=(0.38, 0.45),
    rooms={"living room": (1, 1), "lobby": (1, 1)},
    place=Around(("sofa",), "front", gap_m=0.32),
)
def coffee_table(s: Size, rng: Generator) -> Parts:
    """A low table with a shelf for magazines."""
    wood = pick(rng, WOODS)
    top = box(s.x, s.y, (s.height - 0.04, s.height), wood, "wood")
    if rng.random() < 0.3:
        top = box(s.x, s.y, (s.height - 0.02, s.height), (0.6, 0.75, 0.78), "glass")
    return (
        top,
        *legs(s, s.height - 0.04, 0.05, wood),
        box(inset(s.x, 0.05), inset(s.y, 0.05), (0.12, 0.14), wood, "wood"),
        box((s.left + 0.1, s.left + 0.4), inset(s.y, 0.1), (0.14, 0.2), WHITE, "label"),
    )


@furniture(
    "tv stand",
    width=(1.2, 1.7),
    depth=(0.36, 0.44),
    height=(0.42, 0.55),
    rooms={"living room": (1, 1), "bedroom": 0.15},
    clearance=0.8,
)
def tv_stand(s: Size, rng: Generator) -> Parts:
    """A low TV stand: two doors beside a row of black devices."""
    wood = pick(rng, (*WOODS, WHITE, BLACK))
    return (
        box(s.x, (s.back, s.front - 0.025), s.z, wood, "wood"),
        *fronts((s.left, -0.2), (0.04, s.height - 0.03), s.front - 0.005, 2, 1, wood, GREY),
        box((-0.18, s.right - 0.04), (s.front - 0.05, s.front - 0.01), (0.08, s.height - 0.06), BLACK, "keyboard"),
    )


@furniture(
    "television",
    width=(1.0, 1.19),
    depth=(0.16, 0.2),
    height=(0.62, 0.72),
    rooms={"living room": (1, 1), "bedroom": (1, 1)},
    place=OnTop(("tv stand",), "middle"),
)
def television(s: Size, rng: Generator) -> Parts:
    """A flat television on a foot."""
    return (
        box(inset(s.x, 0.25), s.y, (0.0, 0.02), BLACK),
        box(about(0.0, 0.1), about(0.0, 0.04), (0.02, 0.12), BLACK),
        box(s.x, about(0.0, 0.05), (0.08, s.height), BLACK),
        box(inset(s.x, 0.015), (0.02, 0.03), (0.1, s.height - 0.015), (0.42, 0.44, 0.5), "screen"),
    )


@furniture(
    "bookshelf",
    width=(0.8, 1.3),
    depth=(0.28, 0.36),
    height=(1.7, 2.1),
    rooms={
        "living room": (1, 1),
        "library": (4, 8),
        "office": (1, 1),
        "bedroom": 0.15,
        "children's room": 0.4,
        "classroom": 0.5,
        "lobby": 0.2,
    },
    place=AgainstWall(beside=("bookshelf",)),
    clearance=0.5,
)
def bookshelf(s: Size, rng: Generator) -> Parts:
    """A bookshelf: five shelves of books with a few ornaments."""
    return (
        *shelf_unit(s, 5, pick(rng, (*WOODS, WHITE))),
        *stocked(s, 5, ("books", "books", "books", "books", "ceramic"), (0.8, 0.78, 0.74), rng, fill=0.92),
    )


@furniture(
    "rug",
    width=(1.6, 2.4),
    depth=(1.1, 1.6),
    height=(0.012, 0.016),
    rooms={"living room": (1, 1), "bedroom": 0.7, "children's room": 0.8, "library": 0.6, "office": 0.1},
    place=OnFloor("centre"),
    solid=False,
)
def rug(s: Size, rng: Generator) -> Parts:
    """A rug with a border, and an oval in the middle."""
    rim, field = pick(rng, UPHOLSTERY), pick(rng, (*LINEN, *UPHOLSTERY))
    return (
        box(s.x, s.y, (0.0, 0.008), rim, "fabric"),
        box(inset(s.x, 0.14), inset(s.y, 0.14), (0.0, 0.01), field, "fabric"),
        cylinder(inset(s.x, 0.35 * s.width), inset(s.y, 0.3 * s.depth), (0.0, s.height), rim, "fabric"),
    )


@furniture(
    "floor lamp",
    width=(0.35, 0.45),
    depth=(0.35, 0.45),
    height=(1.5, 1.8),
    rooms={"living room": (1, 1), "bedroom": 0.2, "library": 0.5, "lobby": 0.4, "office": 0.2},
    place=AgainstWall(corner=True),
)
def floor_lamp(s: Size, rng: Generator) -> Parts:
    """A floor lamp: a shade on a pole."""
    pole = pick(rng, METALS)
    return (
        cylinder(inset(s.x, 0.06), inset(s.y, 0.06), (0.0, 0.03), pole, "metal"),
        cylinder(about(0.0, 0.03), about(0.0, 0.03), (0.03, s.height - 0.2), pole, "metal"),
        cylinder(s.x, s.y, (s.height - 0.32, s.height), pick(rng, (LAMP, *LINEN)), "fabric"),
    )


@furniture(
    "fireplace",
    width=(1.1, 1.4),
    depth=(0.32, 0.4),
    height=(1.1, 1.25),
    rooms={"living room": 0.3, "library": 0.2},
    clearance=0.8,
)
def fireplace(s: Size, rng: Generator) -> Parts:
    """A fireplace: a brick surround with logs, a fire and a mantelpiece."""
    brick = pick(rng, ((0.6, 0.32, 0.25), *STONES))
    return (
        *(box(x, (s.back, s.front - 0.04), (0.0, s.height - 0.06), brick, "brick") for x in ends(s.x, 0.3, margin=0.04)),
        box(inset(s.x, 0.3), (s.back, s.front - 0.04), (0.72, s.height - 0.06), brick, "brick"),
        box(inset(s.x, 0.3), (s.back, s.back + 0.06), (0.0, 0.72), BLACK),
        *(cylinder(about(x, 0.12), about(0.0, 0.12), (0.0, 0.15), WALNUT, "wood") for x in (-0.12, 0.0, 0.12)),
        cone(about(0.0, 0.3), about(0.0, 0.14), (0.12, 0.5), (1.0, 0.5, 0.1), "leaves"),
        box(s.x, s.y, (s.height - 0.06, s.height), pick(rng, DARK_WOODS), "wood"),
    )


@furniture("piano", width=(1.35, 1.5), depth=(0.56, 0.64), height=(1.05, 1.25), rooms={"living room": 0.2}, clearance=0.7)
def piano(s: Size, rng: Generator) -> Parts:
    """An upright piano with keys and a sheet of music."""
    black = pick(rng, DARK_WOODS)
    return (
        box(s.x, (s.back, s.back + 0.32), s.z, black, "wood"),
        box(s.x, (s.back + 0.3, s.front), (0.6, 0.72), black, "wood"),
        *(box(x, (s.front - 0.08, s.front), (0.0, 0.6), black, "wood") for x in ends(s.x, 0.06)),
        box(inset(s.x, 0.08), (s.front - 0.18, s.front - 0.02), (0.72, 0.735), WHITE, "keyboard"),
        box(about(0.0, 0.5), (s.back + 0.32, s.back + 0.35), (0.78, s.height - 0.02), WHITE, "scribble"),
    )


@furniture(
    "side table",
    width=(0.4, 0.5),
    depth=(0.4, 0.5),
    height=(0.5, 0.6),
    rooms={"living room": 0.6, "lobby": 0.5, "library": 0.4},
)
def side_table(s: Size, rng: Generator) -> Parts:
    """A side table: a round top on a column with a conical foot."""
    wood = pick(rng, WOODS)
    return (
        cylinder(s.x, s.y, (s.height - 0.03, s.height), wood, "wood"),
        cylinder(about(0.0, 0.05), about(0.0, 0.05), (0.0, s.height - 0.03), wood, "wood"),
        cone(inset(s.x, 0.06), inset(s.y, 0.06), (0.0, 0.18), wood, "wood"),
    )


@furniture(
    "table lamp",
    width=(0.24, 0.3),
    depth=(0.24, 0.3),
    height=(0.38, 0.5),
    rooms={"living room": 0.6, "bedroom": 0.8, "corridor": 0.5, "entrance hall": 0.5},
    place=OnTop(("side table", "nightstand", "sideboard", "console table")),
)
def table_lamp(s: Size, rng: Generator) -> Parts:
    """A table lamp: a shade on a round ceramic base."""
    return (
        cylinder(inset(s.x, 0.07), inset(s.y, 0.07), (0.0, 0.2), pick(rng, (*BRIGHT, *WHITES)), "ceramic"),
        cone(s.x, s.y, (0.16, s.height), pick(rng, (LAMP, *LINEN)), "fabric"),
    )


@furniture(
    "game console",
    width=(0.28, 0.34),
    depth=(0.2, 0.26),
    height=(0.08, 0.11),
    rooms={"living room": 0.4, "children's room": 0.3},
    place=OnTop(("coffee table", "toy shelf")),
)
def game_console(s: Size, rng: Generator) -> Parts:
    """A game console with a controller on top."""
    return (
        box(s.x, s.y, (0.0, 0.06), BLACK, "keyboard"),
        box(inset(s.x, 0.08), inset(s.y, 0.06), (0.06, s.height), pick(rng, (GREY, WHITE)), "keyboard"),
    )


@furniture(
    "magazines",
    width=(0.24, 0.32),
    depth=(0.24, 0.32),
    height=(0.04, 0.1),
    rooms={"living room": 0.8, "lobby": 1.0, "bedroom": 0.4, "office": 0.8, "library": 1.0},
    place=OnTop(("coffee table", "side table", "nightstand", "desk", "reading table")),
)
def magazines(s: Size, rng: Generator) -> Parts:
    """A pile of magazines of slightly different sizes."""
    return tuple(
        box(inset(s.x, rng.uniform(0.0, 0.04)), inset(s.y, rng.uniform(0.0, 0.04)), z, pick(rng, BRIGHT), "picture")
        for z in split(s.z, 4)
    )
