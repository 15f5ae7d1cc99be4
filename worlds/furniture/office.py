"""Furniture of offices, meeting rooms and print rooms."""

from numpy.random import Generator

from worlds.furniture.kinds import AgainstWall, Around, OnFloor, OnTop, OnWall, Parts, Size
from worlds.furniture.palette import BLACK, BRIGHT, CHROME, GREY, METALS, PAPER, STEEL, UPHOLSTERY, WHITE, WOODS, pick
from worlds.furniture.registry import furniture
from worlds.furniture.shapes import about, box, cylinder, ends, fronts, inset, legs, shelf_unit, split, stocked

_DESKS = ("desk", "double desk")


@furniture(
    "desk",
    width=(1.2, 1.6),
    depth=(0.7, 0.8),
    height=(0.72, 0.76),
    rooms={
        "office": (1, 2),
        "open-plan office": (3, 5),
        "bedroom": 0.2,
        "children's room": 0.1,
        "library": 0.3,
        "print room": 0.4,
    },
    place=AgainstWall(can_stand_free=True),
    clearance=0.85,
)
def desk(s: Size, rng: Generator) -> Parts:
    """A desk: a top on metal legs, and a block of three drawers below."""
    top, frame = pick(rng, (*WOODS, WHITE)), pick(rng, METALS)
    return (
        box(s.x, s.y, (s.height - 0.035, s.height), top, "wood"),
        *legs(s, s.height - 0.035, 0.05, frame, "metal"),
        box((s.right - 0.46, s.right - 0.08), inset(s.y, 0.06), (0.06, 0.6), GREY),
        *fronts((s.right - 0.46, s.right - 0.08), (0.06, 0.6), s.front - 0.045, 1, 3, GREY, BLACK, "metal"),
        box(inset(s.x, 0.08), (s.back + 0.03, s.back + 0.05), (0.3, s.height - 0.04), top, "wood"),
    )


@furniture(
    "double desk",
    width=(1.4, 1.6),
    depth=(1.4, 1.6),
    height=(0.72, 0.76),
    rooms={"open-plan office": (1, 3)},
    place=OnFloor("centre"),
)
def double_desk(s: Size, rng: Generator) -> Parts:
    """Two desks face to face, with a cloth partition between them that reaches up to the height of the desk tops."""
    top, frame = pick(rng, (*WOODS, WHITE)), pick(rng, METALS)
    return (
        *(box(s.x, y, (s.height - 0.035, s.height), top, "wood") for y in split(s.y, 2, 0.03)),
        *legs(s, s.height - 0.035, 0.06, frame, "metal"),
        box(inset(s.x, 0.05), about(0.0, 0.025), (0.4, s.height), pick(rng, UPHOLSTERY), "fabric"),
    )


@furniture(
    "office chair",
    width=(0.58, 0.66),
    depth=(0.58, 0.66),
    height=(0.95, 1.15),
    rooms={
        "office": (1, 1),
        "open-plan office": (1, 2),
        "bedroom": (1, 1),
        "library": (1, 1),
        "print room": (1, 1),
        "children's room": (1, 1),
    },
    place=Around(_DESKS, "front"),
)
def office_chair(s: Size, rng: Generator) -> Parts:
    """An office chair with arm rests, on a column with a cross-shaped foot."""
    cloth = pick(rng, (BLACK, BLACK, *UPHOLSTERY))
    return (
        box(s.x, about(0.0, 0.06), (0.03, 0.08), BLACK),
        box(about(0.0, 0.06), s.y, (0.03, 0.08), BLACK),
        *(cylinder(x, about(0.0, 0.06), (0.0, 0.06), BLACK) for x in ends(s.x, 0.06)),
        cylinder(about(0.0, 0.06), about(0.0, 0.06), (0.08, 0.42), CHROME, "metal"),
        box(inset(s.x, 0.07), inset(s.y, 0.06), (0.42, 0.51), cloth, "fabric"),
        box(inset(s.x, 0.09), (s.back + 0.02, s.back + 0.09), (0.55, s.height), cloth, "fabric"),
        box(about(0.0, 0.08), (s.back, s.back + 0.03), (0.42, 0.75), BLACK),
        *(box(x, (-0.15, 0.14), (0.64, 0.67), BLACK) for x in ends(s.x, 0.08, margin=0.02)),
        *(box(x, about(-0.05, 0.04), (0.45, 0.64), BLACK) for x in ends(s.x, 0.07, margin=0.03)),
    )


