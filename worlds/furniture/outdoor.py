"""Furniture and plants of gardens and balconies."""

from numpy.random import Generator

from worlds.furniture.kinds import AgainstWall, Around, OnFloor, OnTop, Parts, Size
from worlds.furniture.palette import BLACK, BRIGHT, GREEN, LINEN, METALS, RED, STEEL, STONES, TERRACOTTA, WHITE, WOODS, pick
from worlds.furniture.registry import furniture
from worlds.furniture.shapes import about, ball, box, cone, cylinder, ends, inset, legs, split
from worlds.parts import Part

_GREENS = (GREEN, (0.32, 0.52, 0.2), (0.2, 0.38, 0.22), (0.42, 0.55, 0.22))
_SOIL = (0.32, 0.22, 0.15)


@furniture(
    "tree", width=(1.2, 2.0), depth=(1.2, 2.0), height=(2.6, 4.0), rooms={"garden": (1, 3)}, place=AgainstWall(corner=True)
)
def tree(s: Size, rng: Generator) -> Parts:
    """A tree with a round or a conical crown, sometimes with blossom or fruit."""
    green, bark = pick(rng, (*_GREENS, (0.9, 0.7, 0.75))), (0.38, 0.27, 0.18)
    trunk = cylinder(about(0.0, 0.24), about(0.0, 0.24), (0.0, 0.5 * s.height), bark, "wood")
    if rng.random() < 0.35:
        tiers = [
            cone(inset(s.x, i * 0.14 * s.width), inset(s.y, i * 0.14 * s.depth), z, green, "leaves")
            for i, z in enumerate(
                ((0.2 * s.height, 0.65 * s.height), (0.42 * s.height, 0.85 * s.height), (0.64 * s.height, s.height))
            )
        ]
        return (trunk, *tiers)
    crown = [
        ball(s.x, s.y, (0.42 * s.height, 0.9 * s.height), green, "leaves"),
        ball(inset(s.x, 0.2 * s.width), inset(s.y, 0.2 * s.depth), (0.6 * s.height, s.height), pick(rng, _GREENS), "leaves"),
    ]
    fruit = [
        ball(about(x, 0.14), about(y, 0.14), about(0.55 * s.height, 0.14), RED)
        for x, y in ((-0.3 * s.width, 0.3 * s.depth), (0.3 * s.width, 0.32 * s.depth), (0.0, 0.44 * s.depth))
    ]
    return (trunk, *crown, *(fruit if rng.random() < 0.4 else ()))


@furniture(
    "hedge",
    width=(1.2, 2.6),
    depth=(0.4, 0.6),
    height=(0.9, 1.5),
    rooms={"garden": (2, 4)},
    place=AgainstWall(beside=("hedge",)),
)
def hedge(s: Size, rng: Generator) -> Parts:
    """A clipped, slightly uneven hedge."""
    return tuple(
        box(
            x,
            (s.back, s.front - rng.uniform(0.0, 0.06)),
            (0.0, s.height - rng.uniform(0.0, 0.12)),
            pick(rng, _GREENS[:3]),
            "leaves",
        )
        for x in split(s.x, 3)
    )


@furniture("flower bed", width=(1.2, 2.2), depth=(0.5, 0.8), height=(0.35, 0.55), rooms={"garden": (2, 3), "balcony": 0.3})
def flower_bed(s: Size, rng: Generator) -> Parts:
    """A flower bed: soil with flowers inside an edging."""
    edge, low = pick(rng, (*STONES, *WOODS)), 0.16
    flowers: list[Part] = []
    for x in split(inset(s.x, 0.08), 6):
        y, top = rng.uniform(s.back + 0.12, s.front - 0.14), s.height - rng.uniform(0.0, 0.12)
        middle = sum(x) / 2
        flowers += [
            cone(about(middle, 0.16), about(y, 0.16), (low, top - 0.04), pick(rng, _GREENS), "leaves"),
            ball(about(middle, 0.12), about(y, 0.12), (top - 0.1, top), pick(rng, BRIGHT)),
        ]
    return (
        box(s.x, s.y, (0.0, low - 0.02), edge, "brick"),
        box(inset(s.x, 0.06), inset(s.y, 0.06), (low - 0.03, low), _SOIL, "carpet"),
        *flowers,
    )


