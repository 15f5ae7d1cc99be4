"""Furniture and equipment of gyms, libraries, classrooms and laboratories."""

from numpy.random import Generator

from worlds.furniture.kinds import AgainstWall, Around, OnFloor, OnTop, OnWall, Parts, Size
from worlds.furniture.palette import (
    BLACK,
    BRIGHT,
    CHROME,
    DARK_WOODS,
    GLASS,
    GREY,
    METALS,
    STEEL,
    UPHOLSTERY,
    WHITE,
    WOODS,
    pick,
)
from worlds.furniture.registry import furniture
from worlds.furniture.shapes import about, ball, box, cone, cylinder, ends, fronts, inset, legs, octagon, split
from worlds.parts import Part


@furniture("treadmill", width=(0.75, 0.85), depth=(1.6, 1.8), height=(1.3, 1.4), rooms={"gym": (1, 2)}, clearance=0.3)
def treadmill(s: Size, rng: Generator) -> Parts:
    """A treadmill: a belt, two posts and a console."""
    paint = pick(rng, METALS)
    return (
        box(s.x, s.y, (0.0, 0.16), paint, "metal"),
        box(inset(s.x, 0.14), (s.back + 0.3, s.front), (0.16, 0.18), BLACK, "carpet"),
        *(box(x, (s.back + 0.05, s.back + 0.15), (0.16, 1.1), paint, "metal") for x in ends(s.x, 0.06)),
        *(box(x, (s.back + 0.1, s.back + 0.7), (0.95, 1.0), BLACK) for x in ends(s.x, 0.05)),
        box(s.x, (s.back, s.back + 0.14), (1.05, s.height), BLACK),
        box(inset(s.x, 0.15), (s.back + 0.14, s.back + 0.15), (1.1, s.height - 0.04), GREY, "screen"),
    )


@furniture(
    "exercise bike",
    width=(0.5, 0.6),
    depth=(1.0, 1.2),
    height=(1.2, 1.35),
    rooms={"gym": (1, 2), "bedroom": 0.05},
    clearance=0.3,
)
def exercise_bike(s: Size, rng: Generator) -> Parts:
    """An exercise bike: a flywheel, a saddle and handles."""
    paint = pick(rng, BRIGHT)
    return (
        *(box(s.x, y, (0.0, 0.08), BLACK) for y in ends(s.y, 0.1)),
        box(about(0.0, 0.08), s.y, (0.04, 0.12), paint, "metal"),
        *(box(about(0.0, 0.12), y, z, paint, "metal") for y, z in octagon(s.back + 0.3, 0.4, 0.5, narrow=0.5)),
        box(about(0.0, 0.06), about(s.front - 0.3, 0.06), (0.1, 0.9), CHROME, "metal"),
        box(about(0.0, 0.22), about(s.front - 0.3, 0.26), (0.9, 0.98), BLACK),
        box(about(0.0, 0.06), about(s.back + 0.2, 0.06), (0.5, s.height - 0.1), CHROME, "metal"),
        box(s.x, about(s.back + 0.25, 0.06), (s.height - 0.14, s.height - 0.08), BLACK),
        box(about(0.0, 0.24), (s.back + 0.12, s.back + 0.18), (s.height - 0.14, s.height), GREY, "screen"),
    )


@furniture("weight rack", width=(1.2, 1.6), depth=(0.45, 0.55), height=(0.85, 1.0), rooms={"gym": (1, 1)}, clearance=0.6)
def weight_rack(s: Size, rng: Generator) -> Parts:
    """A rack with dumb-bells on two rails."""
    bells: list[Part] = []
    for z in (0.34, 0.8):
        for x in split(inset(s.x, 0.06), 6, 0.05):
            tone, middle = pick(rng, (BLACK, BLACK, *BRIGHT)), sum(x) / 2
            bells.append(box(about(middle, 0.04), (s.back + 0.1, s.front - 0.06), about(z, 0.04), CHROME))
            bells += [
                box(x, y, about(z, 0.13), tone) for y in ((s.back + 0.06, s.back + 0.16), (s.front - 0.14, s.front - 0.04))
            ]
    return (
        *(box(x, inset(s.y, 0.03), (0.0, 0.78), METALS[1], "metal") for x in ends(s.x, 0.05)),
        *(box(s.x, inset(s.y, 0.05), (z, z + 0.04), METALS[1], "metal") for z in (0.23, 0.69)),
        *bells,
    )


