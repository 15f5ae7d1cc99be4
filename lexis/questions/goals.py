"""Goals in free words: "somewhere to wash my hands" becomes the name of a room in the map."""

from lexis.errors import PlanError
from lexis.perception import TextEncoder
from lexis.questions.answers import ask
from lexis.questions.calibration import Calibration
from lexis.room_names import instance_names, no_such_room
from lexis.types import LexisMap


def goal_in_words(map: LexisMap, text: str, encoder: TextEncoder, calibration: Calibration | None) -> str:
    """Return the name of the room that fits a description best, such as "bathroom 2".

    Raises:
        PlanError: no room of the map fits, or there is no calibration, without which it is unknown whether a room fits.
        LexisError: `ask` refuses the description.
    """
    names = instance_names(map.rooms)
    valid = f"valid: {', '.join(names)}, a label for its nearest room, or a description of what is there"
    if calibration is None:
        raise PlanError(
            f"{no_such_room(map.rooms, text)}, and descriptions need a calibration of encoder {encoder.name!r}; {valid}"
        )
    answer = ask(map, text, encoder, calibration)
    if answer.unknown:
        raise PlanError(f"{no_such_room(map.rooms, text)}, and no room fits these words; {valid}")
    return names[answer.rooms[0].room.id]
