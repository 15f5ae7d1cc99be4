"""The figures (measured numbers) of result.json, with the name, format and meaning that reports show for each figure."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

MISSING = "–"


@dataclass(frozen=True)
class Definition:
    """Name, number format and meaning that reports show for one figure of result.json."""

    name: str
    form: str
    """Format string of the value, for `str.format`."""
    meaning: str = ""


@dataclass(frozen=True)
class Figure:
    """One figure of a run, formatted for a reader."""

    name: str
    value: str
    meaning: str
    key: str
    """Name of the figure in result.json and in conditions, such as "rooms.pq"."""


_SHARE, _COUNT, _METRES, _SECONDS, _SCORE = "{:.1%}", "{:,}", "{:.3f} m", "{:.2f} s", "{:.3f}"
_SIGNED, _FACTOR = "{:+d}", "{:.2f} ×"
PLACES = "place_recognition"
"""Section of result.json on place recognition. Its keys are numbers N: a query counts as found if at least N of its proposed
matches are right."""

SECTIONS: dict[str, dict[str, Definition]] = {
    "coverage": {
        "rooms_visited": Definition("rooms in the map", _COUNT, "rooms on the walk that contain at least one keyframe"),
        "rooms": Definition("rooms on the walk", _COUNT, "rooms that the walk passes through"),
        "path_covered": Definition(
            "share of the walk",
            _SHARE,
            "share of the walk's length that lies between the first and the last keyframe, not counting gaps of more than "
            "3 m between keyframes; figures over keyframes say nothing about the rest of the walk",
        ),
    },
    "labels": {
        "accuracy": Definition(
            "label accuracy", _SHARE, "share of keyframes with the label of the true room that contains the camera"
        ),
        "accuracy_baseline": Definition(
            "… before refinement", _SHARE, "the same share for the labels before refinement, each from its own image alone"
        ),
        "accuracy_graded": Definition(
            "… graded",
            _SHARE,
            "the same share after refinement, but within 0.75 m of an open boundary the label of the room on either side "
            "counts as right",
        ),
    },
    "rooms": {
        "pq": Definition(
            "panoptic quality",
            _SCORE,
            "predicted and true rooms match where the IoU of their sets of keyframes is above 0.5; the figure is the sum of "
            "the matches' IoU divided by (matches + half of the rooms without a match); 1 is perfect",
        ),
        "precision": Definition("precision", _SHARE, "share of estimated rooms that have a match"),
        "recall": Definition("recall", _SHARE, "share of true rooms that have a match"),
        "hydra_precision": Definition(
            "Hydra's precision",
            _SHARE,
            "largest share of an estimated room that a single true room covers, averaged over the estimated rooms; splits "
            "do not lower it",
        ),
        "hydra_recall": Definition(
            "Hydra's recall",
            _SHARE,
            "largest share of a true room that a single estimated room covers, averaged over the true rooms; merges do not "
            "lower it",
        ),
        "ari": Definition(
            "adjusted Rand index",
            _SCORE,
            "agreement with the truth on which pairs of keyframes share a room; 0 is the level of chance, 1 is perfect",
        ),
        "v_measure": Definition(
            "V-measure", _SCORE, "harmonic mean of the homogeneity and the completeness of the estimated rooms; 1 is perfect"
        ),
        "splits": Definition(
            "splits",
            _COUNT,
            "number of estimated rooms that lie mostly (> half) in the same true room, not counting the first one in each",
        ),
        "merges": Definition(
            "merges",
            _COUNT,
            "number of true rooms that lie mostly (> half) in the same estimated room, not counting the first one in each",
        ),
        "count_error": Definition("count error", _SIGNED, "predicted minus true number of rooms that contain a keyframe"),
    },
    "floors": {
        "accuracy": Definition(
            "floor accuracy", _SHARE, "share of the keyframes off the stairs that are assigned to the right floor"
        ),
        "count_error": Definition("count error", _SIGNED, "predicted minus true number of floors that contain a keyframe"),
    },
    "loops": {
        "proposed": Definition(
            "proposed pairs", _COUNT, "candidate keyframe pairs that were passed to geometric verification"
        ),
        "verified": Definition("loop edges", _COUNT, "pairs that geometric verification accepted"),
        "true": Definition("true edges", _COUNT, "loop edges whose relative pose is within 0.5 m and 0.2 rad of the truth"),
        "false": Definition("false edges", _COUNT, "all other loop edges"),
        "precision": Definition("precision", _SHARE, "share of loop edges that are true"),
        "recall": Definition(
            "recall",
            _SHARE,
            "share of revisits from which a true edge leads to a keyframe at least 10 s earlier; a revisit is a keyframe "
            "whose true pose is within 1 m and 0.5 rad of one taken at least 10 s earlier",
        ),
        "error_m": Definition("position error", _METRES, "RMSE of the relative positions of true edges"),
        "error_rad": Definition("rotation error", "{:.4f} rad", "RMSE of the relative rotations of true edges"),
    },
    PLACES: {},
    "trajectory": {
        "ate_odometry_m": Definition(
            "ATE, odometry", _METRES, "RMSE of the keyframe positions after SE(3) alignment to the truth, without scaling"
        ),
        "ate_m": Definition("ATE", _METRES, "the same for the poses of the SLAM; `evo_ape tum -a` prints this value"),
        "rpe_8m_odometry_m": Definition(
            "RPE 8 m, odometry", _METRES, "RMSE of the translation error over stretches of 8 m of path"
        ),
        "rpe_8m_m": Definition("RPE 8 m", _METRES, "the same for the poses of the SLAM"),
        "rpe_24m_odometry_m": Definition(
            "RPE 24 m, odometry", _METRES, "RMSE of the translation error over stretches of 24 m of path"
        ),
        "rpe_24m_m": Definition("RPE 24 m", _METRES, "the same for the poses of the SLAM"),
    },
    "planning": {
        "queries": Definition(
            "queries", _COUNT, "room-to-room plans that were requested, and driven by a simulated robot if found"
        ),
        "success": Definition(
            "success",
            _SHARE,
            "share of queries whose plan begins in a room with the start's label, and after which the robot stood in a room "
            "with the goal's label and had touched nothing",
        ),
        "spl": Definition(
            "SPL",
            _SCORE,
            "success weighted by path length: mean over queries of shortest path / driven path, with 0 for a failure",
        ),
        "collisions": Definition("collisions", _COUNT, "drives that ended because the robot touched something"),
    },
    "run": {
        "path_m": Definition("path", "{:.1f} m", "length of the walk"),
        "duration_s": Definition("duration", "{:.0f} s", "simulated duration of the walk"),
        "frames": Definition("frames", _COUNT, "camera frames along the walk"),
        "keyframes": Definition("keyframes", _COUNT, "frames of the SLAM's estimate"),
    },
    "house": {
        "rooms": Definition("rooms", _COUNT, "rooms of the house, including stairs and gardens"),
        "floors": Definition("floors", _COUNT, "floors of the house"),
        "area_m2": Definition("area", "{:.1f} m²", "indoor floor area"),
        "openness": Definition(
            "openness",
            "{:.2f}",
            "open share of the area of the walls between rooms; 0: all rooms are behind doors, 1: no walls between rooms",
        ),
    },
    "time": {
        "house_s": Definition("house", _SECONDS, "generating, furnishing and checking the house, and planning the walk"),
        "scene_s": Definition("scene", _SECONDS, "building the MuJoCo model"),
        "render_s": Definition("rendering", _SECONDS, "rendering images, or drawing features in their place"),
        "start_s": Definition("start", _SECONDS, "starting the SLAM system, which may load models; once per process"),
        "slam_s": Definition("SLAM", _SECONDS, "all stages of the SLAM system, without its start"),
        "realtime_factor": Definition(
            "real-time factor", _FACTOR, "simulated duration divided by the SLAM's computing time"
        ),
    },
}
"""Definitions by section and key of result.json, in the order in which reports show them."""


def figures(result: Mapping[str, Any], section: str) -> list[Figure]:
    """Format the figures of a section of result.json. A figure without a definition is shown under its key."""
    if section == PLACES:
        return _places(result)
    known, values = SECTIONS[section], result.get(section) or {}
    keys = [*(key for key in known if key in values), *(key for key in values if key not in known)]
    rows = ((key, known.get(key, Definition(key.replace("_", " "), "{}")), values[key]) for key in keys)
    return [
        Figure(definition.name, shown(value, definition.form), definition.meaning, f"{section}.{key}")
        for key, definition, value in rows
        if not isinstance(value, Mapping | list | tuple | str)
    ]


def _places(result: Mapping[str, Any]) -> list[Figure]:
    """Return a figure for each number N of right matches: how many queries found N, of how many that could have found N."""
    return [
        Figure(
            f"found, N = {n}",
            f"{shown(counts.get('tp'), _COUNT)} of {shown(counts.get('possible'), _COUNT)}",
            f"queries with {n} or more right proposals, of those with {n} or more earlier keyframes within 1 m and 0.5 rad",
            f"{PLACES}.{n}.tp",
        )
        for n, counts in (result.get(PLACES) or {}).items()
    ]


def figure(result: Mapping[str, Any], section: str, key: str) -> str:
    """Format the value of one figure of result.json; a dash if the run does not have this figure."""
    return shown((result.get(section) or {}).get(key), SECTIONS[section][key].form)


def shown(value: object, form: str) -> str:
    """Format a value by the format string `form`. None, which means that the run has no such figure, becomes a dash."""
    if value is None:
        return MISSING
    if value == 0 and form == _SIGNED:
        return "0"
    if form == _FACTOR and isinstance(value, float) and value >= 100.0:
        form = "{:,.0f} ×"
    if form == "{}" and isinstance(value, float):
        form = "{:.4g}"
    return form.format(value)
