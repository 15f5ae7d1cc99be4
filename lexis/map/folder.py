"""A map as a folder: `map.json` with camera, encoder and rooms, and `arrays.npz` with all arrays. Nothing is unpickled."""

import hashlib
import json
import os
from contextlib import suppress
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from pydantic import BaseModel, Field

from lexis.errors import MapError
from lexis.files.arrays import Arrays, read_arrays
from lexis.files.camera import CameraData
from lexis.files.models import STRICT, EncoderData, RoomName, RoomNames
from lexis.files.reading import FileKind, open_file, read_model
from lexis.files.replace import replaced_folder
from lexis.files.temporary_folder import recover
from lexis.inputs import MAX_CAMERAS, check_camera, check_room_names
from lexis.map.arrays import LAYOUT, check, pack, unpack_candidates, unpack_decisions, unpack_keyframes, unpack_loops
from lexis.map.other_views import LAYOUT as OF_OTHERS
from lexis.types import EncoderId, LexisMap, RoomInstance

JSON_FILE = "map.json"
ARRAY_FILE = "arrays.npz"
_WRITTEN = "a folder written by 'lexis run'"
_HEADER_FILE = FileKind(_WRITTEN, 16_000_000, MapError, missing="no map there", unusable="no map")
_ARRAYS_FILE = FileKind(_WRITTEN, 8_000_000_000, MapError, missing="no arrays of a map there", unusable="no arrays of a map")


class _Room(BaseModel):
    model_config = STRICT

    label: RoomName
    floor: Annotated[int, Field(ge=0, lt=1_000_000)] | None


class _Map(BaseModel):
    model_config = STRICT

    schema_version: Literal[7] = Field(alias="schema")
    arrays_sha256: Annotated[str, Field(max_length=64)]
    """Digest of `arrays.npz`, which tells whether both files belong together."""
    camera: CameraData
    other_cameras: tuple[CameraData, ...] = Field((), max_length=MAX_CAMERAS - 1)
    """The further cameras of a rig. Files of a single camera do not state them."""
    encoder: EncoderData
    room_names: RoomNames
    rooms: tuple[_Room, ...] = Field(max_length=100_000)
    stage_seconds: dict[str, float] = Field(max_length=100)


def save_map(map: LexisMap, directory: Path | str, features: bool = True) -> None:
    """Write the map to a folder, which appears complete or not at all; an earlier map there is replaced.

    Without `features`, key points and landmarks are left out. The map is then smaller, but a later run cannot close loops
    with it. Raises LexisError if the folder cannot be written, or holds something that is no map.
    """
    with replaced_folder(Path(directory), JSON_FILE) as folder:
        np.savez(folder / ARRAY_FILE, allow_pickle=False, **pack(map, features))
        header = _header(map, _digest(folder / ARRAY_FILE))
        excluded = None if map.camera.others else {"other_cameras"}
        text = json.dumps(header.model_dump(mode="json", by_alias=True, exclude=excluded), indent=1)
        (folder / JSON_FILE).write_text(text + "\n", encoding="utf-8")


def _header(map: LexisMap, arrays_sha256: str) -> _Map:
    return _Map(
        schema=7,
        arrays_sha256=arrays_sha256,
        camera=CameraData.of(map.camera),
        other_cameras=tuple(CameraData.of(other) for other in map.camera.others),
        encoder=EncoderData(name=map.encoder.name, fingerprint=map.encoder.fingerprint),
        room_names=map.room_names,
        rooms=tuple(_Room(label=room.label, floor=room.floor) for room in map.rooms),
        stage_seconds=map.stage_seconds,
    )


def _digest(path: Path) -> str:
    with open_file(path, _ARRAYS_FILE) as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def load_map(directory: Path | str) -> LexisMap:
    """Read a map that was written by `save_map`. Raises MapError for anything else, such as files of two maps."""
    directory = Path(directory)
    recover(directory)
    # A run that saves its map every few keyframes may have replaced the map after the first of its two files was read.
    with suppress(MapError):
        return _read_map(directory)
    return _read_map(directory)


def _check_files(directory: Path) -> None:
    """Raise MapError if one of the two files is missing, or if the folder holds the map in a folder of its own."""
    has_header, has_arrays = (os.path.lexists(directory / name) for name in (JSON_FILE, ARRAY_FILE))
    if has_header != has_arrays:
        missing = ARRAY_FILE if has_header else JSON_FILE
        raise MapError(f"{directory}: the map is incomplete: {missing} is missing; valid: both files as they were written")
    if not has_header and os.path.isfile(directory / "map" / JSON_FILE):
        raise MapError(f"{directory}: no map there; valid: {directory / 'map'}, which holds one")


def _read_map(directory: Path) -> LexisMap:
    _check_files(directory)
    header = read_model(directory / JSON_FILE, _HEADER_FILE, _Map)
    others = header.other_cameras
    sizes = {"rooms": len(header.rooms), "room_names": len(header.room_names), "others": len(others)}
    arrays = read_arrays(directory / ARRAY_FILE, _ARRAYS_FILE, {**LAYOUT, **OF_OTHERS} if others else LAYOUT, sizes)
    camera = header.camera.camera(others)
    try:
        check_camera(camera)
        check_room_names(header.room_names)
        check(arrays)
    except ValueError as error:
        raise MapError(f"{directory}: {error}") from None
    rooms = _rooms(directory, header, arrays)
    if _digest(directory / ARRAY_FILE) != header.arrays_sha256:
        mixed = f"{JSON_FILE} belongs to another {ARRAY_FILE}, or one of them was changed"
        raise MapError(f"{directory}: {mixed}; valid: both files as they were written together")
    return LexisMap(
        camera=camera,
        encoder=EncoderId(header.encoder.name, header.encoder.fingerprint),
        room_names=header.room_names,
        keyframes=unpack_keyframes(arrays),
        T_W_B=arrays["T_W_B"],
        similarities=arrays["similarities"],
        baseline_labels=arrays["baseline_labels"],
        labels=arrays["labels"],
        probabilities=arrays["probabilities"],
        floors=arrays["floors"],
        rooms=rooms,
        loops=unpack_loops(arrays),
        loop_weights=arrays["loop_weight"],
        candidates=unpack_candidates(arrays),
        decisions=unpack_decisions(arrays),
        stage_seconds=header.stage_seconds,
    )


def _rooms(directory: Path, header: _Map, arrays: Arrays) -> tuple[RoomInstance, ...]:
    rooms = []
    for i, room in enumerate(header.rooms):
        members = np.flatnonzero(arrays["room_of"] == i)
        if not len(members) or room.label not in header.room_names:
            raise MapError(f"{directory}: rooms[{i}] has no keyframe, or a label that is not among room_names")
        rooms.append(RoomInstance(i, room.label, tuple(members.tolist()), arrays["room_mean"][i], room.floor))
    return tuple(rooms)
