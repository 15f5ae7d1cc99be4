"""A house drawn by hand: three rooms with a door, an arch and an open boundary, checked and walked.

Coordinates are in metres, x to the east and y to the north. Windows and furniture are filled in.
Run it: `python tests/examples/drawn_house.py`
"""

import numpy as np

from worlds import HouseSpec, Walkable, build_house, validate
from worlds.spec import LeafSpec, OpeningSpec, RoomSpec, StoreySpec

ROOMS = (
    RoomSpec(id="kitchen", label="kitchen", polygon_m=((0, 0), (4, 0), (4, 3), (0, 3))),
    RoomSpec(id="lounge", label="living room", polygon_m=((4, 0), (9, 0), (9, 5), (4, 5))),
    RoomSpec(id="study", label="office", polygon_m=((0, 3), (4, 3), (4, 5), (0, 5))),
)
OPENINGS = (
    OpeningSpec(rooms=("kitchen", "lounge"), kind="open", start_m=(4, 0.5), end_m=(4, 2.5)),
    OpeningSpec(rooms=("study", "lounge"), kind="door", start_m=(4, 3.5), end_m=(4, 4.4), leaf=LeafSpec(into="study")),
    OpeningSpec(rooms=("kitchen", "study"), kind="arch", start_m=(1.5, 3), end_m=(2.6, 3)),
)


def main() -> np.ndarray:
    """Validate the house and print the shortest path from the study to the kitchen."""
    house = build_house(HouseSpec(name="drawn", storeys=(StoreySpec(rooms=ROOMS, openings=OPENINGS),)))
    validate(house)  # raises HouseError, which names the room or object
    walkable = Walkable(house)  # for a body of 0.25 m radius
    study, kitchen = (int(walkable.nodes_in(room)[0]) for room in ("study", "kitchen"))
    path = walkable.path(study, kitchen)
    print(f"{np.linalg.norm(np.diff(path, axis=0), axis=1).sum():.1f} m over {len(path)} corners")
    return path


if __name__ == "__main__":
    main()
