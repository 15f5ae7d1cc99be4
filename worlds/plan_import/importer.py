"""`import_plan`: a floor plan drawn elsewhere (GeoJSON or SVG) becomes a house, and the house is proved to stand.

Drawings are imprecise. The whole plan is turned so that its walls run along x and y; corners that are a little off move to
common lines; openings move to the nearest wall between two rooms. What cannot be meant is refused with its place. For the
formats see `worlds.plan_import.geojson` and `worlds.plan_import.svg`.
"""

import math
import re
import unicodedata
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path

from worlds.errors import SpecError, WorldsError, reworded
from worlds.plan_import.added_openings import made_up
from worlds.plan_import.drawn_openings import apart, on_walls
from worlds.plan_import.drawn_plan import DrawnPlan, DrawnRoom, Stroke, built
from worlds.plan_import.geojson import read_geojson, to_geojson
from worlds.plan_import.straighten import main_direction, straighten, turned
from worlds.reading import read_text
from worlds.spec import HouseSpec, OpeningSpec, Point, RoomSpec, StoreySpec
from worlds.valid_names import listed
from worlds.validation import built_and_checked

_SLAB_M = 0.3
_FAR_M = 900.0
_WIDER_M = (0.1, 0.15, 0.2, 0.25, 0.3)
"""Values of `snap_m` that are tried to find out what would mend a plan."""
_EXACT_M = 0.001
"""A plan that stands with corners moved by no more is left as it is drawn."""


@dataclass(frozen=True)
class ImportedPlan:
    """A house, and what was done to the drawing to get it."""

    spec: HouseSpec
    notes: tuple[str, ...]
    """One line each, for people."""