@furniture(
    "garden table",
    width=(1.0, 1.5),
    depth=(0.8, 0.95),
    height=(0.72, 0.75),
    rooms={"garden": (1, 1), "balcony": 0.6},
    place=OnFloor("centre"),
)
def garden_table(s: Size, rng: Generator) -> Parts:
    """A table with a slatted top."""
    wood = pick(rng, (*WOODS, WHITE, METALS[1]))
    return (
        *(box(s.x, y, (s.height - 0.03, s.height), wood, "wood") for y in split(s.y, 6, 0.015)),
        *legs(s, s.height - 0.03, 0.06, wood),
        box(inset(s.x, 0.05), about(0.0, 0.05), (s.height - 0.08, s.height - 0.03), wood, "wood"),
    )


@furniture(
    "garden chair",
    width=(0.5, 0.58),
    depth=(0.5, 0.58),
    height=(0.85, 0.95),
    rooms={"garden": (2, 4), "balcony": (1, 2)},
    place=Around(("garden table", "breakfast table")),
)
def garden_chair(s: Size, rng: Generator) -> Parts:
    """A chair of slats with arm rests."""
    paint = pick(rng, (WHITE, *WOODS, GREEN))
    return (
        *legs(s, 0.62, 0.045, paint, margin=0.0),
        *(box(s.x, y, (0.4, 0.43), paint, "wood") for y in split(inset(s.y, 0.02), 4, 0.02)),
        *(box(x, (s.back, s.back + 0.03), (0.45, s.height), paint, "wood") for x in split(inset(s.x, 0.05), 4, 0.03)),
        *(box(x, s.y, (0.62, 0.65), paint, "wood") for x in ends(s.x, 0.05)),
    )


@furniture(
    "garden bench",
    width=(1.3, 1.7),
    depth=(0.55, 0.65),
    height=(0.85, 0.95),
    rooms={"garden": (1, 1), "balcony": 0.3},
    clearance=0.5,
)
def garden_bench(s: Size, rng: Generator) -> Parts:
    """A wooden bench for two or three people."""
    wood = pick(rng, (*WOODS, WHITE, GREEN))
    return (
        *legs(s, 0.62, 0.06, wood, margin=0.0),
        *(box(s.x, y, (0.4, 0.43), wood, "wood") for y in split(inset(s.y, 0.03), 5, 0.02)),
        *(box(s.x, (s.back, s.back + 0.04), z, wood, "wood") for z in split((0.5, s.height), 3, 0.04)),
        *(box(x, s.y, (0.6, 0.64), wood, "wood") for x in ends(s.x, 0.06)),
    )


@furniture(
    "barbecue",
    width=(0.9, 1.2),
    depth=(0.5, 0.6),
    height=(1.0, 1.15),
    rooms={"garden": (1, 1), "balcony": 0.3},
    clearance=0.5,
)
def barbecue(s: Size, rng: Generator) -> Parts:
    """A gas grill on legs, with a lid, knobs and a gas bottle."""
    paint = pick(rng, (BLACK, RED, STEEL))
    return (
        *legs(s, 0.75, 0.05, METALS[1], "metal"),
        box(s.x, s.y, (0.72, 0.78), STEEL, "metal"),
        box((s.left + 0.25, s.right - 0.1), inset(s.y, 0.03), (0.78, 0.9), BLACK, "metal"),
        box((s.left + 0.27, s.right - 0.12), inset(s.y, 0.06), (0.9, s.height), paint, "metal"),
        box((s.left + 0.35, s.right - 0.2), (s.front - 0.05, s.front), (0.94, 0.97), STEEL),
        cylinder(about(0.1, 0.28), about(0.0, 0.28), (0.02, 0.5), pick(rng, BRIGHT), "metal"),
        *(box(about(x, 0.05), (s.front - 0.04, s.front), (0.82, 0.87), STEEL) for x in (0.0, 0.15, 0.3)),
    )


@furniture(
    "planter",
    width=(0.4, 0.6),
    depth=(0.36, 0.5),
    height=(0.7, 1.2),
    rooms={"garden": (1, 3), "balcony": (2, 4), "lobby": (1, 2), "entrance hall": 0.4},
    place=AgainstWall(corner=True),
)
def planter(s: Size, rng: Generator) -> Parts:
    """A tub with a flowering shrub."""
    green, tub = pick(rng, _GREENS), pick(rng, (TERRACOTTA, TERRACOTTA, *STONES))
    return (
        box(inset(s.x, 0.04), inset(s.y, 0.04), (0.0, 0.34), tub, "plaster"),
        box(s.x, s.y, (0.3, 0.36), tub, "plaster"),
        ball(inset(s.x, 0.02), inset(s.y, 0.02), (0.32, s.height), green, "leaves"),
        *(
            ball(about(x, 0.09), (s.front - 0.13, s.front - 0.04), about(z * s.height, 0.09), pick(rng, BRIGHT))
            for x, z in ((-0.1, 0.6), (0.08, 0.72), (0.0, 0.52))
        ),
    )