@furniture(
    "monitor",
    width=(0.52, 0.62),
    depth=(0.18, 0.22),
    height=(0.42, 0.5),
    rooms={"office": (1, 2), "open-plan office": (1, 2), "bedroom": 0.7, "print room": 0.8, "children's room": 0.6},
    place=OnTop(_DESKS, "back"),
)
def monitor(s: Size, rng: Generator) -> Parts:
    """A monitor: a screen on a foot."""
    return (
        box(about(0.0, 0.24), s.y, (0.0, 0.015), BLACK),
        box(about(0.0, 0.05), about(-0.02, 0.03), (0.015, 0.2), BLACK),
        box(s.x, about(0.0, 0.03), (0.1, s.height), BLACK),
        box(inset(s.x, 0.012), (0.012, 0.02), (0.112, s.height - 0.012), (0.62, 0.66, 0.74), "screen"),
    )


@furniture(
    "keyboard",
    width=(0.42, 0.46),
    depth=(0.14, 0.17),
    height=(0.025, 0.032),
    rooms={"office": (1, 1), "open-plan office": (1, 1), "bedroom": 0.7, "print room": 0.8},
    place=OnTop(_DESKS, "front"),
)
def keyboard(s: Size, rng: Generator) -> Parts:
    """A keyboard, with a mouse beside it."""
    tone = pick(rng, (BLACK, (0.8, 0.8, 0.8)))
    return (
        box((s.left, s.right - 0.09), s.y, s.z, tone, "keyboard"),
        box((s.right - 0.06, s.right), inset(s.y, 0.03), (0.0, 0.03), tone),
    )


@furniture(
    "laptop",
    width=(0.32, 0.37),
    depth=(0.26, 0.3),
    height=(0.22, 0.25),
    rooms={"office": 0.5, "meeting room": (1, 3), "library": 0.6, "living room": 0.3, "laboratory": 0.6, "classroom": 0.2},
    place=OnTop((*_DESKS, "meeting table", "reading table", "coffee table", "lab bench", "school desk")),
)
def laptop(s: Size, rng: Generator) -> Parts:
    """An open laptop."""
    shell = pick(rng, (STEEL, BLACK))
    return (
        box(s.x, (s.back + 0.02, s.front), (0.0, 0.018), shell, "metal"),
        box(inset(s.x, 0.02), (s.back + 0.06, s.front - 0.1), (0.018, 0.021), BLACK, "keyboard"),
        box(s.x, (s.back, s.back + 0.015), (0.01, s.height), shell, "metal"),
        box(inset(s.x, 0.01), (s.back + 0.015, s.back + 0.019), (0.03, s.height - 0.01), (0.6, 0.65, 0.75), "screen"),
    )


@furniture(
    "desk lamp",
    width=(0.18, 0.22),
    depth=(0.34, 0.4),
    height=(0.42, 0.5),
    rooms={"office": 0.6, "children's room": 0.6, "library": 0.7, "open-plan office": 0.2},
    place=OnTop((*_DESKS, "small desk", "reading table"), "back"),
)
def desk_lamp(s: Size, rng: Generator) -> Parts:
    """A desk lamp: a lamp on a bent arm with a round foot."""
    paint = pick(rng, (*BRIGHT, BLACK))
    return (
        cylinder(s.x, (s.back, s.back + s.width), (0.0, 0.025), paint, "metal"),
        cylinder(about(0.0, 0.025), about(s.back + 0.1, 0.025), (0.025, s.height - 0.04), paint),
        box(about(0.0, 0.03), (s.back + 0.1, s.front), (s.height - 0.07, s.height - 0.04), paint),
        cylinder(about(0.0, 0.14), (s.front - 0.14, s.front), (s.height - 0.12, s.height), paint, "metal"),
    )