@furniture("weight bench", width=(1.1, 1.3), depth=(1.2, 1.4), height=(1.0, 1.15), rooms={"gym": (1, 1)}, place=OnFloor())
def weight_bench(s: Size, rng: Generator) -> Parts:
    """A padded bench under a bar with weights."""
    red = pick(rng, (BLACK, BRIGHT[0]))
    disc = octagon(s.back + 0.2, s.height - 0.2, 0.36, narrow=0.5)
    plates = [box(x, y, z, BLACK, "label") for x in ends(s.x, 0.12) for y, z in disc]
    return (
        box(about(0.0, 0.3), inset(s.y, 0.03), (0.38, 0.46), red, "fabric"),
        *(
            box(about(0.0, 0.08), y, (0.0, 0.38), METALS[0], "metal")
            for y in ((s.back + 0.3, s.back + 0.38), (s.front - 0.2, s.front - 0.12))
        ),
        *(box(about(x, 0.06), about(s.back + 0.15, 0.06), (0.0, s.height - 0.2), METALS[0], "metal") for x in (-0.4, 0.4)),
        box(s.x, about(s.back + 0.2, 0.03), about(s.height - 0.2, 0.03), CHROME, "metal"),
        *plates,
    )


@furniture(
    "gym ball",
    width=(0.55, 0.65),
    depth=(0.55, 0.65),
    height=(0.55, 0.65),
    rooms={"gym": (1, 3), "children's room": 0.15},
    place=AgainstWall(corner=True),
)
def gym_ball(s: Size, rng: Generator) -> Parts:
    """A large ball in a bright colour, for gymnastics."""
    return (ball(s.x, s.y, s.z, pick(rng, BRIGHT), "label"),)


@furniture(
    "yoga mat",
    width=(0.6, 0.66),
    depth=(1.7, 1.85),
    height=(0.01, 0.015),
    rooms={"gym": (1, 3)},
    place=OnFloor(),
    solid=False,
)
def yoga_mat(s: Size, rng: Generator) -> Parts:
    """A yoga mat with a white oval in the middle."""
    return (
        box(s.x, s.y, (0.0, 0.008), pick(rng, BRIGHT), "carpet"),
        cylinder(inset(s.x, 0.15), about(0.0, 0.34), (0.0, s.height), WHITE, "fabric"),
    )


@furniture(
    "wall bars", width=(0.85, 1.0), depth=(0.14, 0.18), height=(2.0, 2.2), rooms={"gym": (1, 2)}, place=OnWall((0.1, 0.15))
)
def wall_bars(s: Size, rng: Generator) -> Parts:
    """Wall bars for gymnastics: horizontal rungs between two posts."""
    wood = pick(rng, WOODS)
    return (
        *(box(x, s.y, s.z, wood, "wood") for x in ends(s.x, 0.05)),
        *(box(s.x, (s.front - 0.05, s.front - 0.01), z, wood, "wood") for z in split(inset(s.z, 0.05), 10, 0.15)),
    )


@furniture("punching bag", width=(0.36, 0.42), depth=(0.36, 0.42), height=(1.6, 1.8), rooms={"gym": 0.6}, place=OnFloor())
def punching_bag(s: Size, rng: Generator) -> Parts:
    """A punching bag on a weighted foot."""
    return (
        cylinder(s.x, s.y, (0.0, 0.2), BLACK),
        cylinder(about(0.0, 0.08), about(0.0, 0.08), (0.2, 0.6), CHROME),
        cylinder(inset(s.x, 0.03), inset(s.y, 0.03), (0.6, s.height), pick(rng, BRIGHT), "label"),
    )


