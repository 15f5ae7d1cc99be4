"""A small SLAM program with one planted bug, which reads an EuRoC recording: `planted_program.py BUG DATASET OUT [TRUTH]`.

BUG is one of:

- `drift`: the program estimates the poses of the odometry as they are.
- `floors`: it numbers floors by the height of the odometry, but takes storeys for twice as high as they are.
- `open-plan`: it swaps the labels of two rooms where more than half of the boundary between them is open. A recording does
  not contain the labels, so this bug needs the file TRUTH, which `planted_commands.planted_command` writes for tests.
"""

import csv
import json
import sys
from pathlib import Path

_STOREY_M = 6.0
"""The wrong height of a storey [m]; houses have about 3 m."""


def odometry(dataset):
    """Stamps [s], and rows x, y, z, qw, qx, qy, qz of the odometry."""
    with open(dataset / "mav0" / "odom0" / "data.csv", encoding="utf-8") as file:
        rows = list(csv.reader(file))[1:]
    return [int(row[0]) / 1e9 for row in rows], [[float(value) for value in row[1:8]] for row in rows]


def floors(rows):
    """The number of the floor of every frame; the body begins on the lowest one."""
    return [{"floor": max(0, round((row[2] - rows[0][2]) / _STOREY_M))} for row in rows]


def swapped(stamps, truth):
    """The label of every frame by the truth, except in rooms that share an open boundary, whose labels are swapped."""
    labels = dict(truth["labels"])
    for a, b in truth["open"]:
        labels[a], labels[b] = truth["labels"][b], truth["labels"][a]
    rooms = [min(truth["frames"], key=lambda frame: abs(frame[0] - stamp))[1] for stamp in stamps]
    return [{"label": labels[room]} for room in rooms]


def main(bug, dataset, out, truth=None):
    """Read the recording and write the estimates."""
    stamps, rows = odometry(Path(dataset))
    lines = [
        f"{stamp:.6f} {x} {y} {z} {qx} {qy} {qz} {qw}\n"
        for stamp, (x, y, z, qw, qx, qy, qz) in zip(stamps, rows, strict=True)
    ]
    (Path(out) / "trajectory.tum").write_text("".join(lines))
    if bug != "drift":
        estimates = floors(rows) if bug == "floors" else swapped(stamps, json.loads(Path(truth).read_text(encoding="utf-8")))
        frames = [{"stamp": stamp, **estimate} for stamp, estimate in zip(stamps, estimates, strict=True)]
        (Path(out) / "rooms.json").write_text(json.dumps({"version": 1, "frames": frames}))


if __name__ == "__main__":
    main(*sys.argv[1:])
