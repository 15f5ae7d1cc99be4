"""A kind of furniture of your own, and a house that contains it.

`@furniture` declares sizes, rooms and place; the function returns the solid shapes of one piece. Only houses that are built
after the declaration have such pieces. Run it: `python tests/examples/own_furniture.py`
"""

from numpy.random import Generator

from worlds import build_house, objects, sample_from_rooms
from worlds.furniture import DARK_WOODS, STEEL, WHITE, AgainstWall, Parts, Size, about, box, cylinder, furniture, pick


@furniture(
    "grand piano",
    width=(1.4, 1.5),  # ranges [m]
    depth=(1.5, 1.8),
    height=(0.95, 1.0),
    rooms={"living room": (1, 1)},  # exactly one in every living room; 0.2 would be an expected number
    place=AgainstWall(corner=True),
    clearance=0.6,  # floor kept free in front of the piano [m]
)
def grand_piano(s: Size, rng: Generator) -> Parts:
    """A case with a keyboard on three legs: x to the right, y to the front, z up, all inside the size [m]."""
    case = box(s.x, (s.back, s.front - 0.25), (0.6, s.height), pick(rng, DARK_WOODS), "wood")
    keyboard = box((s.left + 0.1, s.right - 0.1), (s.front - 0.25, s.front), (0.65, 0.75), WHITE)
    corners = ((s.left + 0.1, s.front - 0.4), (s.right - 0.1, s.front - 0.4), (0.0, s.back + 0.1))
    return (case, keyboard, *(cylinder(about(x, 0.1), about(y, 0.1), (0.0, 0.6), STEEL) for x, y in corners))


if __name__ == "__main__":
    house = build_house(sample_from_rooms(("living room", "kitchen", "bedroom"), seed=4))
    for thing in objects(house):
        if thing.kind == "grand piano":
            print(f"{thing.kind} in {thing.room} at {thing.centre} m")