def import_plan(
    path: Path | str,
    *,
    metres_per_unit: float | None = None,
    snap_m: float = 0.05,
    only_drawn: bool = False,
    name: str | None = None,
    seed: int = 0,
) -> ImportedPlan:
    """The house in a floor plan; windows and furniture are filled in by `build_house`.

    Rooms that the drawn openings do not reach get doors, and stairs without an opening get a way up and a way down.

    Args:
        path: a file that ends in .svg, .geojson or .json, of at most 16 MB.
        metres_per_unit: scale of the drawing; None: of GeoJSON 1, of SVG what its root says.
        snap_m: where the plan does not stand as drawn, corners so near to each other lie on one line [m]; as wide as walls
            are drawn, if rooms have gaps between.
        only_drawn: no openings but the drawn ones.
        name: of the house; None: the file's.
        seed: of the house.

    Raises:
        WorldsError: where the plan cannot be read or is no house: the message names the file and the room or opening.
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
        spec, notes = _standing(_Plan(drawing, (name or path.stem)[:200], seed, only_drawn), snap_m)
    except WorldsError as error:
        raise reworded(error, f"{path}: {error}{doubt}") from None
    return ImportedPlan(spec, (*drawing.notes, *notes))


@dataclass(frozen=True)
class _Plan:
    """A drawing, and what is asked for besides."""

    drawing: DrawnPlan
    name: str
    seed: int
    only_drawn: bool


def _standing(plan: _Plan, snap_m: float) -> tuple[HouseSpec, list[str]]:
    """The house and notes, as drawn or else with corners moved by `snap_m`.

    Raises `WorldsError` where it stands neither way; the message names the `snap_m` with which it would, if there is one.
    """
    with suppress(WorldsError):
        return _proved(plan, _EXACT_M)
    try:
        spec, notes = _proved(plan, snap_m)
    except WorldsError as error:
        raise reworded(error, f"{error}{_hint(plan, snap_m)}") from None
    return spec, [*notes, f"corners no more than {snap_m:g} m off were moved to common lines"]


def _hint(plan: _Plan, snap_m: float) -> str:
    """The end of a message: the value that would mend a plan that does not stand."""
    for wider_m in (wider_m for wider_m in _WIDER_M if wider_m > snap_m):
        with suppress(WorldsError):
            _proved(plan, wider_m)
            return f"; the plan stands with --snap {wider_m:g} (in Python snap_m={wider_m:g})"
    if plan.only_drawn:
        with suppress(WorldsError):
            _standing(replace(plan, only_drawn=False), snap_m)
            return "; the plan stands without --only-drawn (in Python only_drawn=False)"
    return ""


def _proved(plan: _Plan, snap_m: float) -> tuple[HouseSpec, list[str]]:
    """The house and notes. Raises `WorldsError` where the house does not stand."""
    spec, notes = _house(plan, snap_m)
    built_and_checked(spec)
    return spec, notes


def _read(path: Path, metres_per_unit: float | None) -> DrawnPlan:
    match path.suffix.lower():
        case ".svg":
            from worlds.plan_import.svg import read_svg  # its library takes a second to import

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
        built(room.where, RoomSpec, id=identifier, label=room.label, polygon_m=polygon)
        for identifier, room, polygon in zip(ids, drawing.rooms, polygons, strict=True)
    ]
    storeys = _storeys(drawing, rooms)
    by_name = {room.name or identifier: identifier for room, identifier in zip(drawing.rooms, ids, strict=True)}
    drawn = _drawn_openings(drawing.strokes, storeys, by_name, angle, shift, notes)
    storeys = [s.model_copy(update={"openings": drawn.get(level, ())}) for level, s in enumerate(storeys)]
    if not plan.only_drawn:
        storeys = _completed(storeys, notes)
    fields = {"name": plan.name, "seed": plan.seed, "slab_m": _SLAB_M, "storeys": tuple(storeys)}
    return built("the house", HouseSpec, **fields), notes


def _completed(storeys: Sequence[StoreySpec], notes: list[str]) -> list[StoreySpec]:
    """The storeys with openings made up for what the drawn ones do not reach."""
    added = made_up(storeys, _SLAB_M)
    told = [f"{opening.rooms[0]} - {opening.rooms[1]} ({opening.kind})" for openings in added for opening in openings]
    if told:
        drawn = "the drawn openings do not reach every room" if any(s.openings for s in storeys) else "no openings are drawn"
        notes.append(f"{drawn}; made up, so that every room can be reached: {listed(told)}")
    return [s.model_copy(update={"openings": (*s.openings, *more)}) for s, more in zip(storeys, added, strict=True)]


def _drawn_openings(
    strokes: Sequence[Stroke],
    storeys: Sequence[StoreySpec],
    ids: dict[str, str],
    angle: float,
    shift: Point,
    notes: list[str],
) -> dict[int, tuple[OpeningSpec, ...]]:
    openings: dict[int, tuple[OpeningSpec, ...]] = {}
    for stroke in strokes:
        if stroke.storey >= len(storeys):
            raise SpecError(f"{stroke.where}: is on storey {stroke.storey}, which has no rooms")
        opening = on_walls(stroke, _moved(turned(stroke.points, angle), shift), storeys[stroke.storey], ids)
        if opening is None:
            notes.append(f"{stroke.where}: leads out of the house; left out")
        else:
            openings[stroke.storey] = (*openings.get(stroke.storey, ()), opening)
    return {level: apart(placed) for level, placed in openings.items()}


def _storeys(drawing: DrawnPlan, rooms: Sequence[RoomSpec]) -> list[StoreySpec]:
    heights, storeys = dict(drawing.heights_m), []
    for level in range(1 + max(room.storey for room in drawing.rooms)):
        here = tuple(room for room, drawn in zip(rooms, drawing.rooms, strict=True) if drawn.storey == level)
        if not here:
            raise SpecError(f"has no rooms on storey {level}, but on one above; storeys are numbered from 0 without a gap")
        storeys.append(built(f"storey {level}", StoreySpec, rooms=here, height_m=heights.get(level, 2.6)))
    return storeys


def _ids(rooms: Sequence[DrawnRoom]) -> list[str]:
    """A name for each room, as near to the drawn one as the format allows, the only one in the house."""
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
    """Plans in map coordinates move to the origin; others stay where they are."""
    x, y = zip(*corners, strict=True)
    near = max(map(abs, (*x, *y))) <= _FAR_M
    return (0.0, 0.0) if near else (-float(math.floor(min(x))), -float(math.floor(min(y))))


def _moved(points: Sequence[Point], shift: Point) -> tuple[Point, ...]:
    return tuple((x + shift[0], y + shift[1]) for x, y in points)


__all__ = ["ImportedPlan", "import_plan", "to_geojson"]
