"""Furniture of corridors, entrance halls and lobbies."""

from numpy.random import Generator

from worlds.furniture.kinds import AgainstWall, OnFloor, OnTop, OnWall, Parts, Size
from worlds.furniture.palette import BLACK, BRIGHT, CHROME, DARK_WOODS, GLASS, METALS, STONES, UPHOLSTERY, WHITE, WOODS, pick
from worlds.furniture.registry import furniture
from worlds.furniture.shapes import about, ball, box, cylinder, ends, inset, legs, shelf_unit, split
from worlds.parts import Part


@furniture(
    "shoe rack", width=(0.7, 1.0), depth=(0.24, 0.3), height=(0.5, 0.75), rooms={"corridor": 0.1, "entrance hall": (1, 2)}
)
def shoe_rack(s: Size, rng: Generator) -> Parts:
    """A rack with pairs of shoes on three shelves."""
    shoes: list[Part] = []
    step = (s.height - 0.03) / 3
    for level in range(3):
        for x in split(inset(s.x, 0.04), 4, 0.03):
            tone, low = pick(rng, (BLACK, *UPHOLSTERY, *BRIGHT)), level * step + 0.03
            shoes += [
                box(half, (s.back + 0.03, s.front - 0.01), (low, low + 0.09), tone)
                for half in split(x, 2, 0.015)
                if rng.random() < 0.85
            ]
    return (*shelf_unit(s, 3, pick(rng, WOODS)), *shoes)


@furniture(
    "coat hooks",
    width=(0.8, 1.2),
    depth=(0.14, 0.2),
    height=(1.1, 1.3),
    rooms={"corridor": 0.1, "entrance hall": (2, 3), "classroom": 0.5, "office": 0.3},
    place=OnWall((0.65, 0.75)),
)
def coat_hooks(s: Size, rng: Generator) -> Parts:
    """A board of hooks with coats."""
    coats = [
        box(
            inset(x, 0.02),
            (s.back + 0.03, s.front),
            (s.height * rng.uniform(0.0, 0.4), s.height - 0.12),
            pick(rng, (*UPHOLSTERY, *BRIGHT, BLACK)),
            "fabric",
        )
        for x in split(s.x, 5, 0.03)
        if rng.random() < 0.8
    ]
    hooks = [
        box(about(sum(x) / 2, 0.02), (s.back + 0.02, s.back + 0.1), (s.height - 0.12, s.height - 0.09), CHROME)
        for x in split(s.x, 5, 0.03)
    ]
    return (box(s.x, (s.back, s.back + 0.02), (s.height - 0.16, s.height - 0.04), pick(rng, WOODS), "wood"), *hooks, *coats)


@furniture(
    "console table",
    width=(0.8, 1.1),
    depth=(0.26, 0.32),
    height=(0.76, 0.85),
    rooms={"corridor": 0.7, "entrance hall": (1, 1), "lobby": 0.5},
)
def console_table(s: Size, rng: Generator) -> Parts:
    """A narrow table with two baskets on a lower shelf."""
    wood = pick(rng, WOODS)
    return (
        box(s.x, s.y, (s.height - 0.03, s.height), wood, "wood"),
        box(inset(s.x, 0.03), inset(s.y, 0.02), (s.height - 0.13, s.height - 0.03), wood, "wood"),
        *legs(s, s.height - 0.03, 0.04, wood),
        box(inset(s.x, 0.03), inset(s.y, 0.03), (0.16, 0.18), wood, "wood"),
        *(
            box(inset(x, 0.05), inset(s.y, 0.05), (0.18, 0.38), pick(rng, WOODS), "fabric")
            for x in split(inset(s.x, 0.05), 2)
        ),
    )


@furniture(
    "umbrella stand",
    width=(0.22, 0.26),
    depth=(0.22, 0.26),
    height=(0.75, 0.85),
    rooms={"corridor": 0.1, "entrance hall": (1, 1)},
    place=AgainstWall(corner=True),
)
def umbrella_stand(s: Size, rng: Generator) -> Parts:
    """A stand with three umbrellas."""
    canes = [
        cylinder(about(x, 0.05), about(y, 0.05), (0.02, s.height - dz), pick(rng, (BLACK, *BRIGHT)), "fabric")
        for x, y, dz in ((-0.05, 0.0, 0.0), (0.04, 0.05, 0.08), (0.03, -0.05, 0.04))
    ]
    return (cylinder(s.x, s.y, (0.0, 0.5), pick(rng, METALS), "metal"), *canes)


