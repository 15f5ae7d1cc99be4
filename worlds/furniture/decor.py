"""Things found in many kinds of rooms: pictures, plants, lamps, clocks, radiators; and the parts of windows."""

from numpy.random import Generator

from worlds.furniture.kinds import AgainstWall, OnCeiling, OnTop, OnWall, Parts, Size
from worlds.furniture.palette import (
    BLACK,
    BRIGHT,
    DARK_WOODS,
    GREEN,
    LAMP,
    LINEN,
    METALS,
    SKY,
    STEEL,
    TERRACOTTA,
    UPHOLSTERY,
    WHITE,
    WHITES,
    WOODS,
    pick,
)
from worlds.furniture.registry import furniture
from worlds.furniture.shapes import about, ball, box, cone, cylinder, ends, inset, split
from worlds.labels import LIVED_IN_LABELS

_WORK_AND_PUBLIC = ("office", "meeting room", "open-plan office", "classroom", "laboratory", "lobby", "gym", "print room")
_FRAMES = (*WOODS, BLACK, WHITE, (0.8, 0.65, 0.25))
_TABLES = (
    "dining table",
    "coffee table",
    "sideboard",
    "console table",
    "dresser",
    "side table",
    "desk",
    "tv stand",
    "file cabinet",
    "kitchen island",
    "reading table",
    "meeting table",
)


def window(s: Size, rng: Generator) -> Parts:
    """Build a window with a sill and two panes that show a pale view above foliage. Some windows have curtains."""
    frame, front = pick(rng, (*WHITES, *WOODS[:2])), s.front - 0.03
    view = (0.62, 0.74, 0.6) if rng.random() < 0.3 else SKY
    return (
        box(s.x, (s.back, front - 0.015), s.z, frame),
        *(
            box(inset(x, 0.03), (s.back, front - 0.005), (0.1, s.height - 0.06), view, "glass")
            for x in split(inset(s.x, 0.03), 2)
        ),
        *(
            box(inset(x, 0.03), (s.back, front), (0.1, 0.1 + rng.uniform(0.1, 0.3)), GREEN, "leaves")
            for x in split(inset(s.x, 0.03), 2)
        ),
        box(s.x, s.y, (0.0, 0.04), frame, "marble"),
        *(_curtains(s, rng) if rng.random() < 0.5 else ()),
    )


def _curtains(s: Size, rng: Generator) -> Parts:
    cloth, hung = pick(rng, (*LINEN, *UPHOLSTERY, *BRIGHT)), (s.front - 0.03, s.front)
    folds = [
        box(x, (hung[0] + rng.uniform(0.0, 0.015), hung[1]), (0.04, s.height - 0.03), cloth, "fabric")
        for side in ends(s.x, 0.22)
        for x in split(side, 3, 0.008)
    ]
    return (box(s.x, hung, (s.height - 0.04, s.height), pick(rng, (BLACK, *WOODS))), *folds)


@furniture(
    "picture",
    width=(0.4, 0.95),
    depth=(0.02, 0.035),
    height=(0.35, 0.75),
    rooms={"living room": (2, 3), "dining room": (1, 2), "bedroom": (1, 2), "library": (1, 2)}
    | dict.fromkeys(_WORK_AND_PUBLIC, 0.8)
    | {"children's room": 0.6, "corridor": (3, 5), "entrance hall": 0.6, "kitchen": 0.3, "bathroom": 0.2, "toilet": 0.7},
    place=OnWall((1.2, 1.55)),
)
def picture(s: Size, rng: Generator) -> Parts:
    """A painting in a frame, sometimes with a white border (mount) around it."""
    rim = rng.uniform(0.02, 0.06)
    mount = (box(inset(s.x, rim), (s.back, s.front - 0.006), inset(s.z, rim), WHITE),) if rng.random() < 0.5 else ()
    inner = rim + (0.05 if mount else 0.0)
    tint = pick(rng, (WHITE, (0.9, 0.8, 0.66), (0.7, 0.8, 0.95), (0.7, 0.9, 0.7)))
    return (
        box(s.x, (s.back, s.front - 0.01), s.z, pick(rng, _FRAMES), "wood"),
        *mount,
        box(inset(s.x, inner), (s.back, s.front), inset(s.z, inner), tint, "picture"),
    )


