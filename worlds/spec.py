"""`HouseSpec`: a house as pure data, with a JSON form that is validated at the door.

A spec says only what cannot be derived. `worlds.house.build_house` turns it into exact geometry; the same spec always gives
the same house. Lengths are in metres, angles in radians; x east, y north, z up; the origin is a corner of the plan.
"""

import json
import math
from collections import Counter
from pathlib import Path
from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError, field_validator, model_validator

from worlds.errors import SpecError
from worlds.labels import ROOM_LABELS

MAX_JSON_BYTES = 16_000_000
MAX_ROOMS = 200
MAX_PLAN_M2 = 20_000.0
"""Largest rectangle around all rooms, times the storeys: what is surveyed at 10 cm has to fit in memory."""

Metres = Annotated[float, Field(ge=-1000.0, le=1000.0)]
Length = Annotated[float, Field(gt=0.0, le=1000.0)]
Point = tuple[Metres, Metres]
Identifier = Annotated[str, Field(min_length=1, max_length=64, pattern=r"^[A-Za-z0-9][A-Za-z0-9 _.'-]*$")]
OpeningKind = Literal["door", "cased", "open"]


class _Data(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


class RoomSpec(_Data):
    """A room: its name in the house, its label, and its floor polygon (wall centre lines)."""

    id: Identifier
    label: str = Field(description="one of worlds.labels.ROOM_LABELS")
    polygon_m: tuple[Point, ...] = Field(
        min_length=4, max_length=64, description="rectilinear, counter-clockwise, corners in [m]"
    )

    @field_validator("label")
    @classmethod
    def _known_label(cls, label: str) -> str:
        if label not in ROOM_LABELS:
            raise ValueError(f"unknown label {label!r}; valid: {', '.join(ROOM_LABELS)}")
        return label

    @field_validator("polygon_m")
    @classmethod
    def _rectilinear(cls, polygon: tuple[Point, ...]) -> tuple[Point, ...]:
        for (x0, y0), (x1, y1) in zip(polygon, polygon[1:] + polygon[:1], strict=True):
            if (x0 == x1) == (y0 == y1):
                raise ValueError(f"walls must run along x or y, but ({x0}, {y0}) - ({x1}, {y1}) does not")
        return polygon


class OpeningSpec(_Data):
    """A gap in the wall between two rooms of a storey: a door way, a cased opening, or no wall at all."""

    rooms: tuple[Identifier, Identifier]
    kind: OpeningKind = Field(description="door: a door way; cased: a wide gap with a lintel; open: no wall, to the ceiling")
    start_m: Point = Field(description="one end on the shared wall's centre line [m]")
    end_m: Point = Field(description="the other end [m]")
    height_m: Length = Field(default=2.05, description="clear height of a door or cased opening [m]")

    @property
    def width_m(self) -> float:
        """Clear width [m]."""
        return math.dist(self.start_m, self.end_m)


class FurnitureSpec(_Data):
    """One piece of furniture, an instance of a kind in `worlds.furniture`."""

    id: Identifier
    kind: Identifier
    room: Identifier
    position_m: tuple[Metres, Metres, Metres] = Field(
        description="centre of the foot print and height of the underside above the storey's floor [m]"
    )
    yaw_rad: float = Field(ge=-math.pi, le=math.pi, description="0: the front faces +y [rad]")
    size_m: tuple[Length, Length, Length] = Field(description="width, depth, height in the piece's own frame [m]")
    seed: int = Field(ge=0, lt=2**32, description="of its colours and variants")


class StoreySpec(_Data):
    """One storey; storeys stand on each other in the order of the list."""

    height_m: float = Field(default=2.6, gt=2.0, le=6.0, description="floor to ceiling [m]")
    rooms: tuple[RoomSpec, ...] = Field(min_length=1, max_length=MAX_ROOMS)
    openings: tuple[OpeningSpec, ...] = Field(default=(), max_length=4 * MAX_ROOMS)
    furniture: tuple[FurnitureSpec, ...] | None = Field(
        default=None, max_length=4000, description="absent: filled in from the house's seed"
    )


class HouseSpec(_Data):
    """A house. `HouseSpec.from_json` reads one, `to_json` writes it; the two are inverse."""

    schema_version: Literal[1] = Field(default=1, alias="schema")
    name: str = Field(default="house", max_length=200)
    seed: int = Field(default=0, ge=0, lt=2**63, description="of furniture (when absent), textures and colours")
    slab_m: float = Field(default=0.3, ge=0.1, le=1.0, description="thickness of the slab between storeys [m]")
    clutter: float = Field(default=1.0, ge=0.0, le=3.0, description="how much furniture is filled in; 0: none, 1: usual")
    storeys: tuple[StoreySpec, ...] = Field(min_length=1, max_length=8)

    @model_validator(mode="after")
    def _names_resolve(self) -> "HouseSpec":
        _check_unique("room", [room.id for storey in self.storeys for room in storey.rooms])
        _check_unique("furniture", [piece.id for storey in self.storeys for piece in storey.furniture or ()])
        for level, storey in enumerate(self.storeys):
            known = {room.id for room in storey.rooms}
            named = [i for opening in storey.openings for i in opening.rooms] + [f.room for f in storey.furniture or ()]
            for missing in sorted(set(named) - known):
                raise ValueError(f"storeys[{level}] names room {missing!r}; its rooms are {', '.join(sorted(known))}")
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
        """The labels in the house, each once, in the catalogue's order: the prompt list for LEXIS."""
        present = {room.label for storey in self.storeys for room in storey.rooms}
        return tuple(label for label in ROOM_LABELS if label in present)

    def to_json(self) -> str:
        """The spec as JSON, one stable text per spec."""
        return json.dumps(self.model_dump(mode="json", by_alias=True), indent=1) + "\n"

    @classmethod
    def from_json(cls, text: str, source: str = "house") -> "HouseSpec":
        """Read a spec; `source` is named in errors. Raises `SpecError`."""
        try:
            return cls.model_validate_json(text, strict=True)
        except ValidationError as error:
            raise SpecError(f"{source}: {_first_problem(error)}") from None

    @classmethod
    def load(cls, path: Path | str) -> "HouseSpec":
        """Read a spec from a file of at most 16 MB. Raises `SpecError`."""
        path = Path(path)
        try:
            with path.open("rb") as file:
                data = file.read(MAX_JSON_BYTES + 1)
        except OSError as error:
            raise SpecError(f"{path}: cannot be read: {error.strerror}; valid: a house as JSON") from None
        if len(data) > MAX_JSON_BYTES:
            raise SpecError(f"{path}: larger than {MAX_JSON_BYTES // 1_000_000} MB; valid: a house as JSON")
        try:
            return cls.from_json(data.decode("utf-8-sig"), source=str(path))
        except UnicodeDecodeError:
            raise SpecError(f"{path}: is not text in UTF-8; valid: a house as JSON") from None


def _check_unique(what: str, ids: list[str]) -> None:
    repeated = sorted(i for i, times in Counter(ids).items() if times > 1)
    if repeated:
        raise ValueError(f"{what} ids must be unique in the house; repeated: {', '.join(repeated)}")


def _first_problem(error: ValidationError) -> str:
    problems = error.errors(include_url=False)
    first = problems[0]
    place = "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in first["loc"]).lstrip(".")
    more = f" (and {len(problems) - 1} more)" if len(problems) > 1 else ""
    return f"{place or 'spec'}: {first['msg'].removeprefix('Value error, ')}{more}"


__all__ = ["FurnitureSpec", "HouseSpec", "OpeningSpec", "RoomSpec", "StoreySpec"]