@furniture(
    "reading table",
    width=(1.4, 2.0),
    depth=(0.8, 1.0),
    height=(0.73, 0.76),
    rooms={"library": (1, 1)},
    place=OnFloor("centre"),
)
def reading_table(s: Size, rng: Generator) -> Parts:
    """A dark table with a leather inlay."""
    wood = pick(rng, DARK_WOODS)
    return (
        box(s.x, s.y, (s.height - 0.05, s.height - 0.003), wood, "wood"),
        box(inset(s.x, 0.12), inset(s.y, 0.12), (s.height - 0.004, s.height), (0.2, 0.36, 0.26), "fabric"),
        *legs(s, s.height - 0.05, 0.08, wood),
    )


@furniture(
    "reading chair",
    width=(0.46, 0.52),
    depth=(0.48, 0.54),
    height=(0.88, 0.98),
    rooms={"library": (2, 4)},
    place=Around(("reading table",)),
)
def reading_chair(s: Size, rng: Generator) -> Parts:
    """A wooden chair with a leather seat."""
    wood = pick(rng, DARK_WOODS)
    return (
        *legs(s, 0.44, 0.045, wood, margin=0.0),
        box(s.x, s.y, (0.42, 0.48), pick(rng, UPHOLSTERY[2:]), "fabric"),
        *(box(x, (s.back, s.back + 0.035), (0.48, s.height), wood, "wood") for x in split(s.x, 4, 0.05)),
        box(s.x, (s.back, s.back + 0.04), (s.height - 0.08, s.height), wood, "wood"),
    )


@furniture(
    "globe",
    width=(0.4, 0.5),
    depth=(0.4, 0.5),
    height=(0.9, 1.05),
    rooms={"library": 0.6, "classroom": 0.4, "office": 0.1},
    place=AgainstWall(corner=True),
)
def globe(s: Size, rng: Generator) -> Parts:
    """A globe of the world on a stand."""
    return (
        cylinder(about(0.0, 0.06), about(0.0, 0.06), (0.0, 0.5), DARK_WOODS[0], "wood"),
        cylinder(inset(s.x, 0.08), inset(s.y, 0.08), (0.0, 0.05), DARK_WOODS[0], "wood"),
        ball(s.x, s.y, (s.height - s.width, s.height), (0.35, 0.6, 0.85), "picture"),
        cylinder(s.x, s.y, about(s.height - s.width / 2, 0.03), (0.8, 0.65, 0.25)),
    )


@furniture("book cart", width=(0.7, 0.85), depth=(0.4, 0.48), height=(0.95, 1.1), rooms={"library": 0.6, "classroom": 0.2})
def book_cart(s: Size, rng: Generator) -> Parts:
    """A cart with two shelves of books."""
    frame = pick(rng, METALS)
    return (
        *legs(s, s.height, 0.04, frame, "metal", margin=0.0),
        *(box(s.x, s.y, (z, z + 0.03), frame, "metal") for z in (0.2, 0.62)),
        *(box(inset(s.x, 0.05), inset(s.y, 0.06), (z, z + 0.25), (0.8, 0.78, 0.74), "books") for z in (0.23, 0.65)),
    )


@furniture(
    "open book",
    width=(0.3, 0.38),
    depth=(0.22, 0.26),
    height=(0.03, 0.045),
    rooms={"library": 1.5, "living room": 0.3, "children's room": 0.5, "classroom": 0.4},
    place=OnTop(("reading table", "coffee table", "small desk", "school desk")),
)
def open_book(s: Size, rng: Generator) -> Parts:
    """An open book: printed pages on a cover."""
    return (
        box(s.x, s.y, (0.0, 0.01), pick(rng, BRIGHT)),
        *(box(inset(x, 0.006), inset(s.y, 0.006), (0.01, s.height), WHITE, "scribble") for x in split(s.x, 2)),
    )