@furniture(
    "parasol", width=(1.8, 2.2), depth=(1.8, 2.2), height=(2.2, 2.4), rooms={"garden": 0.6, "balcony": 0.3}, place=OnFloor()
)
def parasol(s: Size, rng: Generator) -> Parts:
    """A parasol: a cone of cloth on a pole in a heavy foot."""
    return (
        cylinder(about(0.0, 0.5), about(0.0, 0.5), (0.0, 0.1), STONES[0], "concrete"),
        cylinder(about(0.0, 0.05), about(0.0, 0.05), (0.1, s.height - 0.1), WOODS[0], "wood"),
        cone(s.x, s.y, (s.height - 0.45, s.height), pick(rng, (*BRIGHT, LINEN[0])), "fabric"),
    )


@furniture(
    "garden shed",
    width=(1.4, 1.9),
    depth=(1.1, 1.4),
    height=(1.9, 2.2),
    rooms={"garden": 0.4},
    place=AgainstWall(corner=True),
    clearance=0.5,
)
def garden_shed(s: Size, rng: Generator) -> Parts:
    """A shed of boards with a door and a window."""
    wood = pick(rng, (*WOODS, (0.4, 0.5, 0.42), (0.5, 0.25, 0.2)))
    return (
        box(inset(s.x, 0.06), inset(s.y, 0.06), (0.0, s.height - 0.08), wood, "wood"),
        box(s.x, s.y, (s.height - 0.1, s.height), (0.3, 0.3, 0.32), "tile"),
        box((s.left + 0.2, s.left + 0.85), (s.front - 0.06, s.front - 0.03), (0.03, 1.75), pick(rng, WOODS), "wood"),
        box((s.right - 0.45, s.right - 0.15), (s.front - 0.06, s.front - 0.03), (1.0, 1.4), (0.7, 0.82, 0.88), "glass"),
        box(about(s.left + 0.78, 0.03), (s.front - 0.03, s.front), (0.85, 1.0), BLACK),
    )


@furniture(
    "sun lounger",
    width=(0.6, 0.7),
    depth=(1.7, 1.9),
    height=(0.6, 0.8),
    rooms={"garden": 0.7, "balcony": 0.3},
    place=OnFloor(),
)
def sun_lounger(s: Size, rng: Generator) -> Parts:
    """A sun lounger with a mattress and a raised back."""
    cloth, wood = pick(rng, (*BRIGHT, *LINEN)), pick(rng, WOODS)
    return (
        box(s.x, s.y, (0.22, 0.28), wood, "wood"),
        *legs(s, 0.22, 0.06, wood),
        box(inset(s.x, 0.04), (s.back + 0.6, s.front - 0.03), (0.28, 0.36), cloth, "fabric"),
        *(
            box(inset(s.x, 0.04), y, (0.28, 0.36 + f * (s.height - 0.36)), cloth, "fabric")
            for y, f in zip(split((s.back + 0.03, s.back + 0.6), 4), (1.0, 0.75, 0.5, 0.25), strict=True)
        ),
    )


@furniture("swing", width=(1.6, 2.0), depth=(1.0, 1.3), height=(1.9, 2.1), rooms={"garden": 0.3}, place=OnFloor())
def swing(s: Size, rng: Generator) -> Parts:
    """A swing: a frame with one seat."""
    paint = pick(rng, BRIGHT)
    return (
        *legs(s, s.height - 0.06, 0.07, paint, "metal", margin=0.0),
        *(box(x, s.y, (s.height - 0.13, s.height - 0.06), paint, "metal") for x in ends(s.x, 0.07)),
        box(s.x, about(0.0, 0.07), (s.height - 0.07, s.height), paint, "metal"),
        *(box(about(x, 0.02), about(0.0, 0.02), (0.5, s.height - 0.06), BLACK) for x in (-0.22, 0.22)),
        box(about(0.0, 0.5), about(0.0, 0.22), (0.46, 0.5), pick(rng, BRIGHT), "wood"),
    )


