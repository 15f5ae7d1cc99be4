"""Kinds of buildings: which rooms they hold, on which storeys, and how they are laid out."""

from dataclasses import dataclass, replace

from worlds.floor_plans.floor_plan import PlanStyle
from worlds.floor_plans.programmes import LayoutShares


@dataclass(frozen=True)
class BuildingKind:
    """A family of buildings, such as homes or schools."""

    rooms: tuple[int, int]
    """Range from which the number of rooms is drawn if the caller gives no number; corridors, halls and stairs are not
    counted."""
    storeys: tuple[int, ...]
    """Possible numbers of storeys; one is drawn if the caller gives no number."""
    first: tuple[str, ...]
    """Labels of the rooms that a building gets before any others, the most important first. A building with few rooms gets
    only the beginning of this list."""
    more: tuple[str, ...]
    """Labels from which further rooms are drawn."""
    style: PlanStyle
    """Dimensions of the floor plans."""
    shares: LayoutShares
    """Shares of storeys with an open plan, and of rooms that have the shape of another room."""
    halls: tuple[str | None, ...] = (None,)
    """Possible labels of the hall at the start of the ground storey's corridor; one is drawn. None: no hall."""
    upstairs: tuple[str, ...] = ()
    """Labels of rooms that belong on upper storeys."""
    repeats: float = 0.0
    """Share of buildings whose upper storeys are all equal."""
    flat: tuple[int, int] | None = None
    """Range from which the number of rooms per storey is drawn for a building of several storeys, if the caller gives no
    number of rooms. None: the number for the whole building is drawn from `rooms`, as for one storey."""
    shuffled: int = 0
    """When the order of `first` is shuffled, every label moves by fewer places than this number; 0 and 1 keep the order."""


_HOME_STYLE = PlanStyle(spine_m=(1.5, 2.1), stairs=(None, None, "U", "L", "straight"))
_OFFICE_STYLE = PlanStyle(spine_m=(1.6, 2.2), depth_m=(3.8, 4.8), heights_m=(2.6, 2.8, 3.0), one_sided_m=(8.0, 14.0))
_CLINIC_STYLE = PlanStyle(
    spine_m=(2.2, 2.8), depth_m=(4.0, 5.2), heights_m=(2.8, 3.0, 3.2), stairs=("U", "L"), one_sided_m=(6.0, 10.0),
    winged_m=30.0, wings=0.8,
)  # fmt: skip

BUILDING_KINDS: dict[str, BuildingKind] = {
    "home": BuildingKind(
        (7, 8), (2,), ("living room", "kitchen", "dining room", "garden", "bedroom", "bathroom", "children's room"),
        ("toilet", "office", "bedroom", "pantry", "laundry room", "garage", "storage room", "balcony", "bathroom",
         "children's room"),
        _HOME_STYLE, LayoutShares(open_plan=1.0, twins=0.2), (None, None, None, "entrance hall"),
        ("bedroom", "children's room", "bathroom", "office", "library"),
    ),
    "apartment": BuildingKind(
        (4, 8), (1, 1, 1, 2, 3), ("living room", "kitchen", "bedroom", "bathroom", "dining room", "balcony", "bedroom"),
        ("children's room", "storage room", "toilet", "office", "laundry room", "bedroom", "bathroom", "pantry", "library"),
        _HOME_STYLE, LayoutShares(open_plan=0.6, twins=0.25), ("entrance hall", None), repeats=1.0, shuffled=1, flat=(4, 6),
    ),
    "office": BuildingKind(
        (7, 14), (1, 2, 2, 3), ("office", "office", "meeting room", "office", "kitchen", "open-plan office", "toilet"),
        ("office", "office", "office", "print room", "storage room", "meeting room", "library", "lobby", "open-plan office",
         "toilet", "balcony", "laboratory"),
        _OFFICE_STYLE, LayoutShares(open_plan=0.3, twins=0.7), ("lobby", "entrance hall", None), repeats=0.5, shuffled=2,
    ),
    "ori": BuildingKind(
        (7, 7), (2,), ("kitchen", "office", "office", "office", "office", "meeting room", "print room"),
        ("office",), replace(_OFFICE_STYLE, one_sided_m=(18.0, 30.0)), LayoutShares(twins=0.9), (None, "lobby"),
    ),
    "uh2-apt": BuildingKind(
        (4, 4), (3,), ("living room", "dining room", "bedroom", "bathroom"), ("bedroom", "office", "storage room"),
        PlanStyle((2.0, 2.3), (3.6, 4.2), stairs=(None,), one_sided_m=(30.0, 40.0)), LayoutShares(open_plan=1.0),
        upstairs=("bedroom", "bathroom"),
    ),
    "uh2-office": BuildingKind(
        (11, 13), (1,), ("open-plan office", "meeting room", "office", "office", "office", "open-plan office", "office"),
        ("office", "office", "meeting room"), replace(_OFFICE_STYLE, one_sided_m=(5.0, 6.0), wings=0.5, spine_m=(1.9, 2.4)),
        LayoutShares(twins=0.6),
    ),
    "clinic": BuildingKind(
        (10, 16), (1, 1, 2), ("office", "office", "laboratory", "toilet", "office", "storage room", "bathroom", "bedroom"),
        ("office", "bedroom", "office", "bathroom", "toilet", "storage room", "kitchen", "meeting room", "laundry room",
         "gym", "laboratory", "print room", "lobby"),
        _CLINIC_STYLE, LayoutShares(twins=0.7), ("lobby", "lobby", "entrance hall"),
    ),
    "school": BuildingKind(
        (9, 15), (1, 2, 2), ("classroom", "classroom", "office", "toilet", "library", "classroom", "gym", "storage room"),
        ("classroom", "classroom", "laboratory", "toilet", "office", "storage room", "kitchen", "dining room",
         "meeting room", "print room", "bathroom"),
        replace(_CLINIC_STYLE, depth_m=(4.6, 6.0)), LayoutShares(twins=0.7), ("entrance hall", "lobby", None), repeats=0.3,
    ),
}  # fmt: skip