@furniture(
    "papers",
    width=(0.22, 0.32),
    depth=(0.3, 0.34),
    height=(0.03, 0.12),
    rooms={"office": 1.0, "open-plan office": 0.7, "meeting room": (1, 3), "print room": 1.0, "classroom": 0.4},
    place=OnTop((*_DESKS, "meeting table", "file cabinet", "school desk", "copy counter")),
)
def papers(s: Size, rng: Generator) -> Parts:
    """A stack of paper; the top sheet is printed."""
    return (
        box(s.x, s.y, (0.0, s.height - 0.004), PAPER),
        box(inset(s.x, 0.01), inset(s.y, 0.01), (s.height - 0.004, s.height), PAPER, "scribble"),
    )


@furniture(
    "mug",
    width=(0.1, 0.12),
    depth=(0.08, 0.09),
    height=(0.09, 0.11),
    rooms={"office": 0.6, "open-plan office": 0.5, "meeting room": (1, 3), "kitchen": 0.8},
    place=OnTop((*_DESKS, "meeting table", "kitchen counter", "breakfast table")),
)
def mug(s: Size, rng: Generator) -> Parts:
    """A mug with a handle."""
    paint = pick(rng, (*BRIGHT, WHITE))
    return (
        cylinder((s.left, s.right - 0.03), s.y, s.z, paint, "ceramic"),
        box((s.right - 0.035, s.right), about(0.0, 0.02), (0.02, s.height - 0.02), paint),
    )


@furniture(
    "file cabinet",
    width=(0.42, 0.5),
    depth=(0.5, 0.6),
    height=(1.0, 1.35),
    rooms={"office": (1, 2), "open-plan office": (1, 2), "print room": (1, 2), "storage room": 0.3},
    place=AgainstWall(beside=("file cabinet", "bookshelf")),
    clearance=0.5,
)
def file_cabinet(s: Size, rng: Generator) -> Parts:
    """A cabinet of four steel drawers with paper labels."""
    steel = pick(rng, (GREY, STEEL, (0.36, 0.42, 0.4)))
    tags = [
        box(about(-0.08, 0.08), (s.front - 0.006, s.front - 0.002), about(z, 0.04), PAPER, "label")
        for z in (0.25 * s.height, 0.5 * s.height, 0.75 * s.height)
    ]
    return (
        box(s.x, (s.back, s.front - 0.025), s.z, steel, "metal"),
        *fronts(s.x, (0.03, s.height - 0.02), s.front - 0.004, 1, 4, steel, BLACK, "metal"),
        *tags,
    )


@furniture(
    "binder shelf",
    width=(0.8, 1.2),
    depth=(0.34, 0.42),
    height=(1.7, 2.0),
    rooms={"office": 0.8, "print room": (1, 1), "open-plan office": 0.7, "laboratory": 0.3},
    place=AgainstWall(beside=("binder shelf", "file cabinet")),
    clearance=0.5,
)
def binder_shelf(s: Size, rng: Generator) -> Parts:
    """Metal shelves with ring binders and boxes."""
    return (
        *shelf_unit(s, 5, pick(rng, (GREY, WHITE, STEEL)), "metal"),
        *stocked(s, 5, ("books", "label"), (0.62, 0.66, 0.74), rng, fill=0.9),
    )


@furniture(
    "whiteboard",
    width=(1.2, 1.8),
    depth=(0.05, 0.08),
    height=(0.9, 1.2),
    rooms={"office": 0.8, "meeting room": (1, 1), "open-plan office": 0.7, "classroom": (1, 1), "laboratory": 0.7},
    place=OnWall((0.85, 1.0)),
)
def whiteboard(s: Size, rng: Generator) -> Parts:
    """A whiteboard full of drawings, with a tray of pens."""
    pens = [box(about(x, 0.1), (s.front - 0.03, s.front), (0.02, 0.04), pick(rng, BRIGHT)) for x in (-0.3, 0.0, 0.2)]
    return (
        box(s.x, (s.back, s.back + 0.03), (0.02, s.height), STEEL, "metal"),
        box(inset(s.x, 0.02), (s.back + 0.03, s.back + 0.034), (0.05, s.height - 0.02), WHITE, "scribble"),
        box(inset(s.x, 0.2), s.y, (0.0, 0.02), STEEL, "metal"),
        *pens,
    )


