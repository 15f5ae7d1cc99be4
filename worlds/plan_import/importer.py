"""`import_plan`: turns a floor plan drawn elsewhere (GeoJSON or SVG) into a house, and checks that the house can be built.

Drawings are imprecise, so the plan is corrected in steps:

1. The whole plan is turned so that its walls run along x and y, and moved to the origin if it is in map coordinates.
2. Corners that nearly line up move to common lines.
3. Openings move to the nearest wall; those in outer walls are left out.
4. Openings are added where the drawn openings do not connect all rooms.

Anything that cannot be interpreted is refused with its place in the file. For the formats see
`worlds.plan_import.geojson` and `worlds.plan_import.svg`.
"""

import math
import re
import unicodedata
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path

from worlds.errors import SpecError, WorldsError, reworded
from worlds.plan_import.added_openings import added_openings
from worlds.plan_import.drawn_openings import is_drawn_again, opening_on_wall, without_overlaps
from worlds.plan_import.drawn_plan import DrawnPlan, DrawnRoom, Stroke, validated
from worlds.plan_import.geojson import read_geojson, to_geojson
from worlds.plan_import.straighten import main_direction, straighten, turned
from worlds.reading import read_text
from worlds.spec import HouseSpec, OpeningSpec, Point, RoomSpec, StoreySpec
from worlds.valid_names import listed
from worlds.validation import built_and_checked

_SLAB_M = 0.3
_FAR_M = 900.0
_WIDER_SNAPS_M = (0.1, 0.15, 0.2, 0.25, 0.3)
"""Values of `snap_m` that are tried for an invalid plan, to suggest a value with which it would be valid [m]."""
_EXACT_M = 0.001
"""Value of `snap_m` that is tried first [m]. A plan that is valid with this value is kept as drawn."""


@dataclass(frozen=True)
class ImportedPlan:
    """A house, and notes on how the drawing was changed to obtain it."""

    spec: HouseSpec
    notes: tuple[str, ...]
    """Notes for the user, one line each."""


def import_plan(
    path: Path | str,
    *,
    metres_per_unit: float | None = None,
    snap_m: float = 0.05,
    only_drawn: bool = False,
    name: str | None = None,
    seed: int = 0,
) -> ImportedPlan:
    """Return the house that a floor plan shows, without windows and furniture, which `build_house` adds later.

    Rooms that the drawn openings do not reach get doors. Stairs without drawn openings get one opening at the foot and one
    at the head of each flight; spiral stairs and lifts get one opening on every storey.

    Args:
        path: a file of at most 16 MB that ends in .svg, .geojson or .json.
        metres_per_unit: length of a unit of the drawing [m]. None stands for 1 m in GeoJSON; in SVG, it stands for the scale
            that the root element states.
        snap_m: greatest distance by which corners are moved to common lines, if the plan is invalid as drawn [m]. If rooms
            are drawn with gaps for the walls between them, give the thickness of the walls.
        only_drawn: whether the house gets only the drawn openings, even if these do not reach every room.
        name: name of the house. None stands for the name of the file without its ending.
        seed: seed of the house.

    Raises:
        WorldsError: if the plan cannot be read or is not a valid house. The message names the file and the room or opening.
    """
    path = Path(path)
    if metres_per_unit is not None and not 0.0 < metres_per_unit < 1e6:
        raise SpecError(f"metres_per_unit is {metres_per_unit}; valid: above 0, below 1e6")
    if not 0.001 <= snap_m <= 0.3:
        raise SpecError(f"snap_m is {snap_m}; valid: 0.001 to 0.3")
    doubt = ""
    try:
        drawing = _read(path, metres_per_unit)
        doubt = drawing.doubt
        spec, notes = _valid_house(_Plan(drawing, (name or path.stem)[:200], seed, only_drawn), snap_m)
    except WorldsError as error:
        raise reworded(error, f"{path}: {error}{doubt}") from None
    return ImportedPlan(spec, (*drawing.notes, *notes))


@dataclass(frozen=True)
class _Plan:
    """A drawing with the options of `import_plan`."""

    drawing: DrawnPlan
    name: str
    seed: int
    only_drawn: bool


