"""Furniture of dining rooms."""

from numpy.random import Generator

from worlds.furniture.kinds import Around, OnCeiling, OnFloor, OnTop, Parts, Size
from worlds.furniture.palette import BLACK, BRIGHT, DARK_WOODS, GLASS, LAMP, LINEN, STEEL, UPHOLSTERY, WHITE, WOODS, pick
from worlds.furniture.registry import furniture
from worlds.furniture.shapes import about, ball, box, cone, cylinder, ends, fronts, inset, legs, moved, shelf_unit, stocked


@furniture(
    "dining table",
    width=(1.3, 1.9),
    depth=(0.85, 1.0),
    height=(0.73, 0.76),
    rooms={"dining room": (1, 1), "kitchen": 0.15},
    place=OnFloor("centre"),
)
def dining_table(s: Size, rng: Generator) -> Parts:
    """A dining table on legs or a pedestal, sometimes with a table cloth."""
    wood, top = pick(rng, WOODS), (s.height - 0.04, s.height)
    if rng.random() < 0.35:
        cloth = pick(rng, LINEN)
        return (
            *legs(s, 0.5, 0.07, wood),
            box(s.x, s.y, (0.5, s.height - 0.01), cloth, "fabric"),
            box(s.x, s.y, (s.height - 0.01, s.height), cloth, "fabric"),
        )
    if rng.random() < 0.3:
        return (
            box(s.x, s.y, top, wood, "wood"),
            box(about(0.0, 0.3), about(0.0, 0.3), (0.04, top[0]), wood, "wood"),
            box(inset(s.x, 0.3), inset(s.y, 0.15), (0.0, 0.05), wood, "wood"),
        )
    return (box(s.x, s.y, top, wood, "wood"), *legs(s, top[0], 0.07, wood))


@furniture(
    "dining chair",
    width=(0.42, 0.48),
    depth=(0.44, 0.5),
    height=(0.88, 1.0),
    rooms={"dining room": (4, 6), "kitchen": (2, 4)},
    place=Around(("dining table", "breakfast table")),
)
def dining_chair(s: Size, rng: Generator) -> Parts:
    """A chair with a slatted or an upholstered back."""
    wood, seat = pick(rng, WOODS), pick(rng, UPHOLSTERY)
    high_back = box(inset(s.x, 0.03), (s.back, s.back + 0.05), (0.55, s.height), seat, "fabric")
    slats = [
        box(inset(s.x, 0.05), (s.back + 0.005, s.back + 0.03), (z, z + 0.07), wood, "wood")
        for z in (0.58, 0.72, s.height - 0.1)
    ]
    posts = [box(x, (s.back, s.back + 0.04), (0.4, s.height), wood, "wood") for x in ends(s.x, 0.04)]
    return (
        *legs(s, 0.42, 0.04, wood, margin=0.0),
        box(s.x, s.y, (0.42, 0.47), seat, "fabric"),
        *posts,
        *([high_back] if rng.random() < 0.5 else slats),
    )


@furniture(
    "breakfast table",
    width=(0.7, 0.9),
    depth=(0.7, 0.9),
    height=(0.73, 0.76),
    rooms={"kitchen": 0.35, "balcony": 0.2},
    place=OnFloor("centre"),
)
def breakfast_table(s: Size, rng: Generator) -> Parts:
    """A small round table."""
    return (
        cylinder(s.x, s.y, (s.height - 0.035, s.height), pick(rng, WOODS), "wood"),
        cylinder(about(0.0, 0.08), about(0.0, 0.08), (0.03, s.height - 0.035), BLACK, "metal"),
        cylinder(inset(s.x, 0.18), inset(s.y, 0.18), (0.0, 0.03), BLACK, "metal"),
    )


@furniture(
    "plate",
    width=(0.24, 0.28),
    depth=(0.24, 0.28),
    height=(0.03, 0.05),
    rooms={"dining room": (4, 5), "kitchen": 0.8},
    place=OnTop(("dining table", "breakfast table", "kitchen counter")),
)
def plate(s: Size, rng: Generator) -> Parts:
    """A plate with food on it."""
    return (
        cylinder(s.x, s.y, (0.0, 0.02), pick(rng, (WHITE, *LINEN[:3])), "ceramic"),
        cylinder(inset(s.x, 0.05), inset(s.y, 0.05), (0.02, s.height), pick(rng, (WHITE, *BRIGHT)), "ceramic"),
    )