@furniture(
    "hall bench",
    width=(0.9, 1.2),
    depth=(0.34, 0.4),
    height=(0.44, 0.5),
    rooms={"corridor": 0.1, "entrance hall": (1, 1), "gym": 0.7},
)
def hall_bench(s: Size, rng: Generator) -> Parts:
    """A bench with a padded seat above two baskets."""
    wood = pick(rng, WOODS)
    return (
        box(s.x, s.y, (s.height - 0.1, s.height - 0.06), wood, "wood"),
        box(inset(s.x, 0.02), inset(s.y, 0.02), (s.height - 0.06, s.height), pick(rng, UPHOLSTERY), "fabric"),
        *legs(s, s.height - 0.1, 0.05, wood, margin=0.0),
        *(
            box(inset(x, 0.02), inset(s.y, 0.03), (0.0, 0.24), pick(rng, WOODS), "fabric")
            for x in split(inset(s.x, 0.05), 2)
        ),
    )


@furniture(
    "runner",
    width=(2.0, 3.0),
    depth=(0.7, 0.9),
    height=(0.012, 0.016),
    rooms={"corridor": (1, 2), "entrance hall": 0.2},
    place=OnFloor("centre"),
    solid=False,
)
def runner(s: Size, rng: Generator) -> Parts:
    """A long rug (a runner) with three ovals."""
    rim, field = pick(rng, UPHOLSTERY), pick(rng, UPHOLSTERY)
    return (
        box(s.x, s.y, (0.0, 0.008), rim, "fabric"),
        box(inset(s.x, 0.08), inset(s.y, 0.08), (0.0, 0.01), field, "fabric"),
        *(cylinder(inset(x, 0.15), inset(s.y, 0.2), (0.0, s.height), rim, "fabric") for x in split(s.x, 3)),
    )


@furniture(
    "door mat",
    width=(0.6, 0.8),
    depth=(0.4, 0.5),
    height=(0.015, 0.025),
    rooms={"entrance hall": (1, 2)},
    place=OnFloor(),
    solid=False,
)
def door_mat(s: Size, rng: Generator) -> Parts:
    """A door mat of coconut fibre with a black border."""
    return (
        box(s.x, s.y, (0.0, 0.012), BLACK, "carpet"),
        box(inset(s.x, 0.04), inset(s.y, 0.04), (0.0, s.height), (0.55, 0.42, 0.28), "carpet"),
    )


@furniture(
    "key board",
    width=(0.3, 0.45),
    depth=(0.04, 0.05),
    height=(0.2, 0.28),
    rooms={"entrance hall": (1, 1)},
    place=OnWall((1.3, 1.5)),
)
def key_board(s: Size, rng: Generator) -> Parts:
    """A small board on which keys hang."""
    keys = [
        box(inset(x, 0.015), (s.back + 0.02, s.front), (0.02, 0.6 * s.height), pick(rng, (CHROME, *BRIGHT)), "metal")
        for x in split(inset(s.x, 0.02), 5)
    ]
    return (box(s.x, (s.back, s.back + 0.02), s.z, pick(rng, WOODS), "wood"), *keys)


@furniture(
    "standing mirror",
    width=(0.45, 0.6),
    depth=(0.05, 0.08),
    height=(1.3, 1.6),
    rooms={"corridor": 0.1, "entrance hall": (1, 1), "bedroom": 0.6, "gym": (1, 2)},
    place=OnWall((0.25, 0.4)),
)
def standing_mirror(s: Size, rng: Generator) -> Parts:
    """A framed mirror on the wall, in which a person sees the whole body."""
    return (
        box(s.x, (s.back, s.front - 0.01), s.z, pick(rng, (*WOODS, BLACK, CHROME)), "wood"),
        box(inset(s.x, 0.05), (s.front - 0.01, s.front), inset(s.z, 0.05), GLASS, "glass"),
    )


@furniture(
    "reception desk",
    width=(1.8, 2.4),
    depth=(0.7, 0.9),
    height=(1.05, 1.15),
    rooms={"lobby": (1, 1)},
    place=AgainstWall(can_stand_free=True),
    clearance=0.7,
    essential=True,
)
def reception_desk(s: Size, rng: Generator) -> Parts:
    """A reception desk: a high front with a company sign, and a lower work top behind it."""
    front = pick(rng, (*DARK_WOODS, *STONES))
    return (
        box(s.x, (0.0, s.front), (0.0, s.height - 0.04), front, "wood"),
        box(s.x, (-0.05, s.front), (s.height - 0.04, s.height), pick(rng, STONES), "marble"),
        box(s.x, (s.back, 0.0), (0.7, 0.74), WHITE, "wood"),
        *(box(x, (s.back, 0.0), (0.0, 0.7), front, "wood") for x in ends(s.x, 0.05)),
        box(about(0.0, 0.8), (s.front - 0.005, s.front), (0.45, 0.8), pick(rng, BRIGHT), "label"),
        box(about(0.4, 0.5), about(-0.2, 0.04), (0.74, 1.04), BLACK, "screen"),
    )


