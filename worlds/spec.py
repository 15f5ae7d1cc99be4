"""`HouseSpec`: a house as pure data, with a JSON form that is validated when it is read.

A spec leaves out everything that can be computed from the rest. `worlds.house.build_house` turns a spec into exact geometry;
the same spec always gives the same house. Lengths are in metres, angles in radians; x points east, y north, z up. The origin
may be any point of the plan.
"""

import json
import math
import re
from collections import Counter
from collections.abc import Iterator
from functools import cache
from itertools import islice
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, ValidationError, field_validator, model_validator

from worlds.errors import SpecError
from worlds.labels import ROOM_LABELS
from worlds.reading import read_text
from worlds.spec_errors import MAX_MISTAKES, explain, mistakes_error, read_json
from worlds.valid_names import did_you_mean, listed

MAX_ROOMS = 200
MIN_WALL_M = 0.005
"""Least length of a side of a room's polygon [m]."""
MAX_PLAN_M2 = 20_000.0
"""Greatest product of the number of storeys and the area of the rectangle around all rooms [m²]. Within this limit, a grid
of 10 cm fits in memory."""

_SHORT = re.compile(r""""(?:[^"\\]|\\.)*" | \[\s+(?: [-+.\deE,\s[\]]+ | (?: "[^"\n]*" ,? \s+ )+ )\]""", re.VERBOSE)
"""Matches the arrays of numbers, points or strings in indented JSON, which are written on one line instead. Also matches
the strings outside of these arrays, so that nothing inside a string is taken for an array."""

Metres = Annotated[
    float, Field(ge=-1000.0, le=1000.0, description="coordinate [m]"), AfterValidator(lambda value: value + 0.0)
]
"""A coordinate. Minus zero becomes zero, so that equal specs have equal texts."""
Length = Annotated[float, Field(gt=0.0, le=1000.0, description="length [m]")]
Point = tuple[Metres, Metres]
MAX_ID_LENGTH = 64
"""Largest number of characters of an identifier."""
ID_PATTERN = r"[A-Za-z0-9][A-Za-z0-9 _.'-]*"
"""Regular expression of an identifier."""
Identifier = Annotated[str, Field(min_length=1, max_length=MAX_ID_LENGTH, pattern=f"^{ID_PATTERN}$")]
MAX_STOREYS = 8
"""Largest number of storeys of a house."""
Seed = Annotated[int, Field(ge=0, lt=2**63, description="a seed")]
Leads = Literal["up", "down"]
"""Direction of the flight to which an opening to stairs leads."""
OpeningKind = Literal["door", "cased", "arch", "half wall", "counter", "open"]
Climb = Literal["flights", "spiral", "lift"]
TextureName = Literal["rich", "poor", "repeating"]
LightName = Literal["day", "evening", "dim"]
PASSABLE: tuple[OpeningKind, ...] = ("door", "cased", "arch", "open")
"""Kinds of openings that a person can walk through; a half wall or a counter can only be looked over."""


class _MistakesError(ValueError):
    """Several mistakes that one validator found; each is an argument of the exception."""

    def __str__(self) -> str:
        return "; ".join(self.args)