@furniture(
    "meeting table",
    width=(2.0, 2.8),
    depth=(1.0, 1.2),
    height=(0.73, 0.76),
    rooms={"meeting room": (1, 1)},
    place=OnFloor("centre"),
)
def meeting_table(s: Size, rng: Generator) -> Parts:
    """A meeting table: a long top on two metal panels."""
    wood = pick(rng, (*WOODS, WHITE))
    return (
        box(s.x, s.y, (s.height - 0.05, s.height), wood, "wood"),
        *(
            box(about(x, 0.08), inset(s.y, 0.2), (0.0, s.height - 0.05), pick(rng, METALS), "metal")
            for x in (-0.3 * s.width, 0.3 * s.width)
        ),
        box(about(0.0, 0.4), about(0.0, 0.15), (s.height - 0.002, s.height), BLACK, "keyboard"),
    )


@furniture(
    "conference chair",
    width=(0.52, 0.58),
    depth=(0.52, 0.58),
    height=(0.85, 0.95),
    rooms={"meeting room": (6, 10)},
    place=Around(("meeting table",)),
)
def conference_chair(s: Size, rng: Generator) -> Parts:
    """A conference chair: a padded seat and back on steel legs."""
    cloth = pick(rng, (BLACK, UPHOLSTERY[1], UPHOLSTERY[0]))
    return (
        *legs(s, 0.44, 0.03, CHROME, "metal"),
        box(inset(s.x, 0.03), inset(s.y, 0.03), (0.44, 0.5), cloth, "fabric"),
        box(inset(s.x, 0.04), (s.back, s.back + 0.05), (0.54, s.height), cloth, "fabric"),
    )


@furniture(
    "wall screen",
    width=(1.2, 1.6),
    depth=(0.05, 0.07),
    height=(0.7, 0.9),
    rooms={"meeting room": (1, 1), "lobby": 0.4, "gym": 0.5},
    place=OnWall((1.1, 1.3)),
)
def wall_screen(s: Size, rng: Generator) -> Parts:
    """A wall-mounted display that shows slides."""
    return (
        box(s.x, (s.back, s.front - 0.008), s.z, BLACK),
        box(inset(s.x, 0.02), (s.front - 0.008, s.front), inset(s.z, 0.02), (0.62, 0.66, 0.74), "screen"),
    )


@furniture(
    "photocopier",
    width=(0.7, 0.9),
    depth=(0.62, 0.7),
    height=(1.1, 1.2),
    rooms={"print room": (1, 2), "open-plan office": 0.6, "office": 0.12},
    clearance=0.7,
    essential=True,
)
def photocopier(s: Size, rng: Generator) -> Parts:
    """A photocopier with paper trays, a control panel and a document feeder."""
    body = pick(rng, (WHITE, (0.8, 0.8, 0.78), GREY))
    return (
        box(inset(s.x, 0.05), (s.back, s.front - 0.04), (0.0, 0.86), body),
        *fronts(inset(s.x, 0.05), (0.04, 0.62), s.front - 0.02, 1, 4, body, BLACK, "plain"),
        box((s.left, s.right - 0.1), (s.back + 0.05, s.front - 0.1), (0.66, 0.7), PAPER),
        box(inset(s.x, 0.02), (s.back, s.front - 0.06), (0.86, 0.98), body),
        box(inset(s.x, 0.1), (s.back + 0.03, s.front - 0.14), (0.98, s.height), (0.35, 0.36, 0.38)),
        box((s.right - 0.4, s.right - 0.06), (s.front - 0.14, s.front), (0.92, 1.0), BLACK, "screen"),
    )


