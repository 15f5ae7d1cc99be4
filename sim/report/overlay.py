"""Makes the marks of a run on the plan of a storey: trajectories, loop edges, planned paths and labelled keyframes."""

from collections.abc import Iterator, Mapping
from itertools import count

import numpy as np
from jaxtyping import Bool, Float, Float64

from lexis.maths.stretches import true_stretches
from sim.report.data import PlanPath, ReportData
from sim.report.drawing import Mark
from sim.report.palette import estimated_room_colours
from worlds.truth import storey_of

_HEADING_M = 0.28
"""Length of the tick that shows where a keyframe's camera looks [m]."""
_CROSS_M = 0.16
"""Half the width of the cross that marks the end of a failed drive [m]."""
_NUMBER_M = 0.3
"""Height of the number beside the cross [m]."""


def run_marks(data: ReportData, level: int, colours: Mapping[str, str]) -> list[Mark]:
    """Return all marks of a run on one storey. `colours` maps labels to colours."""
    table = data.keyframes
    return [
        *_trajectory(table.true_poses, table.storeys == level, "true"),
        *_trajectory(table.odometry_poses, table.storeys == level, "odometry"),
        *(_trajectory(table.estimated_poses, table.storeys == level, "estimated") if data.estimates_poses else ()),
        *_plans(data, level),
        *_loops(data, level),
        *_keyframes(data, level, colours),
    ]


def _trajectory(poses: Float64[np.ndarray, "n 4 4"], here: Bool[np.ndarray, "n"], style: str) -> Iterator[Mark]:
    for part in true_stretches(here):
        yield Mark("line", style, poses[part, :2, 3])


def _plans(data: ReportData, level: int) -> Iterator[Mark]:
    """Yield the paths of all plans. Where the drive of a failed plan ended, a cross and the plan's number are added."""
    numbers, floors_m = count(1), [plan.floor_m for plan in data.plans]
    for path in data.paths:
        here, number = storey_of(path.points[:, 2], floors_m) == level, None if path.success else next(numbers)
        style, text = "plan-failed" if number else "plan", _fate(path, number)
        for part in true_stretches(here):
            yield Mark("line", style, path.points[part, :2], text=text)
        if number and len(here) and here[-1]:
            end = path.points[-1, :2]
            yield from _cross(end, text)
            yield Mark("text", "plan-number", end[None] + [1.4 * _CROSS_M, 0.0], text=str(number), size=_NUMBER_M)


def _fate(path: PlanPath, number: int | None) -> str:
    outcome = "reached" if path.success else path.reason or "not reached"
    return f"{f'failed plan {number}' if number else 'plan'}, {path.start} → {path.goal}: {outcome}"


def _cross(at: Float[np.ndarray, "2"], text: str) -> Iterator[Mark]:
    for slope in (-1.0, 1.0):
        yield Mark("line", "plan-end", at + np.outer([-_CROSS_M, _CROSS_M], [1.0, slope]), text=text)


def _loops(data: ReportData, level: int) -> Iterator[Mark]:
    table = data.keyframes
    positions = table.estimated_poses[:, :2, 3]
    for loop in data.loops:
        if level in table.storeys[[loop.query, loop.match]]:
            style, kind = ("loop-true", "true") if loop.true else ("loop-false", "FALSE")
            text = f"{kind} loop edge, keyframe {loop.query} to {loop.match}, weight {loop.weight:.2f}"
            yield Mark("line", style, positions[[loop.query, loop.match]], text=text)


def _keyframes(data: ReportData, level: int, colours: Mapping[str, str]) -> Iterator[Mark]:
    """Yield a dot at each keyframe's estimated position, with a tick for heading.

    The dot has the colour of the predicted label and, for readers who prefer it, of the estimated room. Without any labels,
    it has the colour of the estimated room only.
    """
    table, wrong, rooms = data.keyframes, data.keyframes.wrong, estimated_room_colours(data.keyframes)
    for k in np.flatnonzero(table.storeys == level):
        pose = table.estimated_poses[k]
        label, room = colours[data.shown_labels[table.predicted_labels[k]]], rooms.get(table.predicted_rooms[k])
        colour, other = (label, room) if table.is_labelled else (room or label, None)
        tick = pose[:2, 3] + np.outer([0, _HEADING_M], pose[:2, 0])
        yield Mark("line", "heading", tick, colour, room_colour=other)
        style, text = "wrong" if wrong[k] else "right", describe(data, int(k))
        yield Mark("dot", style, pose[None, :2, 3], colour, text, room_colour=other, keyframe=int(k))


def describe(data: ReportData, k: int) -> str:
    """Describe keyframe number `k` in one line: time, true and estimated room and label, and position errors."""
    table = data.keyframes
    names = data.shown_labels
    parts = [f"keyframe {k}, {table.stamps[k]:.1f} s", f"in {table.true_rooms[k]} ({names[table.true_labels[k]]})"]
    if table.is_labelled:
        before = f" (before refinement {names[table.baseline_labels[k]]})" if table.is_labelled_before else ""
        parts.append(f"says {names[table.predicted_labels[k]]}{before}")
    if table.has_rooms:
        parts.append(f"estimated {table.predicted_rooms[k]}" if table.predicted_rooms[k] else "in no estimated room")
    odometry = f"{table.odometry_errors[k]:.2f} m"
    parts.append(
        f"off by {table.estimated_errors[k]:.2f} m (odometry {odometry})"
        if data.estimates_poses
        else f"odometry off by {odometry}"
    )
    return " · ".join(parts)
