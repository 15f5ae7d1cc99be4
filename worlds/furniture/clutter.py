"""Things that pile up in cluttered rooms. They appear only if `clutter` is above 1, which is its value in a usual home."""

from numpy.random import Generator

from worlds.furniture.kinds import AgainstWall, OnFloor, OnTop, Parts, PerClutter, Size
from worlds.furniture.palette import BRIGHT, CARDBOARD, GREEN, LINEN, PAPER, TERRACOTTA, UPHOLSTERY, WHITE, pick
from worlds.furniture.registry import furniture
from worlds.furniture.shapes import about, ball, box, cylinder, inset, split
from worlds.labels import CIRCULATION_LABELS, LIVED_IN_LABELS, OUTDOOR_LABELS
from worlds.parts import Part

_WORKED_IN = ("office", "meeting room", "open-plan office", "classroom", "laboratory", "print room")
_STORES = ("storage room", "garage", "laundry room", "pantry")
_TOPS = (
    "dining table", "breakfast table", "coffee table", "side table", "sideboard", "console table", "dresser", "desk",
    "double desk", "small desk", "toy shelf", "nightstand", "kitchen counter", "kitchen island", "tv stand",
    "bookshelf", "reading table", "meeting table", "school desk", "teacher's desk", "lab bench", "copy counter",
    "file cabinet", "washing machine", "tumble dryer", "shoe rack",
)  # fmt: skip


def _each(labels: tuple[str, ...], per_clutter: float) -> dict[str, PerClutter]:
    return dict.fromkeys(labels, PerClutter(per_clutter))


@furniture(
    "box pile",
    width=(0.42, 0.62),
    depth=(0.34, 0.46),
    height=(0.5, 1.6),
    rooms=_each((*LIVED_IN_LABELS, *_STORES, *CIRCULATION_LABELS), 1.3)
    | _each((*_WORKED_IN, "kitchen", "gym"), 0.7)
    | _each(("bathroom",), 0.3),
    place=AgainstWall(beside=("box pile", "cardboard boxes")),
)
def box_pile(s: Size, rng: Generator) -> Parts:
    """A stack of labelled cardboard boxes that are not quite aligned."""
    boxes: list[Part] = []
    for z in split(s.z, max(2, round(s.height / 0.33)), 0.004):
        left, right, back, front = rng.uniform(0.0, 0.07, 4)
        shade = rng.uniform(0.85, 1.1)
        brown = (CARDBOARD[0] * shade, CARDBOARD[1] * shade, CARDBOARD[2] * shade)
        boxes.append(box((s.left + left, s.right - right), (s.back + back, s.front - front), z, brown, "label"))
    return tuple(boxes)


@furniture(
    "book pile",
    width=(0.24, 0.34),
    depth=(0.2, 0.28),
    height=(0.2, 0.8),
    rooms=_each((*LIVED_IN_LABELS, "office"), 1.8) | _each(CIRCULATION_LABELS, 0.5) | _each(("classroom",), 0.5),
    place=OnFloor(),
)
def book_pile(s: Size, rng: Generator) -> Parts:
    """A stack of books on the floor."""
    books: list[Part] = []
    for z in split(s.z, max(5, round(s.height / 0.045))):
        left, right, back, front = rng.uniform(0.0, 0.05, 4)
        books.append(
            box((s.left + left, s.right - right), (s.back + back, s.front - front), z, pick(rng, (*BRIGHT, *UPHOLSTERY)))
        )
    return tuple(books)


@furniture(
    "newspapers",
    width=(0.3, 0.36),
    depth=(0.22, 0.27),
    height=(0.15, 0.7),
    rooms=_each(("living room", "dining room", "kitchen", "library", "garage", "storage room"), 0.6)
    | _each((*_WORKED_IN, *CIRCULATION_LABELS), 0.6),
    place=AgainstWall(beside=("newspapers", "box pile")),
)
def newspapers(s: Size, rng: Generator) -> Parts:
    """Bundles of old newspapers, tied with string."""
    string = pick(rng, BRIGHT)
    bundles = split(s.z, max(1, round(s.height / 0.16)), 0.004)
    papers = [box(inset(s.x, rng.uniform(0.005, 0.02)), inset(s.y, 0.006), z, PAPER, "scribble") for z in bundles]
    return (*papers, box(about(0.0, 0.012), s.y, s.z, string), box((s.left, s.right), about(0.0, 0.012), s.z, string))