@furniture("sandpit", width=(1.1, 1.4), depth=(1.1, 1.4), height=(0.24, 0.3), rooms={"garden": 0.3}, place=OnFloor())
def sandpit(s: Size, rng: Generator) -> Parts:
    """A sandpit: a frame of boards with sand, a bucket and a sand castle."""
    wood = pick(rng, WOODS)
    return (
        *(box(x, s.y, (0.0, 0.18), wood, "wood") for x in ends(s.x, 0.08)),
        *(box(s.x, y, (0.0, 0.18), wood, "wood") for y in ends(s.y, 0.08)),
        box(inset(s.x, 0.06), inset(s.y, 0.06), (0.0, 0.12), (0.86, 0.75, 0.52), "carpet"),
        cone(about(-0.15, 0.3), about(0.1, 0.3), (0.12, s.height), (0.86, 0.75, 0.52), "carpet"),
        cylinder(about(0.25, 0.16), about(-0.2, 0.16), (0.12, s.height), pick(rng, BRIGHT)),
    )


@furniture(
    "stepping stones",
    width=(1.6, 2.6),
    depth=(0.5, 0.6),
    height=(0.015, 0.02),
    rooms={"garden": (1, 2)},
    place=OnFloor("centre"),
    solid=False,
)
def stepping_stones(s: Size, rng: Generator) -> Parts:
    """A row of flagstones in the grass."""
    return tuple(
        box(x, inset(s.y, rng.uniform(0.0, 0.05)), (0.0, s.height), pick(rng, STONES), "concrete")
        for x in split(s.x, 4, 0.12)
    )


@furniture(
    "watering can",
    width=(0.3, 0.4),
    depth=(0.18, 0.22),
    height=(0.28, 0.34),
    rooms={"garden": 0.8, "balcony": 0.6},
    place=OnFloor(),
    solid=False,
)
def watering_can(s: Size, rng: Generator) -> Parts:
    """A watering can: a body, a spout and a handle."""
    paint = pick(rng, (GREEN, STEEL, *BRIGHT))
    return (
        cylinder((s.left, s.left + 0.2), about(0.0, 0.18), (0.0, 0.22), paint, "metal"),
        box((s.left + 0.18, s.right), about(0.0, 0.03), (0.17, 0.2), paint, "metal"),
        cylinder((s.right - 0.07, s.right), about(0.0, 0.07), (0.16, 0.22), paint, "metal"),
        box((s.left + 0.04, s.left + 0.16), about(0.0, 0.025), (s.height - 0.03, s.height), paint),
        *(
            box(x, about(0.0, 0.025), (0.2, s.height), paint)
            for x in ((s.left + 0.03, s.left + 0.055), (s.left + 0.145, s.left + 0.17))
        ),
    )


@furniture(
    "garden gnome",
    width=(0.2, 0.26),
    depth=(0.2, 0.24),
    height=(0.45, 0.6),
    rooms={"garden": 0.4},
    place=OnFloor(),
    solid=False,
)
def garden_gnome(s: Size, rng: Generator) -> Parts:
    """A garden gnome with a pointed hat."""
    h = s.height
    return (
        cylinder(inset(s.x, 0.02), inset(s.y, 0.02), (0.0, 0.45 * h), pick(rng, BRIGHT), "fabric"),
        ball(inset(s.x, 0.03), inset(s.y, 0.02), (0.4 * h, 0.68 * h), (0.9, 0.72, 0.6)),
        ball(about(0.0, 0.12), (0.02, s.front), (0.36 * h, 0.56 * h), WHITE, "carpet"),
        cone(inset(s.x, 0.03), inset(s.y, 0.03), (0.62 * h, h), RED),
    )


@furniture(
    "jug",
    width=(0.14, 0.18),
    depth=(0.12, 0.14),
    height=(0.22, 0.26),
    rooms={"garden": 0.7, "balcony": 0.5, "dining room": 0.4, "meeting room": 0.6},
    place=OnTop(("garden table", "dining table", "breakfast table", "meeting table")),
)
def jug(s: Size, rng: Generator) -> Parts:
    """A jug of lemonade or water."""
    drink = pick(rng, (BRIGHT[1], BRIGHT[5], (0.7, 0.84, 0.9)))
    return (
        cylinder((s.left, s.right - 0.04), s.y, (0.0, 0.7 * s.height), drink, "glass"),
        cylinder((s.left, s.right - 0.04), s.y, (0.7 * s.height, s.height), (0.8, 0.88, 0.9), "glass"),
        box((s.right - 0.04, s.right), about(0.0, 0.025), (0.05, 0.85 * s.height), (0.8, 0.88, 0.9)),
    )
