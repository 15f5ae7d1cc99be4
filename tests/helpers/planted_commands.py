"""Programs with a planted bug, as SLAM systems for `Program`."""

import json
import shlex
import sys
from pathlib import Path

from sim.harness.walk import walk
from sim.programs import Program
from sim.record.stamps import stamp_ns
from worlds.truth import boundary_openness, room_at

PROGRAM = Path(__file__).with_name("planted_program.py")


def program(bug):
    """The command that runs `planted_program` with a bug on a recording."""
    return f"{shlex.quote(sys.executable)} {shlex.quote(str(PROGRAM))} {bug} {{dataset}} {{out}}"


def planted_command(folder):
    """Runs `planted_program` with the bug `open-plan`, for which it writes the truth into a folder beside the recording."""
    path = folder / "truth.json"

    def runner(scenario, progress):
        walked = walk(scenario)
        house, tour = walked.house, walked.tour
        rooms = room_at(house, tour.T_W_B[:, :3, 3])
        truth = {
            "labels": {room.id: room.label for room in house.rooms},
            "open": [sorted(pair) for pair, share in boundary_openness(house).items() if share > 0.5],
            "frames": [[stamp_ns(t) / 1e9, house.rooms[room].id] for t, room in zip(tour.stamps, rooms, strict=True)],
        }
        path.write_text(json.dumps(truth))
        return Program(f"{program('open-plan')} {shlex.quote(str(path))}")(scenario, progress)

    return runner
