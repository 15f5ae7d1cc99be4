"""What a run adds to the plan of a storey: trajectories, loop edges, planned paths and labelled keyframes."""

from collections.abc import Iterator, Mapping

import numpy as np
from jaxtyping import Bool, Float64, Int

from sim.report.data import PlanPath, ReportData
from sim.report.drawing import Mark
from worlds.truth import storey_of

MOST_PATHS = 12
"""More planned paths would hide the plan."""
_HEADING_M = 0.28


def run_marks(data: ReportData, level: int, colours: Mapping[str, str]) -> list[Mark]:
    """Everything of the run that belongs to a storey; of the planned paths the first few."""
    table = data.keyframes
    return [
        *_trajectory(table.true_poses, table.storeys == level, "true"),
        *_trajectory(table.odometry_poses, table.storeys == level, "odometry"),
        *_trajectory(table.optimised_poses, table.storeys == level, "optimised"),
        *(mark for path in data.paths[:MOST_PATHS] for mark in _path(path, level, [plan.floor_m for plan in data.plans])),
        *_loops(data, level),
        *_keyframes(data, level, colours),
    ]


def _trajectory(poses: Float64[np.ndarray, "n 4 4"], here: Bool[np.ndarray, "n"], style: str) -> Iterator[Mark]:
    for run in _runs(here):
        yield Mark("line", style, poses[run, :2, 3])


def _runs(here: Bool[np.ndarray, "n"]) -> list[Int[np.ndarray, "k"]]:
    """The stretches of consecutive rows that are here, of two rows or more."""
    rows = np.flatnonzero(here)
    return [run for run in np.split(rows, np.flatnonzero(np.diff(rows) > 1) + 1) if len(run) > 1]


def _path(path: PlanPath, level: int, floors_m: list[float]) -> Iterator[Mark]:
    here = storey_of(path.points[:, 2], floors_m) == level
    outcome = {True: "reached", False: "not reached", None: "not driven"}[path.success]
    for run in _runs(here):
        yield Mark("line", "path", path.points[run, :2], text=f"plan {path.start} → {path.goal}: {outcome}")


def _loops(data: ReportData, level: int) -> Iterator[Mark]:
    table = data.keyframes
    positions = table.optimised_poses[:, :2, 3]
    for loop in data.loops:
        if level in table.storeys[[loop.query, loop.match]]:
            style, kind = ("loop-true", "true") if loop.true else ("loop-false", "FALSE")
            text = f"{kind} loop edge, keyframe {loop.query} to {loop.match}, weight {loop.weight:.2f}"
            yield Mark("line", style, positions[[loop.query, loop.match]], text=text)


def _keyframes(data: ReportData, level: int, colours: Mapping[str, str]) -> Iterator[Mark]:
    """At the optimised pose, in the predicted label's colour."""
    table, wrong = data.keyframes, data.keyframes.wrong
    for k in np.flatnonzero(table.storeys == level):
        pose = table.optimised_poses[k]
        colour = colours[data.label_names[table.predicted_labels[k]]]
        yield Mark("line", "heading", pose[:2, 3] + np.outer([0, _HEADING_M], pose[:2, 0]), colour)
        style, text = "wrong" if wrong[k] else "right", describe(data, int(k))
        yield Mark("dot", style, pose[None, :2, 3], colour, text, keyframe=int(k))


def describe(data: ReportData, k: int) -> str:
    """One line on a keyframe."""
    table = data.keyframes
    rows = table.true_labels, table.baseline_labels, table.predicted_labels
    true, before, after = (data.label_names[labels[k]] for labels in rows)
    off, drift = (
        np.linalg.norm((poses[k] - table.true_poses[k])[:3, 3]) for poses in (table.optimised_poses, table.odometry_poses)
    )
    return (
        f"keyframe {k}, {table.stamps[k]:.1f} s · in {table.true_rooms[k]} ({true}) · says {after} "
        f"(before refinement {before}), room {table.predicted_rooms[k]} · off by {off:.2f} m (odometry {drift:.2f} m)"
    )