@furniture(
    "brochure rack",
    width=(0.4, 0.6),
    depth=(0.3, 0.36),
    height=(1.4, 1.7),
    rooms={"lobby": 0.7, "library": 0.3, "corridor": 0.1},
    place=AgainstWall(corner=True),
)
def brochure_rack(s: Size, rng: Generator) -> Parts:
    """A stepped rack with rows of leaflets."""
    racks: list[Part] = []
    for i, z in enumerate(split((0.35, s.height), 4, 0.05)):
        y = s.front - 0.05 - 0.05 * i
        racks += [box(x, (y - 0.03, y), z, pick(rng, BRIGHT), "picture") for x in split(inset(s.x, 0.02), 3, 0.02)]
    return (
        box(s.x, (s.back, s.back + 0.05), s.z, pick(rng, METALS), "metal"),
        box(s.x, s.y, (0.0, 0.05), BLACK),
        box(s.x, (s.back, 0.0), (0.05, 0.32), pick(rng, METALS), "metal"),
        *racks,
    )


@furniture(
    "phone",
    width=(0.18, 0.22),
    depth=(0.18, 0.22),
    height=(0.1, 0.13),
    rooms={"corridor": 0.3, "entrance hall": 0.4, "office": 0.7, "lobby": 0.5},
    place=OnTop(("console table", "desk", "sideboard")),
)
def phone(s: Size, rng: Generator) -> Parts:
    """A telephone: a handset on a base."""
    tone = pick(rng, (BLACK, WHITE, BRIGHT[0]))
    return (
        box(s.x, s.y, (0.0, 0.06), tone, "keyboard"),
        box(s.x, (s.back, s.back + 0.06), (0.06, s.height), tone),
        *(ball(x, (s.back, s.back + 0.07), (0.05, s.height), tone) for x in ends(s.x, 0.07)),
    )


@furniture(
    "fire extinguisher",
    width=(0.16, 0.2),
    depth=(0.14, 0.17),
    height=(0.5, 0.6),
    rooms={
        "corridor": 0.5,
        "lobby": 0.8,
        "open-plan office": 0.7,
        "garage": 0.8,
        "laboratory": (1, 1),
        "print room": 0.5,
        "storage room": 0.4,
    },
    place=OnWall((0.7, 0.9)),
)
def fire_extinguisher(s: Size, rng: Generator) -> Parts:
    """A red fire extinguisher with a label and a hose."""
    return (
        cylinder(s.x, s.y, (0.0, s.height - 0.1), BRIGHT[0], "metal"),
        cylinder(about(0.0, 0.06), about(0.0, 0.06), (s.height - 0.1, s.height), BLACK),
        box(about(0.0, 0.08), (s.front - 0.02, s.front), (0.15, 0.3), WHITE, "label"),
        box((s.right - 0.02, s.right), about(0.0, 0.02), (0.1, s.height - 0.05), BLACK),
    )


@furniture(
    "notice board",
    width=(0.9, 1.4),
    depth=(0.03, 0.05),
    height=(0.7, 0.9),
    rooms={
        "corridor": 0.3,
        "office": 0.5,
        "open-plan office": 0.6,
        "classroom": (1, 2),
        "print room": 0.7,
        "laboratory": 0.5,
        "lobby": 0.4,
    },
    place=OnWall((1.05, 1.25)),
)
def notice_board(s: Size, rng: Generator) -> Parts:
    """A cork board with pinned notes."""
    notes = [
        box(
            inset(x, rng.uniform(0.01, 0.05)),
            (s.front - 0.008, s.front),
            inset(z, rng.uniform(0.01, 0.06)),
            pick(rng, (WHITE, WHITE, *BRIGHT)),
            _paper(rng),
        )
        for x in split(inset(s.x, 0.04), 4)
        for z in split(inset(s.z, 0.04), 2)
        if rng.random() < 0.85
    ]
    return (
        box(s.x, (s.back, s.front - 0.012), s.z, pick(rng, WOODS), "wood"),
        box(inset(s.x, 0.03), (s.back, s.front - 0.008), inset(s.z, 0.03), (0.7, 0.52, 0.34), "carpet"),
        *notes,
    )


def _paper(rng: Generator) -> str:
    """Draw the material of a sheet of paper."""
    return ("label", "scribble", "picture")[int(rng.integers(3))]