def _valid_house(plan: _Plan, snap_m: float) -> tuple[HouseSpec, list[str]]:
    """Return a valid house and notes for the user.

    This is the house as drawn, or else, if that is invalid, the house with corners moved to common lines by up to `snap_m`
    [m]. Raises `WorldsError` if both are invalid. The message suggests an option with which the plan is valid, if there is
    such an option.
    """
    with suppress(WorldsError):
        return _checked_house(plan, _EXACT_M)
    try:
        spec, notes = _checked_house(plan, snap_m)
    except WorldsError as error:
        raise reworded(error, f"{error}{_suggestion(plan, snap_m)}") from None
    return spec, [*notes, f"corners no more than {snap_m:g} m off were moved to common lines"]


def _suggestion(plan: _Plan, snap_m: float) -> str:
    """Return the end of an error message: an option with which the plan would be valid. Empty if no such option is found."""
    for wider_m in (wider_m for wider_m in _WIDER_SNAPS_M if wider_m > snap_m):
        with suppress(WorldsError):
            _checked_house(plan, wider_m)
            return f"; the plan is valid with --snap {wider_m:g} (in Python snap_m={wider_m:g})"
    if plan.only_drawn:
        with suppress(WorldsError):
            _valid_house(replace(plan, only_drawn=False), snap_m)
            return "; the plan is valid without --only-drawn (in Python only_drawn=False)"
    return ""


def _checked_house(plan: _Plan, snap_m: float) -> tuple[HouseSpec, list[str]]:
    """Return the house with corners moved by up to `snap_m` [m], and notes on what was changed in the drawing.

    Raises `WorldsError` if the house cannot be built or does not pass the checks.
    """
    spec, notes = _house(plan, snap_m)
    built_and_checked(spec)
    return spec, notes


def _read(path: Path, metres_per_unit: float | None) -> DrawnPlan:
    match path.suffix.lower():
        case ".svg":
            from worlds.plan_import.svg import read_svg  # imported here because its library takes a second to load

            return read_svg(read_text(path), metres_per_unit)
        case ".geojson" | ".json":
            return read_geojson(read_text(path), 1.0 if metres_per_unit is None else metres_per_unit)
    raise SpecError(f"ends in {path.suffix!r}; valid: .svg, .geojson, .json")


def _house(plan: _Plan, snap_m: float) -> tuple[HouseSpec, list[str]]:
    notes: list[str] = []
    drawing = plan.drawing
    angle = main_direction(drawing.rooms)
    if angle:
        notes.append(f"turned by {-math.degrees(angle):.2f} degrees, so that walls run along x and y")
    outlines = [(room, turned(room.corners, angle)) for room in drawing.rooms]
    shift = _shift([corner for _, corners in outlines for corner in corners])
    if shift != (0.0, 0.0):
        notes.append(f"moved by ({shift[0]:.0f}, {shift[1]:.0f}) m, so that the origin is at a corner of the plan")
    polygons = straighten([(room, _moved(corners, shift)) for room, corners in outlines], snap_m)
    ids = _ids(drawing.rooms)
    rooms = [
        validated(room.where, RoomSpec, id=identifier, label=room.label, polygon_m=polygon, climb=room.climb)
        for identifier, room, polygon in zip(ids, drawing.rooms, polygons, strict=True)
    ]
    storeys = _storeys(drawing, rooms)
    names = {identifier: room.name for room, identifier in zip(drawing.rooms, ids, strict=True)}
    strokes = [(stroke, _moved(turned(stroke.points, angle), shift)) for stroke in drawing.strokes]
    drawn, outside = _drawn_openings(strokes, storeys, names)
    notes += outside
    storeys = [s.model_copy(update={"openings": drawn.get(level, ())}) for level, s in enumerate(storeys)]
    slab_m = _SLAB_M if drawing.slab_m is None else drawing.slab_m
    fields = {"name": plan.name, "seed": plan.seed, "slab_m": slab_m, "storeys": tuple(storeys)}
    spec = validated("the house", HouseSpec, **fields)
    return (spec if plan.only_drawn else _with_added_openings(spec, notes)), notes