@furniture(
    "carrier bags",
    width=(0.3, 0.5),
    depth=(0.24, 0.36),
    height=(0.28, 0.44),
    rooms=_each(("kitchen", "pantry", "corridor", "entrance hall", "living room", "bedroom", "storage room"), 0.8)
    | _each(("office", "dining room", "balcony", "lobby"), 0.4),
    place=AgainstWall(),
)
def carrier_bags(s: Size, rng: Generator) -> Parts:
    """Two full carrier bags, side by side."""
    bags: list[Part] = []
    for x in split(s.x, 2, 0.01):
        colour, top = pick(rng, (*BRIGHT, WHITE)), s.height * rng.uniform(0.6, 0.85)
        bags += [
            box(x, (s.back, s.front), (0.0, top), colour, "label"),
            *(box(about((x[0] + x[1]) / 2, 0.1), about(y, 0.015), (top, s.height), colour) for y in (-0.06, 0.06)),
        ]
    return tuple(bags)


@furniture(
    "heap of clothes",
    width=(0.6, 0.95),
    depth=(0.5, 0.75),
    height=(0.16, 0.34),
    rooms=_each(("bedroom", "children's room", "laundry room"), 1.0) | _each(("bathroom", "living room", "gym"), 0.4),
    place=OnFloor(),
    solid=False,
)
def heap_of_clothes(s: Size, rng: Generator) -> Parts:
    """A heap of clothes on the floor."""
    heap = [ball(inset(s.x, 0.04), inset(s.y, 0.04), (0.0, 0.8 * s.height), pick(rng, UPHOLSTERY), "fabric")]
    for x in split(s.x, 3):
        y, top = rng.uniform(-0.1, 0.1), rng.uniform(0.75, 1.0) * s.height
        heap.append(ball(x, about(y, 0.6 * s.depth), (0.0, top), pick(rng, (*LINEN, *UPHOLSTERY, *BRIGHT)), "fabric"))
    return (
        *heap,
        box(s.x, about(0.1, 0.12), (0.0, 0.03), pick(rng, LINEN), "fabric"),
        box(about(-0.05, 0.12), s.y, (0.0, 0.03), WHITE, "fabric"),
    )


@furniture(
    "scattered toys",
    width=(0.6, 1.0),
    depth=(0.5, 0.9),
    height=(0.1, 0.2),
    rooms=_each(("children's room",), 1.5)
    | _each(("living room", "garden"), 0.5)
    | _each(("corridor", "dining room"), 0.25),
    place=OnFloor(),
    solid=False,
)
def scattered_toys(s: Size, rng: Generator) -> Parts:
    """Toys scattered over the floor: blocks, balls and cylinders."""
    toys: list[Part] = []
    for i, x in enumerate(split(s.x, 4)):
        for j, y in enumerate(split(s.y, 3)):
            side = min(s.height, rng.uniform(0.05, 0.14))
            at_x, at_y = rng.uniform(x[0] + side / 2, x[1] - side / 2), rng.uniform(y[0] + side / 2, y[1] - side / 2)
            shape = (box, ball, cylinder)[int(rng.integers(3))]
            toys.append(
                shape(about(at_x, side), about(at_y, side), (0.0, side if i + j else s.height), pick(rng, BRIGHT), "label")
            )
    return tuple(toys)


@furniture(
    "empty bottles",
    width=(0.3, 0.5),
    depth=(0.26, 0.4),
    height=(0.26, 0.32),
    rooms=_each(("kitchen", "pantry", "garage", "balcony"), 0.8) | _each(("living room", "corridor", "storage room"), 0.4),
    place=AgainstWall(corner=True),
)
def empty_bottles(s: Size, rng: Generator) -> Parts:
    """Empty bottles that stand close together on the floor."""
    glass = (GREEN, (0.4, 0.26, 0.12), (0.7, 0.8, 0.78))
    bottles: list[Part] = []
    for x in split(s.x, max(3, round(s.width / 0.09))):
        for y in split(s.y, max(3, round(s.depth / 0.09))):
            colour, top = pick(rng, glass), s.height * rng.uniform(0.9, 1.0)
            bottles += [
                cylinder(inset(x, 0.004), inset(y, 0.004), (0.0, 0.62 * top), colour, "label"),
                cylinder(inset(x, 0.028), inset(y, 0.028), (0.62 * top, top), colour),
            ]
    return tuple(bottles)


