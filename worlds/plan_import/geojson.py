"""Reads and writes floor plans as GeoJSON in metres.

Rooms are Polygons, or MultiPolygons of a single polygon, with a `label`. Openings are LineStrings (both ends) or Points (the
middle) with a `kind`.

    {"type": "FeatureCollection", "features": [
      {"type": "Feature", "properties": {"label": "kitchen", "name": "my kitchen", "storey": 0},
       "geometry": {"type": "Polygon", "coordinates": [[[0, 0], [4, 0], [4, 3], [0, 3], [0, 0]]]}},
      {"type": "Feature", "properties": {"kind": "door"},
       "geometry": {"type": "LineString", "coordinates": [[4, 1], [4, 1.9]]}}]}

An opening can also have the fields `height_m`, `sill_m`, `leaf` and `leads` of `OpeningSpec`. A room of stairs can also have
the field `climb` of `RoomSpec`. Beside `features`, a list `storey_heights_m` gives the heights of the storeys, and a number
`slab_m` gives the thickness of the slabs between them. A feature without `storey` is on the ground floor. Features with
neither `label` nor `kind` are ignored, and so are all other properties. A field that is `null` counts as absent, because
many programs write every property on every feature.
"""

import json
from collections.abc import Sequence
from typing import Any

from worlds.errors import SpecError
from worlds.plan_import.drawn_plan import (
    MAX_LISTED,
    DrawnPlan,
    DrawnRoom,
    Stroke,
    checked,
    label_of,
    opening_kind_of,
    spelling_notes,
    storey_number,
)
from worlds.spec import HouseSpec, OpeningSpec, Point
from worlds.spec_errors import fields_once
from worlds.valid_names import listed

_DETAILS = ("height_m", "sill_m", "leaf", "leads")
_FARTHEST_M = 1e8
_BESIDE_FEATURES = ("storey_heights_m", "slab_m")
_PROPERTIES = ("label", "name", "storey", "kind", "climb", *_DETAILS)


def read_geojson(text: str, metres_per_unit: float) -> DrawnPlan:
    """Read a plan from GeoJSON. Raises `SpecError` if `text` is no FeatureCollection, or if a feature is invalid."""
    try:
        return _drawing(json.loads(text, object_pairs_hook=fields_once), metres_per_unit)
    except RecursionError:  # raised by the JSON reader, or by a message that shows a deeply nested value
        raise SpecError("is nested too deeply; valid: GeoJSON") from None
    except SpecError:
        raise
    except ValueError as error:
        raise SpecError(f"is not GeoJSON: {str(error)[:80]}") from None


def _drawing(data: object, metres_per_unit: float) -> DrawnPlan:
    if not isinstance(data, dict) or not isinstance(data.get("features"), list):
        raise SpecError('is not GeoJSON; valid: a "FeatureCollection" with "features"')
    beside = _present(data)
    rooms: list[DrawnRoom] = []
    strokes: list[Stroke] = []
    spoken: list[tuple[str, str]] = []
    ignored: list[str] = []
    for i, feature in enumerate(data["features"]):
        properties, geometry = _parts(feature)
        where = f"features[{i}]" + (f" ({name[:60]!r})" if (name := _name(properties.get("name"))) else "")
        spoken += [(where, key) for key in properties if key not in _PROPERTIES]
        storey = storey_number(where, properties.get("storey", 0))
        if "label" in properties:
            corners = _ring(where, geometry, metres_per_unit)
            label, climb = label_of(where, str(properties["label"])), properties.get("climb", "flights")
            rooms.append(DrawnRoom(where, name, label, storey, corners, climb))
        elif "kind" in properties:
            details = tuple((key, properties[key]) for key in _DETAILS if key in properties)
            points = _ends(where, geometry, metres_per_unit)
            strokes.append(Stroke(where, opening_kind_of(where, str(properties["kind"])), storey, points, details))
        else:
            ignored.append(where)
    if rooms and _in_degrees(rooms):
        raise SpecError(
            "seems to have coordinates in degrees: the whole plan is smaller than 0.5 m; valid: x and y in metres"
        )
    unknown = [("the FeatureCollection", key) for key in beside if key not in _BESIDE_FEATURES]
    notes = [*spelling_notes(unknown, _BESIDE_FEATURES), *spelling_notes(spoken, _PROPERTIES)]
    if ignored:
        places = listed(ignored, MAX_LISTED, separator="; ")
        notes.append(f"ignored, because they have neither a label nor a kind: {places}")
    return checked(rooms, strokes, heights_m=_heights(beside), slab_m=beside.get("slab_m"), notes=tuple(notes))


def _in_degrees(rooms: Sequence[DrawnRoom]) -> bool:
    """Return whether corners look like longitudes and latitudes [deg] instead of metres.

    This is so if no coordinate exceeds 180 and the whole plan extends over less than 0.5 units.
    """
    x, y = zip(*(corner for room in rooms for corner in room.corners), strict=True)
    is_small = max(x) - min(x) < 0.5 and max(y) - min(y) < 0.5
    return is_small and all(abs(degrees) <= 180.0 for degrees in (*x, *y))