@furniture(
    "printer",
    width=(0.4, 0.5),
    depth=(0.36, 0.42),
    height=(0.26, 0.36),
    rooms={"office": 0.5, "print room": (1, 1), "open-plan office": 0.2},
    place=OnTop(("file cabinet", "copy counter"), "middle"),
)
def printer(s: Size, rng: Generator) -> Parts:
    """A printer with a sheet coming out."""
    return (
        box(s.x, (s.back, s.front - 0.06), s.z, pick(rng, (WHITE, BLACK, GREY))),
        box(inset(s.x, 0.08), (0.0, s.front), (0.12, 0.13), PAPER, "scribble"),
        box(inset(s.x, 0.05), (s.front - 0.07, s.front - 0.05), (0.16, 0.22), BLACK, "keyboard"),
    )


@furniture(
    "copy counter", width=(1.2, 1.8), depth=(0.5, 0.6), height=(0.88, 0.95), rooms={"print room": (1, 2)}, clearance=0.6
)
def copy_counter(s: Size, rng: Generator) -> Parts:
    """A work surface above open compartments with paper."""
    tone = pick(rng, (WHITE, *WOODS))
    return (*shelf_unit(s, 3, tone), *stocked(s, 3, ("label", "plain"), PAPER, rng, fill=0.95))


@furniture(
    "paper boxes",
    width=(0.32, 0.46),
    depth=(0.3, 0.36),
    height=(0.5, 0.8),
    rooms={"print room": (1, 2), "office": 0.2, "storage room": 0.5},
)
def paper_boxes(s: Size, rng: Generator) -> Parts:
    """Stacked cartons of copy paper."""
    return tuple(
        box(inset(s.x, rng.uniform(0.0, 0.03)), inset(s.y, 0.01), z, pick(rng, (PAPER, (0.7, 0.54, 0.36))), "label")
        for z in split(s.z, 3, 0.005)
    )


@furniture(
    "waste bin",
    width=(0.26, 0.32),
    depth=(0.26, 0.32),
    height=(0.3, 0.4),
    rooms={
        "office": 0.7,
        "open-plan office": 1.0,
        "kitchen": 0.6,
        "bathroom": 0.4,
        "print room": (1, 2),
        "classroom": 0.7,
        "laundry room": 0.3,
        "meeting room": 0.4,
    },
)
def waste_bin(s: Size, rng: Generator) -> Parts:
    """A bin with crumpled paper."""
    tone = pick(rng, (BLACK, GREY, STEEL, BRIGHT[2]))
    return (
        cylinder(s.x, s.y, (0.0, s.height - 0.06), tone, "metal"),
        cylinder(inset(s.x, 0.03), inset(s.y, 0.03), (s.height - 0.08, s.height), PAPER, "label"),
    )


@furniture(
    "flip chart",
    width=(0.65, 0.75),
    depth=(0.4, 0.5),
    height=(1.7, 1.85),
    rooms={"meeting room": 0.7, "open-plan office": 0.3, "classroom": 0.2},
    place=AgainstWall(corner=True),
)
def flip_chart(s: Size, rng: Generator) -> Parts:
    """A flip chart: a pad on an easel."""
    return (
        box(inset(s.x, 0.02), about(0.0, 0.03), (0.75, s.height), STEEL, "metal"),
        box(inset(s.x, 0.04), (0.015, 0.03), (0.82, s.height - 0.04), WHITE, "scribble"),
        *(box(x, s.y, (0.0, 0.03), BLACK) for x in ends(s.x, 0.03)),
        *(box(x, about(0.0, 0.03), (0.0, 0.8), BLACK) for x in ends(s.x, 0.03)),
    )


@furniture(
    "water cooler",
    width=(0.32, 0.36),
    depth=(0.32, 0.36),
    height=(1.3, 1.45),
    rooms={"open-plan office": 0.6, "lobby": 0.4, "meeting room": 0.3, "gym": (1, 1)},
    place=AgainstWall(corner=True),
)
def water_cooler(s: Size, rng: Generator) -> Parts:
    """A water cooler: a blue bottle on a stand."""
    return (
        box(s.x, s.y, (0.0, 0.95), WHITE),
        box(inset(s.x, 0.06), (s.front - 0.02, s.front), (0.6, 0.8), BLACK, "keyboard"),
        cylinder(inset(s.x, 0.03), inset(s.y, 0.03), (0.95, s.height), (0.45, 0.68, 0.9), "glass"),
    )
