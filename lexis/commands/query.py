"""`lexis query`: finds the rooms that fit a description."""

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from lexis.command_line import Commands, add_command, positive
from lexis.commands.arguments import CALIBRATION_HELP, MAP_ENCODER_HELP, map_encoder
from lexis.map.folder import load_map
from lexis.map.path_directions import name_and_floor
from lexis.types import LexisMap

if TYPE_CHECKING:
    from lexis.questions.answers import Answer

TEXT_HELP = "a question, in any words that the encoder understands; several are answered one after the other"
QUERY_NOTE = """\
Probabilities hold for houses like those of the calibration, if every second question has an answer. If no room reaches
0.5, nothing in the map fits. "not a kitchen" asks for all rooms that are no kitchens: each probability is that the room is
no kitchen, and each similarity is to a kitchen. A question that negates only a part of itself is refused. Without a
calibration, only similarities are shown. They can be compared within one question; one of them is always the largest, even
if no room fits. mini was trained on renders of generated houses; maps of photographs need real CLIP weights, and
'lexis-sim calibrate-queries' for them."""


def add_to(commands: Commands) -> None:
    """Add the command `query`."""
    query = add_command(
        commands, "query", _query, "the rooms that fit a description best", 'lexis query map "where can I wash my hands"'
    )
    query.epilog = f"{query.epilog}\n\n{QUERY_NOTE}"
    query.add_argument("map", type=Path, metavar="MAP")
    query.add_argument("text", nargs="+", metavar="TEXT", help=TEXT_HELP)
    query.add_argument("--encoder", help=MAP_ENCODER_HELP)
    query.add_argument("--calibration", type=Path, metavar="FILE", help=CALIBRATION_HELP)
    query.add_argument("--top", type=positive, default=3, help="rooms to list (default: %(default)s)")
    query.add_argument("--keyframes", type=positive, default=0, metavar="N", help="list the N best keyframes too")


def _query(arguments: argparse.Namespace) -> int:
    from lexis.questions.answers import ask
    from lexis.questions.calibration import find_calibration

    lexis_map = load_map(arguments.map)
    encoder = map_encoder(lexis_map, arguments.encoder)
    calibration = find_calibration(encoder, arguments.calibration)
    answers = [ask(lexis_map, text, encoder, calibration) for text in arguments.text]
    if calibration is None:
        print("no calibration for this encoder: similarities alone, see lexis query --help", file=sys.stderr)
    for text, answer in zip(arguments.text, answers, strict=True):
        if len(answers) > 1:
            print(f"{text}:")
        _print_answer(lexis_map, answer, arguments)
    return 0


def _print_answer(lexis_map: LexisMap, answer: "Answer", arguments: argparse.Namespace) -> None:
    """Print the rooms that fit best, and the keyframes that `--keyframes` asks for; or that nothing fits."""
    best = answer.rooms[0]
    if answer.unknown:
        name = name_and_floor(lexis_map, best.room.id)
        print(f"nothing in this map fits (best: {name}, probability {best.probability:.2f})")
        return
    for fit in answer.rooms[: arguments.top]:
        likely = "" if fit.probability is None else f"probability {fit.probability:.2f}  "
        name = name_and_floor(lexis_map, fit.room.id)
        print(f"{name:28s} {likely}similarity {fit.similarity:.3f}  keyframe {fit.keyframe}")
    room_of = lexis_map.room_of
    for i, similarity in answer.keyframes[: arguments.keyframes]:
        x, y, z = lexis_map.T_W_B[i, :3, 3]
        room = name_and_floor(lexis_map, int(room_of[i])) if room_of[i] >= 0 else "no room"
        print(f"keyframe {i:<19d} similarity {similarity:.3f}  {x:.2f} {y:.2f} {z:.2f} m  {room}")