@furniture(
    "school desk", width=(1.1, 1.3), depth=(0.5, 0.6), height=(0.7, 0.75), rooms={"classroom": (4, 8)}, place=OnFloor()
)
def school_desk(s: Size, rng: Generator) -> Parts:
    """A desk for two pupils."""
    return (
        box(s.x, s.y, (s.height - 0.03, s.height), WOODS[3], "wood"),
        *legs(s, s.height - 0.03, 0.035, pick(rng, (STEEL, BRIGHT[2])), "metal"),
        box(inset(s.x, 0.05), inset(s.y, 0.06), (s.height - 0.15, s.height - 0.13), GREY, "metal"),
    )


@furniture(
    "school chair",
    width=(0.4, 0.44),
    depth=(0.42, 0.48),
    height=(0.78, 0.84),
    rooms={"classroom": (1, 2)},
    place=Around(("school desk",), "front"),
)
def school_chair(s: Size, rng: Generator) -> Parts:
    """A plywood chair on a frame of tubes."""
    return (
        *legs(s, 0.42, 0.025, STEEL, "metal"),
        box(s.x, inset(s.y, 0.02), (0.42, 0.45), WOODS[3], "wood"),
        box(s.x, (s.back, s.back + 0.025), (0.58, s.height), WOODS[3], "wood"),
        *(box(x, (s.back, s.back + 0.025), (0.42, 0.6), STEEL) for x in ends(s.x, 0.045, margin=0.02)),
    )


@furniture(
    "teacher's desk", width=(1.4, 1.7), depth=(0.7, 0.8), height=(0.74, 0.78), rooms={"classroom": (1, 1)}, clearance=0.6
)
def teachers_desk(s: Size, rng: Generator) -> Parts:
    """A teacher's desk: a top on a block and a side panel, with a closed front."""
    wood = pick(rng, WOODS)
    return (
        box(s.x, s.y, (s.height - 0.04, s.height), wood, "wood"),
        box(inset(s.x, 0.05), (s.front - 0.08, s.front - 0.05), (0.15, s.height - 0.04), wood, "wood"),
        *(
            box(x, inset(s.y, 0.05), (0.0, s.height - 0.04), wood, "wood")
            for x in ((s.left + 0.02, s.left + 0.4), (s.right - 0.08, s.right - 0.02))
        ),
    )


@furniture(
    "blackboard",
    width=(1.8, 2.6),
    depth=(0.06, 0.1),
    height=(1.0, 1.2),
    rooms={"classroom": (1, 1)},
    place=OnWall((0.85, 0.95)),
)
def blackboard(s: Size, rng: Generator) -> Parts:
    """A green blackboard with writing, and a tray with pieces of chalk."""
    return (
        box(s.x, (s.back, s.back + 0.03), s.z, WOODS[0], "wood"),
        box(inset(s.x, 0.04), (s.back, s.back + 0.035), inset(s.z, 0.05), (0.16, 0.3, 0.24), "plaster"),
        *(
            box(
                about(x, rng.uniform(0.2, 0.4)),
                (s.back, s.back + 0.038),
                about(z * s.height, rng.uniform(0.015, 0.03)),
                (0.9, 0.92, 0.88),
            )
            for x in (-0.5, 0.05, 0.6)
            for z in (0.3, 0.45, 0.6, 0.75)
        ),
        box(inset(s.x, 0.2), s.y, (0.0, 0.03), WOODS[0], "wood"),
        *(
            box(about(x, 0.07), (s.front - 0.03, s.front - 0.01), (0.03, 0.045), pick(rng, (WHITE, *BRIGHT)))
            for x in (-0.4, -0.1, 0.3)
        ),
    )