@furniture(
    "poster",
    width=(0.5, 0.75),
    depth=(0.008, 0.012),
    height=(0.7, 1.0),
    rooms={
        "children's room": (3, 4),
        "office": 0.6,
        "garage": 1.0,
        "gym": (1, 2),
        "classroom": (1, 3),
        "laundry room": 0.4,
        "laboratory": 1.0,
        "storage room": 0.3,
        "bedroom": 0.3,
    },
    place=OnWall((1.0, 1.3)),
)
def poster(s: Size, rng: Generator) -> Parts:
    """An unframed poster."""
    return (box(s.x, s.y, s.z, pick(rng, (WHITE, *BRIGHT, *LINEN)), "picture" if rng.random() < 0.7 else "scribble"),)


@furniture(
    "wall clock",
    width=(0.28, 0.36),
    depth=(0.03, 0.05),
    height=(0.28, 0.36),
    rooms={
        "kitchen": 0.8,
        "living room": 0.3,
        "office": 0.4,
        "classroom": (1, 1),
        "corridor": 0.3,
        "meeting room": 0.5,
        "lobby": 0.6,
        "laboratory": 0.6,
        "dining room": 0.3,
        "print room": 0.5,
        "gym": 0.7,
    },
    place=OnWall((1.6, 1.75)),
)
def wall_clock(s: Size, rng: Generator) -> Parts:
    """A clock with hands and marks on a pale face."""
    front, h = s.front, s.height
    marks = [
        box(about(x * s.width, 0.02), (s.back, front - 0.004), about(h / 2 + z * h, 0.02), BLACK)
        for x, z in ((0.0, 0.4), (0.4, 0.0), (0.0, -0.4), (-0.4, 0.0))
    ]
    return (
        box(s.x, (s.back, front - 0.01), inset(s.z, 0.15 * h), pick(rng, _FRAMES)),
        box(inset(s.x, 0.15 * s.width), (s.back, front - 0.01), s.z, pick(rng, _FRAMES)),
        box(inset(s.x, 0.05 * s.width), (s.back, front - 0.007), inset(s.z, 0.05 * h), WHITE),
        *marks,
        box(about(0.0, 0.015), (s.back, front), (h / 2, 0.82 * h), BLACK),
        box((0.0, 0.24 * s.width), (s.back, front), about(h / 2, 0.018), BLACK),
    )


@furniture(
    "plant",
    width=(0.4, 0.65),
    depth=(0.4, 0.65),
    height=(0.8, 1.6),
    rooms={
        "living room": (1, 2),
        "dining room": 0.8,
        "bedroom": 0.4,
        "office": 0.6,
        "meeting room": 0.8,
        "open-plan office": (1, 3),
        "lobby": (1, 3),
        "corridor": 0.3,
        "entrance hall": 0.5,
        "library": 0.5,
        "balcony": 0.7,
    },
    place=AgainstWall(corner=True),
)
def plant(s: Size, rng: Generator) -> Parts:
    """A palm, a rubber tree or a cactus in a pot."""
    pot, h = pick(rng, (TERRACOTTA, *WHITES, BLACK)), s.height
    green = pick(rng, (GREEN, (0.34, 0.5, 0.22), (0.2, 0.4, 0.24)))
    tub = (
        cylinder(about(0.0, 0.3), about(0.0, 0.3), (0.0, 0.26), pot, "ceramic"),
        cylinder(about(0.0, 0.33), about(0.0, 0.33), (0.24, 0.28), pot, "ceramic"),
    )
    stem = cylinder(about(0.0, 0.04), about(0.0, 0.04), (0.28, 0.7 * h), (0.4, 0.3, 0.2), "wood")
    match int(rng.integers(3)):
        case 0:
            fronds = [
                cone(inset(s.x, d * s.width), inset(s.y, d * s.depth), (z * h, (z + 0.3) * h), green, "leaves")
                for d, z in ((0.0, 0.35), (0.1, 0.52), (0.2, 0.7))
            ]
        case 1:
            fronds = [
                ball(
                    about(x * s.width, 0.6 * s.width),
                    about(y * s.depth, 0.6 * s.depth),
                    (z * h, (z + 0.4) * h),
                    green,
                    "leaves",
                )
                for x, y, z in ((-0.2, 0.1, 0.35), (0.2, -0.1, 0.45), (0.0, 0.2, 0.6))
            ]
        case _:
            fronds = [
                cylinder(about(x, 0.14), about(0.0, 0.14), (0.28, z * h), green, "leaves")
                for x, z in ((-0.12, 0.7), (0.0, 1.0), (0.13, 0.6))
            ]
    return (*tub, stem, *fronds)