class _Data(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


class RoomSpec(_Data):
    """A room: its id, its label, and its floor polygon, which runs along the centre lines of the walls."""

    id: Identifier
    label: str = Field(description="what the room is used for", json_schema_extra={"enum": list(ROOM_LABELS)})
    polygon_m: tuple[Point, ...] = Field(
        min_length=4, max_length=64, description="corners of the room, counter-clockwise; every wall runs along x or y [m]"
    )
    seed: Seed | None = Field(
        default=None,
        description="seed of the room's furniture and finishes, the same for twin rooms; absent: from the house's seed",
    )
    climb: Climb = Field(
        default="flights",
        description="for stairs: flights of steps, a spiral, or a lift; spirals and lifts have one opening on every storey",
    )

    @field_validator("label")
    @classmethod
    def _known_label(cls, label: str) -> str:
        if label not in ROOM_LABELS:
            known = ", ".join(ROOM_LABELS)
            raise ValueError(f"unknown label {label[:64]!r}{did_you_mean(label[:64], ROOM_LABELS)}; valid: {known}")
        return label

    @field_validator("polygon_m")
    @classmethod
    def _rectilinear(cls, polygon: tuple[Point, ...]) -> tuple[Point, ...]:
        for (x0, y0), (x1, y1) in zip(polygon, polygon[1:] + polygon[:1], strict=True):
            if (x0 == x1) == (y0 == y1):
                raise ValueError(f"walls must run along x or y, but ({x0}, {y0}) - ({x1}, {y1}) does not")
            if abs(x1 - x0) + abs(y1 - y0) < MIN_WALL_M:
                raise ValueError(f"walls are at least {MIN_WALL_M} m long, but ({x0}, {y0}) - ({x1}, {y1}) is not")
        return polygon


class LeafSpec(_Data):
    """The leaf of a door."""

    hinge: Literal["start", "end"] = Field(default="start", description="the end of the opening at which the leaf hangs")
    into: Identifier = Field(description="id of the room that the leaf swings into, one of the opening's two")
    angle_rad: float = Field(default=math.pi / 2, ge=0.0, le=2.0, description="0: closed; pi/2: at a right angle [rad]")


class OpeningSpec(_Data):
    """A gap in the wall between two rooms of a storey."""

    rooms: tuple[Identifier, Identifier]
    kind: OpeningKind = Field(
        description="door: a doorway; cased: a gap with a lintel; arch: a gap with a round top; half wall: a wall up to the "
        "sill; counter: a hatch between sill and height; open: no wall, floor to ceiling"
    )
    start_m: Point = Field(description="one end on the shared wall's centre line [m]")
    end_m: Point = Field(description="the other end [m]")
    height_m: Length = Field(
        default=2.05,
        description="upper end of the gap above the floor [m]; for an arch, its crown; unused for half wall and open",
    )
    sill_m: Length = Field(
        default=1.0, description="lower end of the gap above the floor [m]; used for half wall and counter only"
    )
    leaf: LeafSpec | None = Field(default=None, description="leaf of a door; absent: a doorway without one")
    leads: Leads | None = Field(
        default=None, description="for an opening to stairs: whether it leads to the flight up from this storey or down"
    )

    @model_validator(mode="after")
    def _leaf_of_a_door(self) -> "OpeningSpec":
        if self.leaf is not None and self.kind != "door":
            raise ValueError(f"a leaf belongs to a door, not to {self.kind!r}")
        if self.leaf is not None and self.leaf.into not in self.rooms:
            raise ValueError(f"the leaf swings into {self.leaf.into!r}; valid: {' or '.join(map(repr, self.rooms))}")
        if self.kind == "counter" and self.sill_m >= self.height_m:
            raise ValueError(f"a counter's sill ({self.sill_m} m) is not below its height ({self.height_m} m)")
        return self

    @property
    def width_m(self) -> float:
        """Clear width of the opening [m]."""
        return math.dist(self.start_m, self.end_m)

    @property
    def middle_m(self) -> tuple[float, float]:
        """Middle (x, y) of the opening in W [m]."""
        (xa, ya), (xb, yb) = self.start_m, self.end_m
        return (xa + xb) / 2, (ya + yb) / 2

    def gap_m(self, ceiling_m: float) -> tuple[float, float]:
        """Return the heights above the floor of the gap's lower and upper end; `ceiling_m` is the ceiling's height [m]."""
        match self.kind:
            case "open":
                return 0.0, ceiling_m
            case "half wall":
                return self.sill_m, ceiling_m
            case "counter":
                return self.sill_m, self.height_m
        return 0.0, self.height_m


class WindowSpec(_Data):
    """A window in a wall of an indoor room with no other indoor room behind it."""

    room: Identifier
    start_m: Point = Field(description="one end on the wall's centre line [m]")
    end_m: Point = Field(description="the other end [m]")
    sill_m: Length = Field(default=0.9, description="height of the lower edge above the floor [m]")
    height_m: Length = Field(default=2.1, description="height of the upper edge above the floor [m]")


class FurnitureSpec(_Data):
    """One piece of furniture, an instance of a kind in `worlds.furniture`."""

    id: Identifier
    kind: Identifier
    room: Identifier
    position_m: tuple[Metres, Metres, Metres] = Field(
        description="x and y of the centre, and height of the underside above the storey's floor [m]"
    )
    yaw_rad: float = Field(ge=-math.pi, le=math.pi, description="counter-clockwise about z; 0: the front faces +y [rad]")
    size_m: tuple[Length, Length, Length] = Field(description="width, depth, height in the piece's own frame [m]")
    seed: int = Field(ge=0, lt=2**32, description="seed of the piece's colours and variants")


class StoreySpec(_Data):
    """One storey; the list of storeys goes from the ground up."""

    height_m: float = Field(default=2.6, gt=2.0, le=6.0, description="height of the ceiling above the floor [m]")
    rooms: tuple[RoomSpec, ...] = Field(min_length=1, max_length=MAX_ROOMS)
    openings: tuple[OpeningSpec, ...] = Field(default=(), max_length=4 * MAX_ROOMS)
    windows: tuple[WindowSpec, ...] | None = Field(
        default=None, max_length=4 * MAX_ROOMS, description="absent: filled in from the house's seed"
    )
    furniture: tuple[FurnitureSpec, ...] | None = Field(
        default=None, max_length=4000, description="absent: filled in from the house's seed"
    )


class AppearanceSpec(_Data):
    """The appearance of a house: textures, lighting and colours."""

    texture: TextureName = Field(
        default="rich", description="rich: nothing repeats; poor: few visual features; repeating: periodic walls and floors"
    )
    light: LightName = "day"
    seed: Seed | None = Field(
        default=None,
        description="seed of materials and colours, and of the look of doors and windows; absent: the house's",
    )


CLUTTER_SCALE = "0: none, 1: usual, 4: very cluttered"
"""What values of `HouseSpec.clutter` mean."""


class HouseSpec(_Data):
    """A house. `HouseSpec.from_json` reads a spec and `to_json` writes it without loss."""

    schema_version: Literal[1] = Field(
        default=1, alias="schema", repr=False, description="version of this format, counted from 1"
    )  # not in the repr, because Python expects the alias as the name of the argument
    name: str = Field(default="house", max_length=200)
    seed: Seed = Field(default=0, description="seed of windows and furniture (when absent), textures and colours")
    slab_m: float = Field(default=0.3, ge=0.1, le=1.0, description="thickness of the slab between storeys [m]")
    clutter: float = Field(default=1.0, ge=0.0, le=4.0, description=f"how much furniture is filled in [1]; {CLUTTER_SCALE}")
    appearance: AppearanceSpec = AppearanceSpec()
    storeys: tuple[StoreySpec, ...] = Field(min_length=1, max_length=MAX_STOREYS)

    @model_validator(mode="after")
    def _names_resolve(self) -> "HouseSpec":
        mistakes = [
            *_repeated("room", [room.id for storey in self.storeys for room in storey.rooms]),
            *_repeated("furniture", [piece.id for storey in self.storeys for piece in storey.furniture or ()]),
            *(mistake for level, storey in enumerate(self.storeys) for mistake in _unknown_rooms(level, storey)),
        ]
        if mistakes:
            raise _MistakesError(*mistakes)
        return self

    @model_validator(mode="after")
    def _bounded(self) -> "HouseSpec":
        rooms = [room for storey in self.storeys for room in storey.rooms]
        if len(rooms) > MAX_ROOMS:
            raise ValueError(f"{len(rooms)} rooms; at most {MAX_ROOMS}")
        x, y = zip(*(corner for room in rooms for corner in room.polygon_m), strict=True)
        area = (max(x) - min(x)) * (max(y) - min(y)) * len(self.storeys)
        if area > MAX_PLAN_M2:
            raise ValueError(f"the rectangle around all rooms, times storeys, is {area:.0f} m²; at most {MAX_PLAN_M2:.0f}")
        return self

    @property
    def room_labels(self) -> tuple[str, ...]:
        """The labels that occur in the house, each once, in the order of `ROOM_LABELS`. LEXIS uses them as prompts."""
        present = {room.label for storey in self.storeys for room in storey.rooms}
        return tuple(label for label in ROOM_LABELS if label in present)

    def to_json(self) -> str:
        """Return the spec as JSON; equal specs give equal texts."""
        # Points, polygons and pairs of names are each put on one line, because people read these files too.
        return _SHORT.sub(_on_one_line, json.dumps(self.data(), indent=1)) + "\n"

    def data(self) -> dict[str, Any]:
        """Return the spec as plain data, as `to_json` writes it; fields with their default values are left out."""
        return {"schema": self.schema_version, **self.model_dump(mode="json", by_alias=True, exclude_defaults=True)}

    @classmethod
    def from_json(cls, text: str, source: str = "house") -> "HouseSpec":
        """Read a spec from JSON; error messages begin with `source`.

        Raises `SpecError`: its message names the first malformed field, and its notes name the further malformed fields.
        """
        try:
            data = read_json(text, json_schema())
        except SpecError as error:
            raise SpecError(f"{source}: {error}") from None
        if isinstance(data, dict) and "storeys" not in data and "format" in data:
            what = f"is a file of the format {data['format']!r:.60}, and no house"
            raise SpecError(f"{source}: {what}; valid: a house, as 'lexis-sim house generate' writes it")
        try:
            return cls.model_validate_json(text, strict=True)
        except ValidationError as error:
            raise mistakes_error(source, explain(error, data, json_schema())) from None

    @classmethod
    def load(cls, path: Path | str) -> "HouseSpec":
        """Read a spec from a file of at most 16 MB. Raises `SpecError` for an unreadable or malformed file."""
        try:
            text = read_text(Path(path))
        except SpecError as error:
            raise SpecError(f"{path}: {error}; valid: a house as JSON") from None
        return cls.from_json(text, source=str(path))


def _on_one_line(match: re.Match[str]) -> str:
    if match[0].startswith('"'):
        return match[0]
    return re.sub(r"\s+(?=\])|(?<=\[)\s+", "", re.sub(r"\n\s*", " ", match[0]))


def _room_names(storey: StoreySpec) -> Iterator[tuple[str, int, tuple[str, ...]]]:
    """Yield every item of a storey that refers to rooms, as (name of the list, index in the list, ids of the rooms)."""
    yield from (("openings", i, opening.rooms) for i, opening in enumerate(storey.openings))
    yield from (("windows", i, (window.room,)) for i, window in enumerate(storey.windows or ()))
    yield from (("furniture", i, (piece.room,)) for i, piece in enumerate(storey.furniture or ()))


def _unknown_rooms(level: int, storey: StoreySpec) -> Iterator[str]:
    """Yield a message for each reference to a room that the storey does not have, at most `MAX_MISTAKES` + 1 messages."""
    known = {room.id for room in storey.rooms}
    rooms = sorted(known)
    unknown = ((place, i, missing) for place, i, named in _room_names(storey) for missing in sorted({*named} - known))
    for collection, i, missing in islice(unknown, MAX_MISTAKES + 1):
        yield (
            f"storeys[{level}].{collection}[{i}] names room {missing!r}{did_you_mean(missing, rooms)}; "
            f"its storey's rooms are {listed(rooms)}"
        )


def _repeated(what: str, ids: list[str]) -> Iterator[str]:
    if repeated := sorted(i for i, times in Counter(ids).items() if times > 1):
        yield f"{what} ids must be unique in the house; repeated: {listed(repeated)}"


@cache
def json_schema() -> dict[str, Any]:
    """Return the format of a house as JSON Schema (draft 2020-12). `worlds/house.schema.json` is a copy of this schema."""
    schema = HouseSpec.model_json_schema(by_alias=True)
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **schema}


__all__ = [
    "AppearanceSpec",
    "FurnitureSpec",
    "HouseSpec",
    "LeafSpec",
    "OpeningSpec",
    "RoomSpec",
    "StoreySpec",
    "WindowSpec",
    "json_schema",
]