@furniture(
    "world map",
    width=(1.2, 1.7),
    depth=(0.015, 0.02),
    height=(0.8, 1.0),
    rooms={"classroom": 0.8, "office": 0.2, "library": 0.5, "children's room": 0.3},
    place=OnWall((1.0, 1.2)),
)
def world_map(s: Size, rng: Generator) -> Parts:
    """A map with continents on blue."""
    land = [
        box(
            about(x * s.width, w * s.width),
            (s.back, s.front),
            about(z * s.height, h * s.height),
            pick(rng, (BRIGHT[1], BRIGHT[3], WOODS[3])),
            "plaster",
        )
        for x, w, z, h in (
            (-0.3, 0.2, 0.65, 0.4),
            (-0.22, 0.12, 0.28, 0.34),
            (0.04, 0.14, 0.4, 0.42),
            (0.2, 0.34, 0.68, 0.36),
            (0.36, 0.12, 0.25, 0.16),
        )
    ]
    return (box(s.x, (s.back, s.front - 0.004), s.z, (0.55, 0.76, 0.92), "scribble"), *land)


@furniture("lab bench", width=(1.6, 2.4), depth=(0.75, 0.9), height=(0.9, 0.94), rooms={"laboratory": (2, 3)}, clearance=0.8)
def lab_bench(s: Size, rng: Generator) -> Parts:
    """A laboratory bench: a dark top on a white body with drawers."""
    return (
        box(s.x, s.y, (s.height - 0.04, s.height), (0.3, 0.32, 0.34), "marble"),
        box(inset(s.x, 0.03), (s.back, s.front - 0.08), (0.0, s.height - 0.04), WHITE),
        *fronts(
            inset(s.x, 0.03),
            (0.1, s.height - 0.05),
            s.front - 0.06,
            max(3, round(s.width / 0.5)),
            3,
            pick(rng, (WHITE, (0.62, 0.76, 0.84))),
            STEEL,
            "plain",
        ),
    )


@furniture(
    "lab stool",
    width=(0.36, 0.42),
    depth=(0.36, 0.42),
    height=(0.6, 0.68),
    rooms={"laboratory": (1, 1)},
    place=Around(("lab bench",), "front"),
)
def lab_stool(s: Size, rng: Generator) -> Parts:
    """A stool with a round seat on a column with a cross-shaped foot."""
    return (
        cylinder(s.x, s.y, (s.height - 0.08, s.height), BLACK, "fabric"),
        cylinder(about(0.0, 0.06), about(0.0, 0.06), (0.05, s.height - 0.08), CHROME, "metal"),
        box(s.x, about(0.0, 0.05), (0.0, 0.05), CHROME),
        box(about(0.0, 0.05), s.y, (0.0, 0.05), CHROME),
    )


@furniture(
    "microscope",
    width=(0.2, 0.24),
    depth=(0.26, 0.32),
    height=(0.38, 0.44),
    rooms={"laboratory": (1, 2)},
    place=OnTop(("lab bench",)),
)
def microscope(s: Size, rng: Generator) -> Parts:
    """A microscope: foot, stage, arm and tube."""
    tone = pick(rng, (WHITE, BLACK))
    return (
        box(s.x, s.y, (0.0, 0.04), tone),
        box(about(0.0, 0.05), (s.back, s.back + 0.06), (0.04, 0.85 * s.height), tone),
        box(inset(s.x, 0.03), (s.back + 0.04, s.front - 0.06), (0.14, 0.16), BLACK),
        cylinder(about(0.0, 0.05), about(0.02, 0.05), (0.2, s.height), STEEL, "metal"),
        box(about(0.0, 0.05), (s.back + 0.03, 0.04), (0.7 * s.height, 0.8 * s.height), tone),
    )