def to_geojson(spec: HouseSpec) -> str:
    """Return the rooms and openings of a house as GeoJSON in metres.

    To read it back, call `read_geojson` with 1 metre per unit.
    """
    features = []
    for level, storey in enumerate(spec.storeys):
        for room in storey.rooms:
            ring = [*room.polygon_m, room.polygon_m[0]]
            climb = room.model_dump(include={"climb"}, exclude_defaults=True)
            properties = {"name": room.id, "label": room.label, "storey": level, **climb}
            features.append(_feature(properties, {"type": "Polygon", "coordinates": [ring]}))
        for opening in storey.openings:
            line = {"type": "LineString", "coordinates": [opening.start_m, opening.end_m]}
            features.append(_feature({**_properties(opening), "storey": level}, line))
    heights = {"storey_heights_m": [storey.height_m for storey in spec.storeys], "slab_m": spec.slab_m}
    return json.dumps({"type": "FeatureCollection", **heights, "features": features}, indent=1) + "\n"


def _properties(opening: OpeningSpec) -> dict[str, Any]:
    return opening.model_dump(mode="json", include={"kind", *_DETAILS}, exclude_defaults=True)


def _feature(properties: dict[str, Any], geometry: dict[str, Any]) -> dict[str, Any]:
    return {"type": "Feature", "properties": properties, "geometry": geometry}


def _parts(feature: object) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return the properties of a feature that are not null, and its geometry."""
    if not isinstance(feature, dict):
        return {}, {}
    parts = feature.get("properties"), feature.get("geometry")
    properties, geometry = (part if isinstance(part, dict) else {} for part in parts)
    return _present(properties), geometry


def _present(fields: dict[str, Any]) -> dict[str, Any]:
    """Return the fields of an object that are not null."""
    return {key: value for key, value in fields.items() if value is not None}


def _shown(value: object) -> str:
    """Return a value as JSON for a message; a long text is cut."""
    return json.dumps(value)[:40]


def _name(value: object) -> str:
    """Return a name as text; many plans number their rooms. The name is empty if `value` is neither text nor a number."""
    return str(value) if isinstance(value, str | int | float) and not isinstance(value, bool) else ""


def _heights(beside: dict[str, Any]) -> tuple[tuple[int, object], ...]:
    heights = beside.get("storey_heights_m", [])
    if not isinstance(heights, list):
        raise SpecError(f"storey_heights_m is {_shown(heights)}; valid: a list with the height of every storey [m]")
    return tuple((level, height) for level, height in enumerate(heights) if height is not None)


def _ring(where: str, geometry: dict[str, Any], scale: float) -> tuple[Point, ...]:
    kind, rings = geometry.get("type"), geometry.get("coordinates")
    if kind == "MultiPolygon" and isinstance(rings, list):
        if len(rings) != 1:
            raise SpecError(f"{where}: a room has a MultiPolygon of {len(rings)} polygons; valid: one polygon for each room")
        kind, rings = "Polygon", rings[0]
    if kind != "Polygon" or not isinstance(rings, list) or not rings:
        raise SpecError(f"{where}: a room has a geometry of type {_shown(geometry.get('type'))}; valid: Polygon")
    if len(rings) > 1:
        raise SpecError(f"{where}: a room has a hole; valid: an outline without holes (split the room)")
    points = _points(where, rings[0], scale)
    return points[:-1] if len(points) > 1 and points[0] == points[-1] else points


def _ends(where: str, geometry: dict[str, Any], scale: float) -> tuple[Point, ...]:
    match geometry.get("type"):
        case "Point":
            return _points(where, [geometry.get("coordinates")], scale)
        case "LineString":
            points = _points(where, geometry.get("coordinates"), scale)
            return points[0], points[-1]
    raise SpecError(f"{where}: an opening has a geometry of type {_shown(geometry.get('type'))}; valid: LineString, Point")


def _points(where: str, data: object, scale: float) -> tuple[Point, ...]:
    if not isinstance(data, list) or not 1 <= len(data) <= 1000:
        raise SpecError(f"{where}: has no list of 1 to 1000 coordinates")
    points = []
    for point in data:
        numbers = point[:2] if isinstance(point, list) else []
        if len(numbers) < 2 or not all(isinstance(n, int | float) and not isinstance(n, bool) for n in numbers):
            raise SpecError(f"{where}: {str(point)[:40]} is not a pair of coordinates")
        # Compared before the conversion to float, which fails for the huge integers that JSON and Python allow.
        if not all(abs(n) <= _FARTHEST_M and abs(n) * scale <= _FARTHEST_M for n in numbers):
            raise SpecError(f"{where}: {str(point)[:40]} is not a place on Earth in metres")
        points.append((float(numbers[0]) * scale, float(numbers[1]) * scale))
    return tuple(points)
