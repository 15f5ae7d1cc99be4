"""From a run to result.json: every figure by its definition in `lexis.evaluation`."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from lexis.evaluation.coverage import path_covered
from lexis.evaluation.floors import floor_accuracy, floor_count_error
from lexis.evaluation.labels import accuracy, accuracy_per_room, graded_accuracy
from lexis.evaluation.loops import score_loops
from lexis.evaluation.place_recognition import count_matches
from lexis.evaluation.planning import spl, success_rate
from lexis.evaluation.rooms import score_rooms
from lexis.evaluation.trajectory import ate_rmse, rpe_translation
from lexis.loop_arrays import LoopArrays
from lexis.maths.paths import arc_length
from lexis.place_recognition import old_enough
from sim.doctor import versions
from sim.faults import written
from sim.harness.config import RunConfig
from sim.harness.parts import slam_config
from sim.harness.planning import Trial, try_plans
from sim.harness.runner import Run, run
from worlds.labels import STAIRS
from worlds.truth import ambiguity_at, floor_area, openness

SCHEMA = 1
RPE_DELTAS_M = (8.0, 24.0)


def check(config: RunConfig) -> dict[str, Any]:
    """Run LEXIS on the scenario of `config`, drive its plans, and return the contents of result.json."""
    finished = run(config)
    return evaluate(finished, try_plans(finished))


def evaluate(run: Run, trials: Sequence[Trial]) -> dict[str, Any]:
    """The contents of result.json; a figure that the run cannot have is None."""
    return {
        "schema": SCHEMA,
        "seed": run.config.seed,
        "preset": None if run.config.house else run.config.preset,
        "fidelity": run.config.fidelity,
        "encoder": run.config.encoder,
        "odometry": run.config.odometry,
        "house": _house(run),
        "run": _walk(run),
        "labels": _labels(run),
        "rooms": asdict(score_rooms(run.map.room_of, run.true_rooms)),
        "floors": _floors(run),
        "loops": _loops(run),
        "place_recognition": _place_recognition(run),
        "coverage": _coverage(run),
        "trajectory": _trajectory(run),
        "planning": _planning(trials),
        "time": _time(run),
        "versions": versions(),
    } | ({"faults": _faults(run)} if run.config.faults else {})


def _faults(run: Run) -> dict[str, Any]:
    """Only of runs that have any."""
    touched = Counter(name for truth in run.delivered for name in truth.faults)
    return {
        "given": [written(fault) for fault in run.config.faults],
        "frames": {fault.name: touched[fault.name] for fault in run.config.faults},
        "delivered": len(run.delivered),
        "refused": len(run.refused),
    }


def _house(run: Run) -> dict[str, Any]:
    house = run.house
    return {
        "rooms": len(house.rooms),
        "floors": len(house.storeys),
        "area_m2": round(floor_area(house), 2),
        "openness": round(openness(house), 4),
        "spec": "house.json",
    }


def _walk(run: Run) -> dict[str, Any]:
    tour = run.session.tour
    return {
        "path_m": tour.length_m,
        "duration_s": float(tour.stamps[-1] - tour.stamps[0]),
        "frames": len(tour.stamps),
        "keyframes": len(run.map.keyframes),
    }


def _labels(run: Run) -> dict[str, Any]:
    allowed_rooms = ambiguity_at(run.house, run.true_poses[:, :3, 3])
    label_of_room = np.array([run.map.room_names.index(room.label) for room in run.house.rooms])
    allowed = np.stack([allowed_rooms[:, label_of_room == k].any(axis=1) for k in range(len(run.map.room_names))], axis=1)
    return {
        "accuracy": accuracy(run.map.labels, run.true_labels),
        "accuracy_baseline": accuracy(run.map.baseline_labels, run.true_labels),
        "accuracy_graded": graded_accuracy(run.map.labels, allowed),
        "per_room": accuracy_per_room(run.map.labels, run.true_labels, run.map.room_names),
    }


def _floors(run: Run) -> dict[str, Any]:
    on_stairs = np.array([run.house.rooms[room].label == STAIRS for room in run.true_rooms])
    return {
        "accuracy": floor_accuracy(run.map.floors, run.true_storeys, on_stairs),
        "count_error": floor_count_error(run.map.floors, run.true_storeys, on_stairs),
    }


def _loops(run: Run) -> dict[str, Any]:
    edges = LoopArrays.of(run.map.loops)
    return asdict(
        score_loops(
            sum(len(candidates) for _, candidates in run.map.candidates),
            edges.query,
            edges.match,
            edges.T_match_query,
            run.true_poses,
            run.stamps,
        )
    )


def _place_recognition(run: Run) -> dict[str, Any]:
    odometry, config = run.odometry_poses, slam_config(run.config).place_recognition
    path_m = arc_length(odometry[:, :3, 3])
    eligible = np.array([old_enough(query, run.stamps, path_m, config) for query in range(len(path_m))])
    return {str(n): asdict(count_matches(run.map.candidates, eligible, run.true_poses, n)) for n in (1, 3, 5)}


def _coverage(run: Run) -> dict[str, Any]:
    distances_m = run.session.tour.distances_m
    return {
        "rooms_with_keyframe": len(set(run.true_rooms.tolist())),
        "rooms_walked": len(run.walked_rooms),
        "path_covered": path_covered(distances_m[run.observed], float(distances_m[-1])),
    }


def _trajectory(run: Run) -> dict[str, Any]:
    truth, estimate = run.true_poses, run.map.T_W_B
    figures: dict[str, Any] = {
        "ate_odometry_m": ate_rmse(run.odometry_poses[:, :3, 3], truth[:, :3, 3]),
        "ate_m": ate_rmse(estimate[:, :3, 3], truth[:, :3, 3]),
    }
    for delta in RPE_DELTAS_M:
        figures[f"rpe_{delta:.0f}m_m"] = rpe_translation(estimate, truth, delta)
        figures[f"rpe_{delta:.0f}m_odometry_m"] = rpe_translation(run.odometry_poses, truth, delta)
    return figures


def _planning(trials: Sequence[Trial]) -> dict[str, Any]:
    success = np.array([trial.success for trial in trials], bool)
    shortest, travelled = np.array([(t.shortest_m, t.travelled_m) for t in trials], float).reshape(-1, 2).T
    return {
        "queries": len(trials),
        "success": success_rate(success),
        "spl": spl(success, shortest, travelled),
        "collisions": sum(trial.collisions for trial in trials) if trials else None,
    }


def _time(run: Run) -> dict[str, Any]:
    slam = sum(run.map.stage_seconds.values())
    return run.seconds | {
        "slam_s": slam,
        "stages_s": dict(run.map.stage_seconds),
        "realtime_factor": _walk(run)["duration_s"] / slam if slam else None,
    }
