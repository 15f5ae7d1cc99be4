"""Arguments and messages that several commands share: room names, settings, encoders, and the summary of a new map."""

import argparse
import os
from pathlib import Path
from typing import TYPE_CHECKING

from lexis.command_line import Parser
from lexis.config import Config, read_config
from lexis.encoder.options import EncoderOptions
from lexis.errors import EncoderError, LexisError, MapError
from lexis.files.reading import FileKind, read_json
from lexis.files.replace import check_outside, check_replaceable
from lexis.graph.components import sessions_apart
from lexis.map.folder import JSON_FILE, load_map, save_map
from lexis.map.info import carried_text, map_info
from lexis.room_names import instance_names, unused_names
from lexis.types import LexisMap

if TYPE_CHECKING:
    from lexis.encoder.open_clip_encoder import OpenClipEncoder

JSON_HELP = "print JSON for scripts instead of text for people"
ROOMS_HELP = 'names of rooms, with commas between them; or a JSON file, of which only its list "labels" is read'
MAP_ENCODER_HELP = "default: the encoder that made the map, under the name or path that it had then"
CALIBRATION_HELP = (
    "calibration of the encoder, as 'lexis-sim calibrate-queries' writes it (default for mini: the included one)"
)
_FAST_M_S = 15.0
"""Mean speed above which a recording is probably in other units [m/s]."""
_ROOMS_FILE = FileKind('names, or a file with a list "labels" of names of rooms', 1_000_000)


def add_settings(parser: Parser, which: str = "") -> None:
    """Add the option that names a file of settings; `which` says in its help text which of the settings are used."""
    help = f"settings as JSON{which} (default: those that 'lexis config' prints)"
    parser.add_argument("--config", type=Path, metavar="FILE", help=help)


def settings(arguments: argparse.Namespace) -> Config:
    """Return the settings of `--config`, or the defaults without this option."""
    return read_config(arguments.config) if arguments.config else Config()


def room_names(text: str) -> tuple[str, ...]:
    """Return the names of `--rooms`: those in a JSON file, or those in the text.

    Raises LexisError for an unusable file, for another file, and for a recording, whose rooms are in a file of its folder.
    """
    if not text.endswith(".json"):
        inside = os.path.join(text, "rooms.json")  # os.path takes texts of any length, unlike pathlib
        if os.path.isfile(inside):
            raise LexisError(f"--rooms {text:.200}: is a folder; valid: {inside:.200}")
        if os.path.isfile(text):
            raise LexisError(f"--rooms {text:.200}: is a file; valid: a file that ends with .json, or names between commas")
        return tuple(name.strip() for name in text.split(","))
    data = read_json(Path(text), _ROOMS_FILE)
    labels = data.get("labels") if isinstance(data, dict) else None
    if not isinstance(labels, list) or not all(isinstance(label, str) for label in labels):
        raise _ROOMS_FILE.refusal(Path(text), 'has no list "labels" of names')
    return tuple(labels)


def encoder_named(model: str, options: EncoderOptions | None = None) -> "OpenClipEncoder":
    """Load an encoder, which takes seconds, because it imports torch. Raises EncoderError for an unknown name."""
    from lexis.encoder.open_clip_encoder import load_encoder

    return load_encoder(model, options)


def map_encoder(lexis_map: LexisMap, asked: str | None) -> "OpenClipEncoder":
    """Load the requested encoder, or the encoder that made the map if none was requested."""
    try:
        return encoder_named(asked or lexis_map.encoder.name)
    except EncoderError as error:
        if asked:
            raise
        raise MapError(
            f"the map was made with encoder {lexis_map.encoder.name!r}, which cannot be loaded: {error}"
        ) from None


def recognisable_map(folder: Path) -> LexisMap:
    """Load a map to which a session can be added. Raises MapError if the map has no key points to recognise places by."""
    lexis_map = load_map(folder)
    if not any(len(keyframe.features.keypoints) for keyframe in lexis_map.keyframes):
        valid = "valid: a map that 'lexis run' made of images and that was not imported since"
        raise MapError(f"{folder}: the map has no key points to recognise places by; {valid}")
    return lexis_map


def check_map_folder(folder: Path, *read: Path) -> None:
    """Raise LexisError unless a map can be written to `folder` without replacing one of the maps that are read."""
    check_replaceable(folder, JSON_FILE)
    for other in read:
        check_outside(folder, other)


def write_map(lexis_map: LexisMap, folder: Path) -> None:
    """Save a map and print its summary. Raises LexisError if the folder cannot be written."""
    save_map(lexis_map, folder)
    print_summary(lexis_map, folder)


def print_summary(lexis_map: LexisMap, folder: Path) -> None:
    """Print a summary of a written map: counts of keyframes and loop edges, rooms, and the map's folder."""
    keyframes, loops = counted(len(lexis_map.keyframes), "keyframe"), counted(len(lexis_map.loops), "loop edge")
    print(f"{keyframes}, {loops}, rooms: {', '.join(instance_names(lexis_map.rooms))}")
    info = map_info(lexis_map)
    if info["path_m"] > _FAST_M_S * info["duration_s"] > 0.0:
        speed = f"{info['path_m'] / info['duration_s']:.0f} m/s on average"
        print(f"warning: the camera moves at {speed}; positions have to be in metres, and stamps in seconds")
    if carried := info["carried_before"]:
        print(f"the robot was carried {carried_text(carried)}; the poses after that are corrected")
    if missing := unused_names(lexis_map.room_names, lexis_map.rooms):
        print(f"no room: {', '.join(missing)}")
    if apart := sessions_apart(lexis_map):
        sessions = ", ".join(f"session {number}" for number in apart)
        print(f"not recognised in the rest of the map: {sessions}; no plan leads from there to the rest")
    elif (count := lexis_map.keyframes[-1].session + 1) > 1:
        print(f"all {count} sessions are joined in one map")
    print(folder)


def counted(number: int, noun: str) -> str:
    """Return "1 keyframe" or "3 keyframes"."""
    return f"{number} {noun}{'' if number == 1 else 's'}"