@furniture(
    "potted plant",
    width=(0.18, 0.28),
    depth=(0.18, 0.28),
    height=(0.25, 0.45),
    rooms=dict.fromkeys((*LIVED_IN_LABELS, "office", "meeting room", "corridor", "entrance hall", "lobby"), 0.35)
    | {"kitchen": 0.3, "bathroom": 0.5},
    place=OnTop((*_TABLES, "kitchen counter", "bathroom stool", "bookshelf")),
)
def potted_plant(s: Size, rng: Generator) -> Parts:
    """A small potted plant, with or without flowers."""
    bloom = [
        ball(about(x, 0.06), about(y, 0.06), (s.height - 0.08, s.height - 0.02), pick(rng, BRIGHT))
        for x, y in ((-0.04, 0.04), (0.05, 0.02), (0.0, -0.04))
    ]
    return (
        cylinder(inset(s.x, 0.05), inset(s.y, 0.05), (0.0, 0.12), pick(rng, (TERRACOTTA, *WHITES, *BRIGHT)), "ceramic"),
        ball(s.x, s.y, (0.1, s.height - 0.03), GREEN, "leaves"),
        *(bloom if rng.random() < 0.5 else ()),
    )


@furniture(
    "vase",
    width=(0.16, 0.22),
    depth=(0.16, 0.22),
    height=(0.38, 0.5),
    rooms={"living room": 0.3, "dining room": 0.5, "bedroom": 0.3, "entrance hall": 0.6, "corridor": 0.5, "lobby": 0.5},
    place=OnTop(_TABLES),
)
def vase(s: Size, rng: Generator) -> Parts:
    """A vase of cut flowers."""
    flowers = [
        ball(about(x, 0.08), about(y, 0.08), about(z, 0.08), pick(rng, BRIGHT))
        for x, y, z in ((-0.04, 0.0, s.height - 0.04), (0.04, 0.03, s.height - 0.08), (0.0, -0.04, s.height - 0.1))
    ]
    stems = cone(about(0.0, 0.14), about(0.0, 0.14), (0.15, s.height - 0.05), GREEN, "leaves")
    return (
        cylinder(about(0.0, 0.11), about(0.0, 0.11), (0.0, 0.22), pick(rng, (*BRIGHT, *WHITES)), "ceramic"),
        stems,
        *flowers,
    )


@furniture(
    "photo frame",
    width=(0.14, 0.22),
    depth=(0.05, 0.07),
    height=(0.18, 0.24),
    rooms={"living room": 0.4, "bedroom": 0.7, "office": 0.3, "corridor": 0.4, "entrance hall": 0.3},
    place=OnTop((*_TABLES, "nightstand", "piano"), "back"),
)
def photo_frame(s: Size, rng: Generator) -> Parts:
    """A small framed picture that stands on a piece of furniture."""
    return (
        box(s.x, (s.back, s.front - 0.02), s.z, pick(rng, _FRAMES), "wood"),
        box(inset(s.x, 0.02), (s.front - 0.02, s.front - 0.015), inset(s.z, 0.02), WHITE, "picture"),
        box(s.x, (s.front - 0.015, s.front), (0.0, 0.01), BLACK),
    )


@furniture(
    "ceiling lamp",
    width=(0.35, 0.55),
    depth=(0.35, 0.55),
    height=(0.25, 0.6),
    rooms=dict.fromkeys(
        (
            "living room",
            "bedroom",
            "children's room",
            "kitchen",
            "entrance hall",
            "bathroom",
            "toilet",
            "library",
            "laundry room",
        ),
        (1, 1),
    )
    | {"corridor": (2, 3)},
    place=OnCeiling(),
)
def ceiling_lamp(s: Size, rng: Generator) -> Parts:
    """A ceiling lamp in the shape of a globe, a cone or a drum."""
    shade = pick(rng, (LAMP, *LINEN, *BRIGHT, BLACK))
    rod = cylinder(about(0.0, 0.02), about(0.0, 0.02), (min(0.2, 0.6 * s.height), s.height), BLACK)
    low = (0.0, min(0.25, 0.8 * s.height))
    match int(rng.integers(3)):
        case 0:
            return (rod, ball(s.x, s.y, low, LAMP, "ceramic"))
        case 1:
            return (rod, cone(s.x, s.y, low, shade, "metal"))
    return (rod, cylinder(s.x, s.y, low, shade, "fabric"))