def _with_added_openings(spec: HouseSpec, notes: list[str]) -> HouseSpec:
    """Add openings where the drawn openings do not connect all rooms, and return the house.

    A note that lists the added openings is appended to `notes`.
    """
    storeys, added = spec.storeys, added_openings(spec)
    listing = [f"{opening.rooms[0]} - {opening.rooms[1]} ({opening.kind})" for openings in added for opening in openings]
    if listing:
        drawn = "the drawn openings do not reach every room" if any(s.openings for s in storeys) else "no openings are drawn"
        notes.append(f"{drawn}; added, so that every room can be reached: {listed(listing)}")
    whole = (s.model_copy(update={"openings": (*s.openings, *more)}) for s, more in zip(storeys, added, strict=True))
    return spec.model_copy(update={"storeys": tuple(whole)})


def _drawn_openings(
    strokes: Sequence[tuple[Stroke, Sequence[Point]]], storeys: Sequence[StoreySpec], names: Mapping[str, str]
) -> tuple[dict[int, tuple[OpeningSpec, ...]], list[str]]:
    """Return the openings of each storey, and notes on the strokes left out: those out of the house, and repeated ones.

    `strokes` holds each stroke with its points after the plan was turned and moved [m]; `names` gives the name of each room
    in the drawing, by the room's id. Raises `SpecError` for a stroke that fits no wall or overlaps another one.
    """
    openings: dict[int, dict[OpeningSpec, str]] = {}
    notes = []
    for stroke, points in strokes:
        if stroke.storey >= len(storeys):
            raise SpecError(f"{stroke.where}: is on storey {stroke.storey}, which has no rooms")
        opening = opening_on_wall(stroke, points, storeys[stroke.storey], names)
        here = openings.setdefault(stroke.storey, {})
        if opening is None:
            notes.append(f"{stroke.where}: leads out of the house; ignored")
        elif (known := next((each for each in here if is_drawn_again(each, opening)), None)) is not None:
            notes.append(f"{stroke.where}: is the same opening as {here[known]}; ignored")
        else:
            here[opening] = stroke.where
    return {level: without_overlaps(placed) for level, placed in openings.items()}, notes


def _storeys(drawing: DrawnPlan, rooms: Sequence[RoomSpec]) -> list[StoreySpec]:
    heights, storeys = dict(drawing.heights_m), []
    count = 1 + max(room.storey for room in drawing.rooms)
    if surplus := [level for level in heights if level >= count]:
        raise SpecError(
            f"storey_heights_m[{surplus[0]}] is given, but storey {surplus[0]} has no rooms; valid: at most {count} heights"
        )
    for level in range(count):
        here = tuple(room for room, drawn in zip(rooms, drawing.rooms, strict=True) if drawn.storey == level)
        if not here:
            above = min(drawn.storey for drawn in drawing.rooms if drawn.storey > level)
            raise SpecError(
                f"storey {level} has no rooms, but storey {above} has; valid: storeys numbered from 0 without a gap"
            )
        height_m = heights.get(level, 2.6)
        storeys.append(validated(f"storey_heights_m[{level}]", StoreySpec, rooms=here, height_m=height_m))
    return storeys


def _ids(rooms: Sequence[DrawnRoom]) -> list[str]:
    """Return a unique id for each room, as similar to its drawn name as the format of ids allows."""
    ids: list[str] = []
    for room in rooms:
        plain = unicodedata.normalize("NFKD", room.name).encode("ascii", "ignore").decode()  # "Büro" becomes "Buro"
        plain = re.sub(r"^[^A-Za-z0-9]+", "", re.sub(r"[^A-Za-z0-9 _.'-]+", " ", plain)).strip()[:56] or room.label
        number = 2
        identifier = plain
        while identifier in ids:
            identifier, number = f"{plain} {number}", number + 1
        ids.append(identifier)
    return ids


def _shift(corners: Sequence[Point]) -> Point:
    """Return the translation that moves a plan to the origin if it is far away, as in map coordinates; else (0, 0) [m]."""
    x, y = zip(*corners, strict=True)
    near = max(map(abs, (*x, *y))) <= _FAR_M
    return (0.0, 0.0) if near else (-float(math.floor(min(x))), -float(math.floor(min(y))))


def _moved(points: Sequence[Point], shift: Point) -> tuple[Point, ...]:
    return tuple((x + shift[0], y + shift[1]) for x, y in points)


__all__ = ["ImportedPlan", "import_plan", "to_geojson"]
