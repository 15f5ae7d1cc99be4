"""`lexis plan`: prints the shortest path between two rooms."""

import argparse
import json
from pathlib import Path

from lexis.command_line import Commands, add_command
from lexis.commands.arguments import CALIBRATION_HELP, JSON_HELP, add_settings, counted, map_encoder, settings
from lexis.errors import PlanError
from lexis.map.folder import load_map
from lexis.map.path_directions import directions, name_and_floor, plan_summary
from lexis.planning.planner import plan
from lexis.room_names import find_rooms, instance_names, no_such_room
from lexis.types import LexisMap

FROM_HELP = 'an instance ("office 2"), or a label ("office"): the instance with the shortest path to the goal is chosen'
TO_HELP = (
    "an instance, a label (the instance with the shortest path is chosen), or a description in several words. In --from and "
    "--to, an instance whose images resemble another room more is used only if the label has no other"
)
AVOID_HELP = "an instance, or a label (all its rooms), that the path must not enter; may be given several times"


def add_to(commands: Commands) -> None:
    """Add the command `plan`."""
    path = add_command(
        commands, "plan", _plan, "the shortest path between two rooms", "lexis plan map --from office --to kitchen"
    )
    path.add_argument("map", type=Path, metavar="MAP")
    path.add_argument("--from", dest="start", required=True, metavar="ROOM", help=FROM_HELP)
    path.add_argument("--to", dest="goal", required=True, metavar="ROOM", help=TO_HELP)
    path.add_argument("--avoid", action="append", default=[], metavar="ROOM", help=AVOID_HELP)
    add_settings(path, ", of which those of 'planner' are used")
    path.add_argument("--calibration", type=Path, metavar="FILE", help=CALIBRATION_HELP)
    path.add_argument("--keyframes", action="store_true", help="also list the keyframes on the path, with their positions")
    path.add_argument("--json", action="store_true", help=f"{JSON_HELP}, keyframes included")


def _plan(arguments: argparse.Namespace) -> int:
    lexis_map = load_map(arguments.map)
    _check_room(lexis_map, arguments.start, "or a label for its nearest room; only --to takes a description")
    goal = _goal(lexis_map, arguments.goal, arguments.calibration)
    _check_room(lexis_map, goal, "a label for its nearest room, or a description of several words")
    result = plan(lexis_map, arguments.start, goal, settings(arguments).planner, arguments.avoid)
    if arguments.json:
        print(json.dumps(plan_summary(lexis_map, result), indent=1))
        return 0
    begin, end = (name_and_floor(lexis_map, room.id) for room in (result.start, result.goal))
    print(f"{begin} to {end}: {result.length_m:.1f} m, {counted(len(result.keyframes), 'keyframe')}")
    for number, step in enumerate(directions(lexis_map, result), 1):
        print(f"{number:3d}. {step.at_m:6.1f} m  {step.text}")
    for i in result.keyframes if arguments.keyframes else ():
        x, y, z = lexis_map.T_W_B[i, :3, 3]
        print(f"keyframe {i:6d}  {x:8.2f} {y:8.2f} {z:8.2f} m  {lexis_map.label_of(i)}")
    return 0


def _check_room(lexis_map: LexisMap, name: str, more: str) -> None:
    """Raise PlanError unless the map has a room of this name; `more` says what else is valid."""
    rooms = lexis_map.rooms
    if not find_rooms(rooms, name):
        raise PlanError(f"{no_such_room(rooms, name)}; valid: {', '.join(instance_names(rooms))}, {more}")


def _goal(lexis_map: LexisMap, text: str, calibration: Path | None) -> str:
    """Return `text` if it is one word or the name of a room that may exist; otherwise, the name of the room it describes."""
    label, _, number = text.rpartition(" ")
    is_name = find_rooms(lexis_map.rooms, text) or (number.isdecimal() and find_rooms(lexis_map.rooms, label))
    if is_name or len(text.split()) < 2:
        return text
    from lexis.questions.calibration import find_calibration
    from lexis.questions.goals import goal_in_words

    encoder = map_encoder(lexis_map, None)
    return goal_in_words(lexis_map, text, encoder, find_calibration(encoder, calibration))