@furniture(
    "glassware",
    width=(0.36, 0.5),
    depth=(0.08, 0.1),
    height=(0.24, 0.32),
    rooms={"laboratory": (2, 3)},
    place=OnTop(("lab bench",)),
)
def glassware(s: Size, rng: Generator) -> Parts:
    """Flasks and tubes with coloured liquids."""
    parts: list[Part] = []
    for x in split(s.x, 4, 0.02):
        middle, wide, top = sum(x) / 2, min(x[1] - x[0], s.depth), s.height * rng.uniform(0.7, 1.0)
        parts += [
            cone(about(middle, wide), about(0.0, wide), (0.0, top), pick(rng, BRIGHT), "glass"),
            cylinder(about(middle, 0.35 * wide), about(0.0, 0.35 * wide), (0.4 * top, top), GLASS, "glass"),
        ]
    return tuple(parts)


@furniture(
    "fume hood",
    width=(1.2, 1.6),
    depth=(0.75, 0.85),
    height=(2.1, 2.3),
    rooms={"laboratory": (1, 1)},
    place=AgainstWall(corner=True),
    clearance=0.7,
)
def fume_hood(s: Size, rng: Generator) -> Parts:
    """A fume hood: a work chamber behind a sliding window, above a cupboard."""
    body = pick(rng, (WHITE, (0.78, 0.82, 0.84)))
    return (
        box(s.x, (s.back, s.front - 0.025), (0.0, 0.9), body, "metal"),
        *fronts(s.x, (0.05, 0.85), s.front - 0.004, 2, 1, body, STEEL, "metal"),
        box(s.x, (s.back, s.back + 0.05), (0.9, s.height), body, "metal"),
        *(box(x, s.y, (0.9, s.height), body, "metal") for x in ends(s.x, 0.08)),
        box(s.x, s.y, (1.8, s.height), body, "metal"),
        box(inset(s.x, 0.08), (s.front - 0.06, s.front - 0.04), (1.25, 1.8), GLASS, "glass"),
        box(inset(s.x, 0.08), inset(s.y, 0.05), (0.9, 0.93), (0.3, 0.32, 0.34), "marble"),
        *(cone(about(x, 0.18), about(0.0, 0.18), (0.93, 1.2), pick(rng, BRIGHT), "glass") for x in (-0.3, 0.05, 0.3)),
        box(about(0.3, 0.3), (s.front - 0.01, s.front), (1.88, 2.02), BLACK, "screen"),
    )


@furniture(
    "gas cylinder",
    width=(0.24, 0.28),
    depth=(0.24, 0.28),
    height=(1.4, 1.6),
    rooms={"laboratory": (1, 2), "garage": 0.2},
    place=AgainstWall(beside=("gas cylinder",), corner=True),
)
def gas_cylinder(s: Size, rng: Generator) -> Parts:
    """A steel gas cylinder with a coloured, rounded top and a valve."""
    return (
        cylinder(s.x, s.y, (0.0, s.height - 0.25), METALS[1], "metal"),
        ball(s.x, s.y, (s.height - 0.4, s.height - 0.12), pick(rng, BRIGHT), "metal"),
        cylinder(about(0.0, 0.05), about(0.0, 0.05), (s.height - 0.15, s.height), CHROME),
        box(s.x, (s.front - 0.01, s.front), (0.7, 0.9), WHITE, "label"),
    )


@furniture(
    "analyser",
    width=(0.45, 0.6),
    depth=(0.42, 0.5),
    height=(0.35, 0.45),
    rooms={"laboratory": (1, 1)},
    place=OnTop(("lab bench",)),
)
def analyser(s: Size, rng: Generator) -> Parts:
    """A laboratory instrument with a display and a panel of buttons."""
    body = pick(rng, (WHITE, (0.62, 0.76, 0.84), GREY))
    return (
        box(s.x, (s.back, s.front - 0.01), s.z, body),
        box((s.left + 0.04, 0.06), (s.front - 0.01, s.front), inset(s.z, 0.08), GREY, "screen"),
        box((0.09, s.right - 0.03), (s.front - 0.01, s.front), inset(s.z, 0.06), BLACK, "keyboard"),
    )