@furniture(
    "ceiling light panel",
    width=(1.1, 1.3),
    depth=(0.28, 0.6),
    height=(0.05, 0.08),
    rooms=dict.fromkeys(("office", "meeting room", "print room", "lobby", "gym", "garage", "storage room", "pantry"), (1, 1))
    | dict.fromkeys(("open-plan office", "classroom", "laboratory"), (2, 3)),
    place=OnCeiling(),
)
def ceiling_light_panel(s: Size, rng: Generator) -> Parts:
    """A bright light panel under the ceiling, behind three metal bars."""
    return (
        box(s.x, s.y, (0.015, s.height), WHITE),
        box(inset(s.x, 0.03), inset(s.y, 0.03), (0.005, 0.02), LAMP),
        *(box(about(x, 0.015), s.y, (0.0, 0.02), STEEL) for x in (-0.3, 0.0, 0.3)),
    )


@furniture(
    "radiator",
    width=(0.8, 1.2),
    depth=(0.09, 0.12),
    height=(0.5, 0.6),
    rooms=dict.fromkeys(LIVED_IN_LABELS, 0.7)
    | {"office": 0.6, "corridor": 0.5, "bathroom": 0.4, "kitchen": 0.2, "classroom": 0.8, "meeting room": 0.5},
    place=OnWall((0.12, 0.18)),
)
def radiator(s: Size, rng: Generator) -> Parts:
    """A radiator: white ribs under a grille."""
    white = pick(rng, WHITES)
    return (
        *(box(x, inset(s.y, 0.01), (0.0, s.height - 0.02), white) for x in split(s.x, max(6, round(s.width / 0.1)), 0.03)),
        box(s.x, s.y, (s.height - 0.03, s.height), white, "metal"),
        box(s.x, (s.back, s.back + 0.03), (0.04, s.height - 0.04), white),
    )


@furniture(
    "tapestry",
    width=(0.9, 1.4),
    depth=(0.02, 0.03),
    height=(0.9, 1.2),
    rooms={"living room": 0.1, "bedroom": (1, 1), "library": 0.4, "dining room": 0.1},
    place=OnWall((0.9, 1.1)),
)
def tapestry(s: Size, rng: Generator) -> Parts:
    """A decorated cloth that hangs from a rod on the wall."""
    cloth, band = pick(rng, UPHOLSTERY), pick(rng, (*BRIGHT, *LINEN))
    return (
        box(s.x, s.y, (s.height - 0.03, s.height), pick(rng, DARK_WOODS), "wood"),
        box(inset(s.x, 0.04), (s.back, s.front - 0.012), (0.0, s.height - 0.03), cloth, "fabric"),
        *(
            box(inset(s.x, 0.04), (s.back, s.front - 0.008), about(z * s.height, 0.07), band, "fabric")
            for z in (0.12, 0.5, 0.84)
        ),
        box(about(0.0, 0.3 * s.width), (s.back, s.front - 0.004), about(0.31 * s.height, 0.18), band, "fabric"),
    )


@furniture(
    "air vent",
    width=(0.4, 0.6),
    depth=(0.03, 0.05),
    height=(0.2, 0.3),
    rooms={
        "bathroom": 0.3,
        "toilet": 0.3,
        "office": 0.4,
        "open-plan office": 0.6,
        "laboratory": 0.8,
        "print room": 0.5,
        "gym": 0.7,
        "garage": 0.5,
        "storage room": 0.4,
    },
    place=OnWall((2.0, 2.1)),
)
def air_vent(s: Size, rng: Generator) -> Parts:
    """An air vent: slats in a frame."""
    return (
        box(s.x, (s.back, s.back + 0.02), s.z, pick(rng, METALS), "metal"),
        *(box(inset(s.x, 0.02), s.y, z, STEEL) for z in split(inset(s.z, 0.02), 4, 0.025)),
    )