@furniture(
    "wine glass",
    width=(0.07, 0.08),
    depth=(0.07, 0.08),
    height=(0.18, 0.22),
    rooms={"dining room": (2, 4)},
    place=OnTop(("dining table",)),
)
def wine_glass(s: Size, rng: Generator) -> Parts:
    """A wine glass: a bowl on a stem."""
    return (
        cylinder(s.x, s.y, (0.0, 0.01), GLASS),
        cylinder(about(0.0, 0.012), about(0.0, 0.012), (0.01, 0.1), GLASS),
        cylinder(s.x, s.y, (0.1, s.height), pick(rng, (GLASS, (0.5, 0.1, 0.16))), "glass"),
    )


@furniture(
    "candlestick",
    width=(0.1, 0.12),
    depth=(0.1, 0.12),
    height=(0.28, 0.36),
    rooms={"dining room": 0.7, "living room": 0.3},
    place=OnTop(("dining table", "sideboard", "coffee table")),
)
def candlestick(s: Size, rng: Generator) -> Parts:
    """A candlestick with a lit candle."""
    return (
        cylinder(s.x, s.y, (0.0, 0.02), (0.8, 0.65, 0.25), "metal"),
        cylinder(about(0.0, 0.03), about(0.0, 0.03), (0.02, 0.12), (0.8, 0.65, 0.25), "metal"),
        cylinder(about(0.0, 0.025), about(0.0, 0.025), (0.12, s.height - 0.03), pick(rng, (WHITE, *BRIGHT[:2]))),
        cone(about(0.0, 0.015), about(0.0, 0.015), (s.height - 0.03, s.height), (1.0, 0.75, 0.2)),
    )


@furniture(
    "sideboard",
    width=(1.2, 1.8),
    depth=(0.38, 0.46),
    height=(0.78, 0.9),
    rooms={"dining room": (1, 1), "living room": 0.3, "meeting room": 0.6},
    clearance=0.5,
)
def sideboard(s: Size, rng: Generator) -> Parts:
    """A sideboard: a long, low cabinet with four doors, on legs."""
    wood = pick(rng, WOODS)
    return (
        *legs(s, 0.12, 0.05, wood),
        box(s.x, (s.back, s.front - 0.025), (0.12, s.height), wood, "wood"),
        *fronts(s.x, (0.12, s.height - 0.03), s.front - 0.005, 4, 1, wood, BLACK),
    )


@furniture(
    "china cabinet",
    width=(0.9, 1.3),
    depth=(0.38, 0.45),
    height=(1.8, 2.1),
    rooms={"dining room": (1, 1), "living room": 0.05},
    clearance=0.5,
)
def china_cabinet(s: Size, rng: Generator) -> Parts:
    """A cabinet with dishes on open shelves, above wooden doors."""
    wood = pick(rng, DARK_WOODS)
    upper = Size(s.width, s.depth - 0.08, s.height - 0.8)
    shelves = (*shelf_unit(upper, 3, wood), *stocked(upper, 3, ("ceramic", "glass", "food"), WHITE, rng, fill=1.0))
    lifted = tuple(moved(part, y=-0.04, z=0.8) for part in shelves)
    return (
        box(s.x, (s.back, s.front - 0.025), (0.0, 0.8), wood, "wood"),
        *fronts(s.x, (0.05, 0.78), s.front - 0.005, 2, 1, wood, STEEL),
        *lifted,
    )


@furniture(
    "chandelier", width=(0.6, 0.8), depth=(0.6, 0.8), height=(0.55, 0.7), rooms={"dining room": (1, 1)}, place=OnCeiling()
)
def chandelier(s: Size, rng: Generator) -> Parts:
    """A chandelier: four lamps on a cross of bars, or one lamp in a cone of cloth."""
    metal = pick(rng, (BLACK, STEEL, (0.8, 0.65, 0.25)))
    rod = cylinder(about(0.0, 0.03), about(0.0, 0.03), (0.12, s.height), metal, "metal")
    if rng.random() < 0.5:
        bars = (box(s.x, about(0.0, 0.03), (0.1, 0.13), metal), box(about(0.0, 0.03), s.y, (0.1, 0.13), metal))
        ends = [
            (x, y) for x, y in ((s.left + 0.05, 0.0), (s.right - 0.05, 0.0), (0.0, s.back + 0.05), (0.0, s.front - 0.05))
        ]
        return (rod, *bars, *(ball(about(x, 0.1), about(y, 0.1), (0.13, 0.25), LAMP) for x, y in ends))
    return (
        rod,
        cone(s.x, s.y, (0.0, 0.3), pick(rng, UPHOLSTERY), "fabric"),
        ball(about(0.0, 0.12), about(0.0, 0.12), (0.0, 0.12), LAMP),
    )