@furniture(
    "shoes",
    width=(0.5, 0.9),
    depth=(0.28, 0.32),
    height=(0.1, 0.14),
    rooms=_each(("entrance hall", "corridor"), 0.8) | _each(("bedroom", "children's room", "gym"), 0.4),
    place=AgainstWall(),
    solid=False,
)
def shoes(s: Size, rng: Generator) -> Parts:
    """A row of pairs of shoes along the wall; the toes point into the room."""
    pairs: list[Part] = []
    for x in split(s.x, max(3, round(s.width / 0.22)), 0.03):
        leather = pick(rng, (*UPHOLSTERY, *BRIGHT, WHITE))
        for foot in split(x, 2, 0.01):
            pairs += [
                box(foot, s.y, (0.0, 0.5 * s.height), leather, "fabric"),
                box(foot, (s.back, -0.02), (0.5 * s.height, s.height), leather, "fabric"),
            ]
    return tuple(pairs)


@furniture(
    "flower pots",
    width=(0.4, 0.7),
    depth=(0.26, 0.36),
    height=(0.3, 0.6),
    rooms=_each(OUTDOOR_LABELS, 1.0) | _each(("living room", "dining room", "lobby"), 0.5),
    place=AgainstWall(),
)
def flower_pots(s: Size, rng: Generator) -> Parts:
    """A row of flower pots with plants of different heights."""
    pots: list[Part] = []
    for x in split(s.x, max(2, round(s.width / 0.2)), 0.01):
        top = s.height * rng.uniform(0.75, 1.0)
        pots += [
            cylinder(inset(x, 0.01), inset(s.y, 0.02), (0.0, 0.16), pick(rng, (TERRACOTTA, WHITE, *BRIGHT)), "ceramic"),
            ball(x, s.y, (0.12, top), GREEN, "leaves"),
        ]
    return tuple(pots)


@furniture(
    "stowed boxes",
    width=(0.32, 0.46),
    depth=(0.24, 0.3),
    height=(0.16, 0.28),
    rooms=_each(("bedroom", "children's room", "living room", "library", "office", "entrance hall"), 0.7)
    | _each(("storage room", "garage", "pantry", "print room", "classroom", "laboratory"), 0.5),
    place=OnTop(
        (
            "wardrobe",
            "bookshelf",
            "metal shelf",
            "pantry shelf",
            "binder shelf",
            "china cabinet",
            "shoe rack",
            "file cabinet",
        )
    ),
)
def stowed_boxes(s: Size, rng: Generator) -> Parts:
    """A box with a lid, on top of a high piece of furniture."""
    paint = pick(rng, (CARDBOARD, *BRIGHT, *LINEN))
    return (
        box(inset(s.x, 0.01), inset(s.y, 0.01), (0.0, s.height - 0.05), paint, "label"),
        box(s.x, s.y, (s.height - 0.06, s.height), pick(rng, (paint, WHITE)), "plain"),
    )


@furniture(
    "odds and ends",
    width=(0.3, 0.42),
    depth=(0.22, 0.3),
    height=(0.08, 0.24),
    rooms=_each((*LIVED_IN_LABELS, "kitchen", "corridor", "entrance hall"), 0.6)
    | _each((*_WORKED_IN, "laundry room", "lobby", "storage room"), 0.6),
    place=OnTop(_TOPS),
)
def odds_and_ends(s: Size, rng: Generator) -> Parts:
    """Papers, tins, boxes and books, as they collect on any free surface."""
    things: list[Part] = [box(inset(s.x, 0.03), inset(s.y, 0.02), (0.0, 0.02), PAPER, "scribble")]
    for x in split(s.x, 3, 0.01):
        for y in split(s.y, 2, 0.01):
            colour, top = pick(rng, (*BRIGHT, *LINEN)), s.height * rng.uniform(0.3, 1.0)
            if rng.random() < 0.4:
                things.append(cylinder(inset(x, 0.01), inset(y, 0.01), (0.0, top), colour, "label"))
            else:
                things.append(box(x, y, (0.0, top), colour, ("label", "books", "fabric")[int(rng.integers(3))]))
    return tuple(things)
